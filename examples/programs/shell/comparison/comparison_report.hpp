#pragma once
#include "../csv.hpp"
#include "../protocol/tables.hpp"
#include "comparison.hpp"

namespace tapestry::shell {
namespace detail {
inline std::string percent_text(double share, const std::array<double, 2>& interval) {
  return fixed(100 * share, 1) + " " + interval_text(interval);
}

/// Shares of the fates in per cent, in their order.
inline std::string fates_text(const evaluate::FateCounts& fates) {
  std::string text;
  for (const std::size_t pictures : fates.pictures)
    text +=
        (text.empty() ? "" : " / ") + fixed(100 * static_cast<double>(pictures) /
                                                static_cast<double>(std::max<std::size_t>(1, fates.all())),
                                            0);
  return text;
}

inline std::string effect_text(const evaluate::PairedDifference& difference) {
  return fixed(difference.mean, 3) + " " + interval_text(difference.interval, 1, 3);
}

/// A figure of a texture, with its title, and a shorter one where it is a column.
struct TextureFigure {
  std::string title, column;
  std::string (*words_of)(const ComparedTexture&);
};

inline std::vector<TextureFigure> texture_figures(const Comparison& comparison) {
  std::vector<TextureFigure> figures{
      {"pictures in which the car is found, % (P@0.5), 95 %", "found, %, 95 %",
       [](const auto& texture) { return percent_text(texture.rate.p_at_50, texture.rate.interval); }},
      {"average precision, %: AP50 / AP50:95", "AP50 / AP50:95, %",
       [](const auto& texture) {
         return per_cent(texture.precision.ap50) + " / " + per_cent(texture.precision.ap);
       }},
      {"mean best confidence", "mean best confidence",
       [](const auto& texture) { return fixed(texture.mean_best_confidence, 3); }},
      {"found at a confidence above .05, %", "found above .05, %",
       [](const auto& texture) { return fixed(100 * texture.sweep.front().p_at_50, 1); }},
      {"pictures, %: found / related / renamed / misplaced / lost",
       "found / related / renamed / misplaced / lost, %",
       [](const auto& texture) { return fates_text(texture.fates); }}};
  if (comparison.maps_attention)
    figures.insert(figures.begin(), {"attention on the car, % of the heat map", "attention on the car, %",
                                     [](const auto& texture) { return fixed(100 * texture.attention, 1); }});
  return figures;
}

/// A figure of what a camouflage does; "-" where it was not measured.
struct EffectFigure {
  std::string title;
  std::string (*words_of)(const ComparedCell&);
};

inline std::vector<EffectFigure> effect_figures(const Comparison& comparison) {
  return {
      {"effect beyond matched noise, mean best confidence, 95 %",
       [](const auto& cell) { return effect_text(cell.effect.best_confidence); }},
      {"effect beyond matched noise, P@0.5 in points, 95 %",
       [](const auto& cell) { return percent_text(cell.effect.p_at_50.mean, cell.effect.p_at_50.interval); }},
      {"odds of being found, matched noise over camouflage, times, 95 %",
       [](const auto& cell) { return odds_text(cell.effect.odds_ratio); }},
      {"effect beyond noise drawn in each picture, P@0.5 in points, 95 %",
       [](const auto& cell) {
         const auto& noise = cell.picture_noise;
         return noise ? percent_text(noise->p_at_50.mean, noise->p_at_50.interval) : std::string("-");
       }},
      {"effect kept when photographed, %, 95 %",
       [](const auto& cell) {
         return cell.kept ? percent_text(cell.kept->ratio, cell.kept->interval) : std::string("-");
       }},
      {"mean best confidence of " + comparison.rows.front().name + " minus that of the row, 95 %",
       [](const auto& cell) {
         return cell.beyond_first ? effect_text(*cell.beyond_first) : std::string("-");
       }},
      {"attack success, % of the pictures found in clean, 95 %", [](const auto& cell) {
         return cell.success.views == 0 ? std::string("-")
                                        : percent_text(cell.success.rate, cell.success.interval);
       }}};
}

/// A texture with its results by column; null where it was not measured.
using TextureLine = std::pair<std::string, std::vector<const ComparedTexture*>>;

/// Every measured texture: those of no camouflage, then each row's, its matched noise, and the noise drawn in
/// each picture.
inline std::vector<TextureLine> texture_lines(const Comparison& comparison) {
  std::vector<TextureLine> lines;
  const auto add = [&](const std::string& name, const auto& cells, auto texture_of) {
    TextureLine line{name, std::vector<const ComparedTexture*>(comparison.columns.size(), nullptr)};
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (cells[i]) line.second[i] = texture_of(*cells[i]);
    if (std::ranges::any_of(line.second, [](const auto* texture) { return texture != nullptr; }))
      lines.push_back(std::move(line));
  };
  for (const auto& [name, cells] : comparison.plain)
    add(name, cells, [](const auto& found) { return &found; });
  for (const auto& row : comparison.rows) {
    add(row.name, row.cells, [](const auto& cell) { return &cell.camouflage; });
    add(row.name + ", matched noise", row.cells, [](const auto& cell) { return &cell.noise; });
    add(row.name + ", noise in each picture", row.cells,
        [](const auto& cell) { return cell.picture_noise ? &cell.picture_noise->texture : nullptr; });
  }
  return lines;
}

inline WordTable table_by_column(const Comparison& comparison, const std::string& title) {
  WordTable table{title, comparison.columns};
  table.header.insert(table.header.begin(), "");
  return table;
}

/// Adds a line by column. \param words_of  returns the words of a column
template <class WordsOf>
void add_line(WordTable& table, const std::string& name, WordsOf words_of) {
  std::vector<std::string> words{name};
  for (std::size_t column = 0; column + 1 < table.header.size(); ++column) words.push_back(words_of(column));
  table.rows.push_back(std::move(words));
}

/// Whether a line of a table has nothing beside its name.
inline bool is_blank(const std::vector<std::string>& line) {
  return std::ranges::count(line, std::string("-")) + 1 == static_cast<long>(line.size());
}

/// Adds the words of each row of a comparison, or of its only one under the name of the figure.
inline void add_effects(WordTable& table, const Comparison& comparison, const EffectFigure& figure) {
  for (const auto& row : comparison.rows)
    add_line(table, comparison.rows.size() == 1 ? figure.title : row.name, [&](std::size_t column) {
      return column < row.cells.size() && row.cells[column] ? figure.words_of(*row.cells[column])
                                                            : std::string("-");
    });
}

/// The tables of a comparison of one row: its textures, and its effects.
inline std::vector<WordTable> tables_of_row(const Comparison& comparison) {
  const std::string& name = comparison.rows.front().name;
  WordTable textures{name + ": by the car's paint", {""}},
      effects = table_by_column(comparison, name + ": effects");
  const auto figures = texture_figures(comparison);
  for (const auto& column : comparison.columns)
    for (const auto& figure : figures)
      textures.header.push_back((comparison.columns.size() == 1 ? "" : column + ": ") + figure.column);
  for (const auto& line : texture_lines(comparison))
    add_line(textures, line.first, [&](std::size_t i) {
      const auto* texture = line.second[i / figures.size()];
      return texture == nullptr ? std::string("-") : figures[i % figures.size()].words_of(*texture);
    });
  for (const auto& figure : effect_figures(comparison)) add_effects(effects, comparison, figure);
  std::erase_if(effects.rows, is_blank);
  return {std::move(textures), std::move(effects)};
}
}  // namespace detail

/// The tables of a comparison, one figure each, or two of one row alone; without those that have no words.
inline std::vector<WordTable> comparison_tables(const Comparison& comparison) {
  if (comparison.rows.size() == 1) return detail::tables_of_row(comparison);
  std::vector<WordTable> tables;
  const auto lines = detail::texture_lines(comparison);
  for (const auto& figure : detail::texture_figures(comparison)) {
    tables.push_back(detail::table_by_column(comparison, figure.title));
    for (const auto& line : lines)
      detail::add_line(tables.back(), line.first, [&](std::size_t column) {
        const auto* texture = line.second[column];
        return texture == nullptr ? std::string("-") : figure.words_of(*texture);
      });
  }
  for (const auto& figure : detail::effect_figures(comparison)) {
    tables.push_back(detail::table_by_column(comparison, figure.title));
    detail::add_effects(tables.back(), comparison, figure);
  }
  std::erase_if(tables,
                [](const WordTable& table) { return std::ranges::all_of(table.rows, detail::is_blank); });
  return tables;
}

namespace detail {
/// Fields of a texture, in the order of comparison_csv().
inline std::string csv_fields(const ComparedTexture& texture) {
  std::vector<double> sweep;
  for (const auto& rate : texture.sweep) sweep.push_back(rate.p_at_50);
  const auto& rate = texture.rate;
  return csv_line(rate.views, rate.detected, rate.p_at_50, rate.interval, texture.mean_best_confidence,
                  std::span(texture.fates.pictures).subspan(1), sweep, texture.attention,
                  precision_fields(texture.precision));
}

inline std::string csv_fields(const ComparedCell& cell) {
  const auto& [control, confidence, rate, draws, draws_at_most, odds] = cell.effect;
  const auto three = [](const auto& share, auto value) {
    return share ? csv_line((*share).*value, share->interval) : std::string(",,");
  };
  std::optional<evaluate::PairedDifference> in_picture;
  if (cell.picture_noise) in_picture = cell.picture_noise->p_at_50;
  return csv_line(confidence.mean, confidence.interval, rate.mean, rate.interval, cell.success.views,
                  cell.success.hidden, cell.success.rate, cell.success.interval,
                  three(cell.kept, &evaluate::PairedRatio::ratio),
                  three(cell.beyond_first, &evaluate::PairedDifference::mean), odds.ratio, odds.interval,
                  three(in_picture, &evaluate::PairedDifference::mean));
}

inline std::string csv_header() {
  std::string header =
      "row,measured_with,texture,seeds,draws,pictures,detected,p_at_50,p_at_50_low,p_at_50_high,"
      "mean_best_confidence,related,renamed,misplaced,lost";
  for (const double threshold : swept_thresholds)
    header += ",p_at_50_above_" + evaluate::detail::short_number(threshold);
  return header +
         ",attention,ap50,ap,effect,effect_low,effect_high,effect_p_at_50,effect_p_at_50_low,effect_p_at_50_"
         "high,"
         "detected_in_clean,hidden,asr,asr_low,asr_high,kept,kept_low,kept_high,first_minus,first_minus_low,"
         "first_minus_high,odds_ratio,odds_ratio_low,odds_ratio_high,effect_picture,effect_picture_low,"
         "effect_picture_high\n";
}
}  // namespace detail

/// The order of the rows by four measures of their effect, in each column where the measures
/// put different rows first.
inline std::vector<std::string> contradictions(const Comparison& comparison) {
  using Measure = double (*)(const ComparedCell&);
  const std::array<std::pair<const char*, Measure>, 4> measures{
      {{"effect on mean best confidence", [](const auto& cell) { return cell.effect.best_confidence.mean; }},
       {"effect on P@0.5", [](const auto& cell) { return cell.effect.p_at_50.mean; }},
       {"odds", [](const auto& cell) { return cell.effect.odds_ratio.ratio; }},
       {"attack success", [](const auto& cell) { return cell.success.rate; }}}};
  std::vector<std::string> sentences;
  for (std::size_t column = 0; column < comparison.columns.size(); ++column) {
    std::vector<const ComparedRow*> rows;
    for (const auto& row : comparison.rows)
      if (column < row.cells.size() && row.cells[column]) rows.push_back(&row);
    std::vector<std::size_t> times_first(rows.size(), 0);  // equals are first together
    std::string text;
    for (const auto& [name, measure] : measures) {
      const Measure of_cell = measure;  // clang 14 captures no structured binding
      const auto value = [&](const ComparedRow* row) { return of_cell(*row->cells[column]); };
      auto sorted = rows;
      std::ranges::stable_sort(sorted, std::greater{}, value);
      for (std::size_t i = 0; i < rows.size(); ++i)
        times_first[i] += value(rows[i]) == value(sorted.front()) ? 1U : 0U;
      text += std::string(text.empty() ? "" : "; ") + "by " + name + " " + listed(sorted, &ComparedRow::name);
    }
    if (!rows.empty() && std::ranges::find(times_first, measures.size()) == times_first.end())
      sentences.push_back(comparison.columns[column] + ": the measures rank different rows first; " + text +
                          ". Rows whose intervals overlap have no order.");
  }
  return sentences;
}

/// A line for each row, detector and texture: those without a camouflage, the camouflage, its matched noise
/// and the noise drawn in each picture. Effects stand in the camouflage's.
inline std::string comparison_csv(const Comparison& comparison) {
  const std::string none = std::string(23, ',') + "\n";
  std::string text = detail::csv_header();
  const auto line = [&](const std::string& row, std::size_t column, const std::string& texture,
                        std::size_t seeds, std::size_t draws, const ComparedTexture& compared) {
    return csv_line(csv_field(row), csv_field(comparison.columns[column]), texture, seeds, draws,
                    detail::csv_fields(compared));
  };
  for (const auto& [name, cells] : comparison.plain)
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (cells[i]) text += line(name, i, name, 1, 1, *cells[i]) + none;
  for (const auto& row : comparison.rows)
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      if (!row.cells[i]) continue;
      const ComparedCell& cell = *row.cells[i];
      text += csv_line(line(row.name, i, "adversarial", cell.seeds, 1, cell.camouflage),
                       detail::csv_fields(cell)) +
              "\n" + line(row.name, i, evaluate::matched_noise_name, cell.seeds, cell.draws, cell.noise) +
              none;
      if (cell.picture_noise)
        text += line(row.name, i, evaluate::picture_noise_name, cell.seeds, 1, cell.picture_noise->texture) +
                none;
    }
  return text;
}
}  // namespace tapestry::shell
