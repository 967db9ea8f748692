#pragma once
#include "../csv.hpp"
#include "../inputs_table.hpp"
#include "../page.hpp"
#include "../report_script.hpp"
#include "../view_list.hpp"
#include "tables.hpp"

namespace tapestry::shell {
inline std::vector<WordTable> section_tables(const Protocol& protocol, const ProtocolResult& result) {
  std::vector<WordTable> tables;
  for (const auto& section : result.sections)
    if (!section.attention.empty()) tables.push_back(attention_table(result, section));
  for (const auto& section : result.sections) tables.push_back(summary_table(protocol, result, section));
  for (std::size_t i = 0; i < result.sections.size(); ++i) tables.push_back(fates_table(result, i));
  if (const WordTable effects = effect_table(result); !effects.rows.empty()) tables.push_back(effects);
  for (const auto& section : result.sections) tables.push_back(sweep_table(result, section));
  return tables;
}

inline std::string protocol_text(const Protocol& protocol, const ProtocolResult& result,
                                 const std::vector<std::string>& notes) {
  std::string text;
  for (const auto& words : verdicts(result)) text += words + "\n\n";
  for (const auto& table : section_tables(protocol, result)) text += text_of(table) + "\n";
  if (!protocol.on_photographs) {
    for (const std::size_t k : result.shown_textures())
      text += text_of(share_grid(protocol, result, k, result.is_attack(k), false)) + "\n";
  }
  for (const auto& words : findings(protocol, result)) text += words + "\n";
  for (const auto& note : notes) text += "- " + note + "\n";
  return text;
}

/// Tables with intervals: how often the car is found with each texture, and how often each texture hides it.
/// For photographs the sections are the cells.
inline std::vector<WordTable> all_tables(const Protocol& protocol, const ProtocolResult& result) {
  auto tables = section_tables(protocol, result);
  if (protocol.on_photographs) return tables;
  tables.push_back(share_grid(protocol, result, 0, false, true));
  for (std::size_t k = 1; k < result.textures.size(); ++k)
    if (result.is_attack(k)) tables.push_back(share_grid(protocol, result, k, true, true));
  for (const std::size_t k : result.shown_textures())
    if (k > 0) tables.push_back(share_grid(protocol, result, k, false, true));
  return tables;
}

inline std::string protocol_markdown(const Protocol& protocol, const ProtocolResult& result,
                                     const std::vector<std::string>& notes) {
  std::string text = "# " + protocol.title + "\n\n";
  for (const auto& words : verdicts(result)) text += "**" + markdown_escaped(words) + "**\n\n";
  text += "![" + protocol.title + "](" + protocol.name + ".svg)\n\n";
  for (const auto& table : all_tables(protocol, result)) text += markdown_of(table);
  for (const auto& words : findings(protocol, result)) text += "**" + markdown_escaped(words) + "**\n\n";
  for (const auto& note : notes) text += "- " + markdown_escaped(note) + "\n";
  return text + "- Every cell with every texture: " + protocol.name + ".csv.\n";
}

inline std::string csv_row(const std::string& name, const evaluate::Cell& cell, const ProtocolResult& result,
                           std::size_t k) {
  const auto& [rate, confidence, success, fates, precision] = cell.textures[k];
  const bool is_attack = result.is_attack(k) && success.views > 0;
  return csv_line(name, result.textures[k], cell.measured, cell.left_out, cell.mean_hidden_share,
                  rate.detected, rate.p_at_50, rate.interval, confidence, success.views,
                  is_attack ? csv_line(success.hidden, success.rate, success.interval) : std::string(",,,"),
                  std::span(fates.pictures).subspan(1), precision_fields(precision)) +
         "\n";
}

inline Json cell_json(const evaluate::Cell& cell, const ProtocolResult& result) {
  Json json = {
      {"frames", cell.measured}, {"left_out", cell.left_out}, {"mean_hidden_share", cell.mean_hidden_share}};
  for (std::size_t k = 0; k < result.textures.size(); ++k) {
    const auto& [rate, confidence, success, fates, precision] = cell.textures[k];
    Json texture = {{"detected", rate.detected},
                    {"p_at_50", rate.views > 0 ? Json(rate.p_at_50) : Json()},
                    {"interval", rate.interval},
                    {"mean_best_confidence", confidence}};
    texture["fates"] = json_of(fates);
    add_json(texture, precision);
    if (result.is_attack(k))
      texture["attack_success"] = {{"views", success.views},
                                   {"hidden", success.hidden},
                                   {"rate", success.views > 0 ? Json(success.rate) : Json()},
                                   {"interval", success.interval}};
    json["textures"][result.textures[k]] = texture;
  }
  return json;
}

inline Json section_json(const ProtocolSection& section, const ProtocolResult& result) {
  Json json = {{"name", section.name}};
  json.update(cell_json(section.cell, result));
  for (std::size_t k = 0; k < section.attention.size(); ++k)
    json["attention"][result.textures[k]] = {{"share", section.attention[k].mean},
                                             {"less_than_clean", section.attention[k].lost.mean},
                                             {"interval", section.attention[k].lost.interval}};
  json["car_share"] = section.car_share;
  json["effect"] = section.effect ? json_of(*section.effect) : Json();
  for (std::size_t k = 0; k < result.textures.size(); ++k)
    for (std::size_t i = 0; i < swept_thresholds.size(); ++i)
      json["sweep"][result.textures[k]].push_back(
          {{"confidence", swept_thresholds[i]}, {"p_at_50", section.sweep[k][i].p_at_50}});
  return json;
}

/// One row per cell and texture; renders have rows for the whole or for each part behind them. Shares are in
/// 0 to 1, and empty where they are not defined.
inline std::string protocol_csv(const Protocol& protocol, const ProtocolResult& result) {
  const auto& table = protocol.table;
  std::string text =
      table.row_title + "," + table.column_title +
      ",texture,frames,left_out,mean_hidden_share,detected,p_at_50,p_at_50_low,p_at_50_high,mean_best_"
      "confidence,detected_in_clean,hidden,asr,asr_low,asr_high,related,renamed,misplaced,lost,ap50,ap\n";
  for (std::size_t cell = 0; cell < result.cells.size(); ++cell)
    for (std::size_t k = 0; k < result.textures.size(); ++k)
      text += csv_row(csv_field(table.rows[cell / table.columns.size()]) + "," +
                          csv_field(table.columns[cell % table.columns.size()]),
                      result.cells[cell], result, k);
  if (protocol.on_photographs) return text;
  for (const auto& section : result.sections)
    for (std::size_t k = 0; k < result.textures.size(); ++k)
      text += csv_row((protocol.parts.empty() ? "all" : section.name) + ",all", section.cell, result, k);
  return text;
}

/// \param settings  the options, and the hashes of the inputs
inline Json protocol_json(const Protocol& protocol, const ProtocolResult& result,
                          const std::vector<std::string>& notes, const Json& settings) {
  const auto& table = protocol.table;
  Json json = {{"protocol", protocol.name},
               {"verdicts", verdicts(result)},
               {"textures", result.textures},
               {"notes", notes}};
  const auto worst = worst_cell(protocol, result);
  json["worst_cell"] = worst ? Json{{table.row_title, table.rows[*worst / table.columns.size()]},
                                    {table.column_title, table.columns[*worst % table.columns.size()]}}
                             : Json();
  if (result.effect_kept)
    json["effect_kept"] = {{"ratio", result.effect_kept->ratio}, {"interval", result.effect_kept->interval}};
  for (const auto& section : result.sections) json["sections"].push_back(section_json(section, result));
  for (std::size_t cell = 0; cell < result.cells.size(); ++cell) {
    Json entry = {{table.row_title, table.rows[cell / table.columns.size()]},
                  {table.column_title, table.columns[cell % table.columns.size()]}};
    entry.update(cell_json(result.cells[cell], result));
    json["cells"].push_back(entry);
  }
  json["settings"] = settings;
  json["computed_by"] = computed_by_json();
  return json;
}

inline constexpr const char* protocol_style =
    R"(.panels { display: flex; flex-wrap: wrap; gap: 0 1em } .panels > * { min-width: 0; max-width: 100% }
svg, img { max-width: 100%; height: auto; display: block }
figcaption { font-weight: bold; color: inherit } .verdict { font-size: 19px }
)";

