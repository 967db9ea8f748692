#pragma once
#include "../protocol/report.hpp"
#include "comparison_report.hpp"

namespace tapestry::shell {
namespace detail {
/// One column: for each row the share of pictures in which the car is found with the camouflage and with its
/// noises, and the odds between them; of an attention, the share that lies on the car instead. "-" stands for
/// what was not measured, and for odds that cannot be read.
inline Panel comparison_panel(const Comparison& comparison, std::size_t column) {
  std::size_t longest = 15;  // name of a row
  for (const auto& row : comparison.rows) longest = std::max(longest, row.name.size());
  const double left = 25 + 7.5 * static_cast<double>(longest), right = left + 270, top = 34, row_height = 38;
  const auto shown = [&](const ComparedTexture& texture) {
    return comparison.maps_attention ? texture.attention : texture.rate.p_at_50;
  };
  const double bottom = top + row_height * static_cast<double>(comparison.rows.size());
  const auto x = [=](double share) { return left + share * (right - left); };
  std::string svg = svg_text(14, 18, "title", comparison.columns[column]) + share_axis(x, top, bottom);
  for (const auto& [name, cells] : comparison.plain)
    if (name == "clean" && column < cells.size() && cells[column])
      svg += svg_line(x(shown(*cells[column])), top, x(shown(*cells[column])), bottom, "ink");
  if (!comparison.maps_attention) svg += svg_text(right + 14, top - 6, "muted", "odds, times");
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const auto& row = comparison.rows[i];
    const double middle = top + row_height * (static_cast<double>(i) + 0.5);
    svg += svg_text(left - 8, middle + 4, "end", row.name);
    if (column >= row.cells.size() || !row.cells[column]) {
      svg += svg_text(left + 6, middle + 4, "muted", "- not measured");
      continue;
    }
    const ComparedCell& cell = *row.cells[column];
    const auto bar = [&](double y, const ComparedTexture& texture, const char* style) {
      svg += svg_rectangle(left, middle + y, x(shown(texture)) - left, 9, style);
      if (!comparison.maps_attention) svg += svg_interval(x, texture.rate.interval, middle + y + 4.5);
    };
    bar(-15, cell.camouflage, "class=\"second\"");
    bar(-5, cell.noise, "class=\"third\"");
    if (cell.picture_noise) bar(5, cell.picture_noise->texture, "class=\"first\"");
    if (!comparison.maps_attention)
      svg += svg_text(right + 14, middle + 4, "", odds_text(cell.effect.odds_ratio));
  }
  return {right + (comparison.maps_attention ? 30 : 190), bottom + 26, svg};
}
}  // namespace detail

/// How often the car is found in every row, or how much of the attention lies on it, a panel for each column.
inline Figure comparison_figure(const Comparison& comparison, const std::string& title) {
  Figure figure{
      title,
      {},
      {{{"class=\"second\"", "camouflage"}, {"class=\"third\"", "its matched noise"}},
       comparison.maps_attention
           ? "attention on the car, share of the heat map; the line is the clean car's"
           : "pictures in which the car is found; lines: 95 %, upright the clean car's; odds of being found, "
             "matched noise over camouflage, 95 %: - where they may be below a tenth as well as above ten"},
      2};
  for (std::size_t column = 0; column < comparison.columns.size(); ++column)
    figure.panels.push_back(detail::comparison_panel(comparison, column));
  if (has_picture_noise(comparison))
    figure.legend.keys.emplace_back("class=\"first\"", "noise drawn in each picture");
  return figure;
}

struct ComparisonWords {
  std::string name;  ///< of its files
  std::string title;
  std::vector<std::string> notes{};
  std::string command{};  ///< that makes it again
};

