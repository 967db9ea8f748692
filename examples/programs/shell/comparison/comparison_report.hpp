#pragma once

#include "../csv.hpp"
#include "../protocol/tables.hpp"
#include "comparison.hpp"

namespace tapestry::shell {

namespace detail {

inline std::string percent_text(double share, const std::array<double, 2>& interval) {
  return fixed(100 * share, 1) + " " + interval_text(interval);
}

inline std::string rate_text(const evaluate::DetectionRate& rate) {
  return percent_text(rate.p_at_50, rate.interval);
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

/// A table of rows by columns.
/// \param of_plain  returns the words for pictures without a camouflage; null: no rows of these
inline WordTable comparison_table(const Comparison& comparison, const std::string& title,
                                  const std::function<std::string(const ComparedTexture&)>& of_plain,
                                  const std::function<std::string(const ComparedCell&)>& of_cell) {
  WordTable table{title, {""}};
  table.header.insert(table.header.end(), comparison.columns.begin(), comparison.columns.end());
  const auto add = [&](const std::string& name, const auto& cells, const auto& words_of) {
    std::vector<std::string> words{name};
    for (std::size_t i = 0; i < comparison.columns.size(); ++i)
      words.push_back(i < cells.size() && cells[i] ? words_of(*cells[i]) : "-");
    table.rows.push_back(words);
  };
  if (of_plain)
    for (const auto& [name, cells] : comparison.plain) add(name, cells, of_plain);
  for (const auto& row : comparison.rows) add(row.name, row.cells, of_cell);
  return table;
}

/// A table of one figure: of pictures without a camouflage, and of each row with and without its design.
/// \param words_of  returns the figure of a texture
template <class WordsOf>
WordTable camouflage_and_noise(const Comparison& comparison, const std::string& title, WordsOf words_of) {
  return comparison_table(
      comparison, title + ": camouflage / matched noise", words_of,
      [=](const auto& cell) { return words_of(cell.camouflage) + " / " + words_of(cell.noise); });
}

/// The same as two tables, for longer words.
template <class WordsOf>
std::vector<WordTable> camouflage_then_noise(const Comparison& comparison, const std::string& title,
                                             WordsOf words_of) {
  return {comparison_table(comparison, title, words_of,
                           [=](const auto& cell) { return words_of(cell.camouflage); }),
          comparison_table(comparison, "with matched noise: " + title, {},
                           [=](const auto& cell) { return words_of(cell.noise); })};
}

/// Rate at which the car is found under noise drawn in each picture, and the effect beyond that noise.
inline std::vector<WordTable> picture_noise_tables(const Comparison& comparison) {
  const auto table = [&](const std::string& title, auto words_of) {
    return comparison_table(comparison, title, {}, [=](const ComparedCell& cell) {
      return cell.picture_noise ? words_of(*cell.picture_noise) : std::string("-");
    });
  };
  return {table("found with noise drawn in each picture, % (P@0.5), 95 %",
                [](const ComparedPictureNoise& noise) { return rate_text(noise.texture.rate); }),
          table("effect beyond noise drawn in each picture, P@0.5 in points, 95 %",
                [](const ComparedPictureNoise& noise) {
                  return percent_text(noise.p_at_50.mean, noise.p_at_50.interval);
                })};
}

inline std::vector<WordTable> effect_tables(const Comparison& comparison) {
  std::vector<WordTable> tables{
      comparison_table(comparison, "effect beyond matched noise, mean best confidence, 95 %", {},
                       [](const auto& cell) { return effect_text(cell.effect.best_confidence); }),
      comparison_table(comparison, "effect beyond matched noise, P@0.5 in points, 95 %", {},
                       [](const auto& cell) {
                         return percent_text(cell.effect.p_at_50.mean, cell.effect.p_at_50.interval);
                       }),
      comparison_table(comparison, "odds of being found, matched noise over camouflage, times, 95 %", {},
                       [](const auto& cell) { return odds_text(cell.effect.odds_ratio); })};
  if (has_picture_noise(comparison)) append(tables, picture_noise_tables(comparison));
  const auto has_kept = [](const ComparedRow& row) {
    return std::ranges::any_of(row.cells, [](const auto& cell) { return cell && cell->kept; });
  };
  if (std::ranges::any_of(comparison.rows, has_kept))
    tables.push_back(
        comparison_table(comparison, "effect kept when photographed, %, 95 %", {}, [](const auto& cell) {
          return cell.kept ? percent_text(cell.kept->ratio, cell.kept->interval) : std::string("-");
        }));
  return tables;
}

/// How often the car is found, and how surely.
inline std::vector<WordTable> rate_tables(const Comparison& comparison) {
  auto tables = camouflage_then_noise(comparison, "pictures in which the car is found, % (P@0.5), 95 %",
                                      [](const auto& texture) { return rate_text(texture.rate); });
  tables.push_back(camouflage_and_noise(comparison, "mean best confidence", [](const auto& texture) {
    return fixed(texture.mean_best_confidence, 3);
  }));
  return tables;
}

/// Class that the detector gives the car.
inline std::vector<WordTable> fate_tables(const Comparison& comparison) {
  std::vector<WordTable> tables{comparison_table(
      comparison, "attack success, % of the pictures found in clean, 95 %", {}, [](const auto& cell) {
        return cell.success.views == 0 ? std::string("-")
                                       : percent_text(cell.success.rate, cell.success.interval);
      })};
  append(tables,
         camouflage_then_noise(comparison, "pictures, %: found / related / renamed / misplaced / lost",
                               [](const auto& texture) { return fates_text(texture.fates); }));
  tables.push_back(camouflage_and_noise(
      comparison, "found at a confidence above .05, %",
      [](const auto& texture) { return fixed(100 * texture.sweep.front().p_at_50, 1); }));
  return tables;
}

}  // namespace detail

/// The tables of a comparison, one figure each, without those that have none.
inline std::vector<WordTable> comparison_tables(const Comparison& comparison) {
  std::vector<WordTable> tables;
  if (comparison.maps_attention)
    tables.push_back(
        detail::camouflage_and_noise(comparison, "attention on the car, % of the heat map",
                                     [](const auto& texture) { return fixed(100 * texture.attention, 1); }));
  detail::append(tables, detail::rate_tables(comparison));
  detail::append(tables, detail::effect_tables(comparison));
  if (comparison.rows.size() > 1)
    tables.push_back(detail::comparison_table(
        comparison,
        "mean best confidence of " + comparison.rows.front().name + " minus that of the row, 95 %", {},
        [](const auto& cell) {
          return cell.beyond_first ? detail::effect_text(*cell.beyond_first) : std::string("-");
        }));
  detail::append(tables, detail::fate_tables(comparison));
  std::erase_if(tables, [](const WordTable& table) {
    return std::ranges::all_of(table.rows, [](const auto& row) {
      return std::ranges::count(row, std::string("-")) + 1 == static_cast<long>(row.size());
    });
  });
  return tables;
}

namespace detail {

/// Fields of a texture, in the order of comparison_csv().
inline std::string csv_fields(const ComparedTexture& texture) {
  std::vector<double> sweep;
  for (const auto& rate : texture.sweep) sweep.push_back(rate.p_at_50);
  const auto& rate = texture.rate;
  return csv_line(rate.views, rate.detected, rate.p_at_50, rate.interval, texture.mean_best_confidence,
                  std::span(texture.fates.pictures).subspan(1), sweep, texture.attention);
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
         ",attention,effect,effect_low,effect_high,effect_p_at_50,effect_p_at_50_low,effect_p_at_50_high,"
         "detected_in_clean,hidden,asr,asr_low,asr_high,kept,kept_low,kept_high,first_minus,first_minus_low,"
         "first_minus_high,odds_ratio,odds_ratio_low,odds_ratio_high,effect_picture,effect_picture_low,"
         "effect_picture_high\n";
}

}  // namespace detail

/// The order of the rows by four measures of their effect, in each column where these do not put the same row
/// first.
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
      std::string order;
      for (const ComparedRow* row : sorted) order += (order.empty() ? "" : ", ") + row->name;
      for (std::size_t i = 0; i < rows.size(); ++i)
        times_first[i] += value(rows[i]) == value(sorted.front()) ? 1U : 0U;
      text += std::string(text.empty() ? "" : "; ") + "by " + name + " " + order;
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