/// A page with figure, tables and each frame; without any other file.
/// \param list    the frames with the textures that figures show; left out if it is empty
/// \param inputs  see recorded_inputs()
inline std::string protocol_html(const Protocol& protocol, const ProtocolResult& result,
                                 const std::vector<std::string>& notes, const ViewList& list,
                                 const Json& inputs) {
  const Figure figure = protocol.figure(protocol, result);
  std::string page = page_begin(protocol.title, std::string(list_style) + figure_style + protocol_style);
  for (const auto& words : verdicts(result)) page += "<p class=\"verdict\">" + escaped(words) + "</p>\n";
  page += "<h2>" + escaped(figure.title) + "</h2>\n" + figure_html(figure);
  for (const auto& [words, png] : result.pictures)
    page += "<h2>" + escaped(words) + "</h2>\n<img alt=\"" + escaped(words) +
            "\" src=\"data:image/png;base64," + base64(png) + "\">\n";
  page += "<h2>Tables</h2>\n";
  for (const auto& table : all_tables(protocol, result)) page += html_of(table);
  for (const auto& words : findings(protocol, result)) page += "<p><b>" + escaped(words) + "</b></p>\n";
  page += "<ul>\n";
  for (const auto& note : notes) page += "<li>" + escaped(note) + "</li>\n";
  page += "</ul>\n" + inputs_html(inputs);
  return page + (list.views.empty() ? "</body></html>\n" : list_html(list, "") + page_end(list_json(list)));
}
}  // namespace tapestry::shell