namespace detail {
inline std::string path_from(const std::string& folder, const std::string& path) {
  std::error_code failure;
  const auto relative = std::filesystem::relative(io::path_of(path), io::path_of(folder), failure);
  return failure || relative.empty() ? path : relative.generic_string();
}

inline std::string link_to(const std::string& address, const std::string& words) {
  return "<a href=\"" + escaped(address) + "\">" + escaped(words) + "</a>";
}

/// Links to the measurements and runs of a row, and a picture of its first.
inline std::string row_html(const Json& row) {
  std::string html = "<li>" + escaped(row.at("name").get<std::string>()) + ": measured in";
  for (const auto& folder : row.at("measured"))
    html += " " + link_to(folder.at("page").get<std::string>(), folder.at("name").get<std::string>());
  if (row.at("runs").empty()) return html + "; a paint of others</li>\n";
  html += "; optimised in";
  for (const auto& run : row.at("runs"))
    html += " " + link_to(run.at("page").get<std::string>(), run.at("name").get<std::string>());
  const auto picture = row.at("runs").front().at("picture").get<std::string>();
  return html + "<br><img loading=\"lazy\" width=\"320\" alt=\"\" src=\"" + escaped(picture) + "\"></li>\n";
}

/// The part of a page about one comparison. \param json  as comparison_json() writes it
inline std::string section_html(const std::string& name, const Json& json) {
  std::string html =
      "<h2 id=\"" + escaped(name) + "\">" + escaped(json.at("title").get<std::string>()) +
      "</h2>\n<div class=\"wide figure\" tabindex=\"0\"><img alt=\"the figure of the tables below\" src=\"" +
      escaped(name) + ".svg\"></div>\n";
  html += "<div class=\"panels\">\n";
  for (const auto& table : json.at("tables"))
    html += html_of({table.at("title"), table.at("header"), table.at("rows")});
  html += "</div>\n<ul>\n";
  for (const auto& note : json.at("notes")) html += "<li>" + escaped(note.get<std::string>()) + "</li>\n";
  html += "</ul>\n<details><summary>Runs and pictures</summary><ul>\n";
  for (const auto& row : json.at("rows")) html += row_html(row);
  html += "</ul></details>\n";
  if (const auto command = json.at("command").get<std::string>(); !command.empty())
    html += "<pre>" + escaped(command) + "</pre>\n";
  html += "<p>" + link_to(name + ".csv", "CSV") + " " + link_to(name + ".json", "JSON") + " " +
          link_to(name + ".md", "Markdown") + " " + link_to(name + ".tex", "LaTeX") + " " +
          link_to(name + ".svg", "SVG") + "</p>\n";
  return html;
}
}  // namespace detail

/// The tables, the notes, and where each row's figures come from; paths are relative to the folder.
inline Json comparison_json(const std::string& folder, const Comparison& comparison,
                            const std::vector<WordTable>& tables, const ComparisonWords& words) {
  Json json = {
      {"program", "tabulate"}, {"title", words.title}, {"notes", words.notes}, {"command", words.command}};
  for (const auto& table : tables)
    json["tables"].push_back({{"title", table.title}, {"header", table.header}, {"rows", table.rows}});
  for (const auto& row : comparison.rows) {
    Json entry = {
        {"name", row.name}, {"measured", Json::array()}, {"runs", Json::array()}};  // runs: none of a picture
    for (const auto& measured : row.folders) {
      const std::string path = detail::path_from(folder, measured);
      entry["measured"].push_back({{"name", path}, {"page", path}});
    }
    for (const auto& run : row.runs) {
      const std::string path = detail::path_from(folder, run);
      entry["runs"].push_back(
          {{"name", path}, {"page", path + "/report.html"}, {"picture", path + "/after.png"}});
    }
    json["rows"].push_back(entry);
  }
  json["made_by"] = comparison.made_by;
  json["computed_by"] = computed_by_json();
  return json;
}

inline std::string comparison_markdown(const std::vector<WordTable>& tables, const ComparisonWords& words) {
  const std::string title = markdown_escaped(words.title);
  std::string text = "# " + title + "\n\n![" + title + "](<" + markdown_escaped(words.name) + ".svg>)\n\n";
  for (const auto& table : tables) text += markdown_of(table);
  for (const auto& note : words.notes) text += "- " + markdown_escaped(note) + "\n";
  std::string command = words.command;
  for (char& c : command) c = c == '\n' || c == '\r' ? ' ' : c;
  return text + (command.empty() ? "" : "\n    " + command + "\n");
}

/// A page over all comparisons of a folder, in the order of their names.
inline std::string comparisons_page(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(io::path_of(folder)))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::ranges::sort(files);
  std::string contents, sections;
  for (const auto& file : files) {
    const Json json = read_json_file(file.string());
    if (!json.is_object() || json.value("program", Json()) != "tabulate") continue;
    const std::string name = file.stem().string();
    contents += "<li>" + detail::link_to("#" + name, json.at("title").get<std::string>()) + "</li>\n";
    sections += detail::section_html(name, json);
  }
  constexpr const char* style = "@media (max-width: 60em) { .figure img { max-width: none } }\n";
  return page_begin("Tables", std::string(protocol_style) + style) + "<ul>\n" + contents + "</ul>\n" +
         sections + "</body></html>\n";
}

/// Writes the files of a comparison into a folder, and the page over all comparisons there.
/// \param tables  see comparison_tables()
inline void write_comparison(const std::string& folder, const Comparison& comparison,
                             const std::vector<WordTable>& tables, const ComparisonWords& words) {
  const std::string stem = folder + "/" + words.name;
  std::string latex;
  for (const auto& table : tables) latex += latex_of(table);
  write_text(stem + ".csv", comparison_csv(comparison));
  write_text(stem + ".md", comparison_markdown(tables, words));
  write_text(stem + ".tex", latex);
  write_text(stem + ".svg", figure_svg(comparison_figure(comparison, words.title)));
  write_text(stem + ".json", report_text(comparison_json(folder, comparison, tables, words)));
  write_text(folder + "/index.html", comparisons_page(folder));
}
}  // namespace tapestry::shell
