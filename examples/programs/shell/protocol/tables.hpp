#pragma once
#include "../report.hpp"
#include "../word_table.hpp"
#include "protocol.hpp"

namespace tapestry::shell {
/// One word for each cell of the protocol's table.
template <class Word>
WordTable grid_table(const Protocol& protocol, const ProtocolResult& result, const std::string& title,
                     Word word) {
  WordTable table{title, {protocol.table.row_title + " \\ " + protocol.table.column_title}};
  table.header.insert(table.header.end(), protocol.table.columns.begin(), protocol.table.columns.end());
  for (std::size_t row = 0; row < protocol.table.rows.size(); ++row) {
    std::vector<std::string> words{protocol.table.rows[row]};
    for (std::size_t column = 0; column < protocol.table.columns.size(); ++column)
      words.push_back(word(result.cells[row * protocol.table.columns.size() + column]));
    table.rows.push_back(words);
  }
  return table;
}

/// A share and the counts it was computed from.
struct Proportion {
  double share;
  std::size_t hits, trials;
  std::array<double, 2> interval;
};
inline Proportion proportion_of(const evaluate::DetectionRate& rate) {
  return {rate.p_at_50, rate.detected, rate.views, rate.interval};
}
inline Proportion proportion_of(const evaluate::AttackSuccess& success) {
  return {success.rate, success.hidden, success.views, success.interval};
}

/// "83.3 (75 of 90)", or with its interval "83.3 [74, 90] (75 of 90)"; "-" if there is none.
inline std::string share_text(const Proportion& proportion, bool with_interval) {
  const auto& [share, hits, trials, interval] = proportion;
  if (trials == 0) return "-";
  std::string text = fixed(100 * share, 1);
  if (with_interval) text.append(" ").append(interval_text(interval, 100, 0));
  return text + " (" + std::to_string(hits) + " of " + std::to_string(trials) + ")";
}

/// How often the car is found in each cell or, for attack success, how often a texture hides it in frames
/// where the clean one does not.
inline WordTable share_grid(const Protocol& protocol, const ProtocolResult& result, std::size_t texture,
                            bool of_success, bool with_intervals) {
  const std::string title = of_success ? ": attack success, % of the frames found in clean"
                                       : ": frames in which the car is found, % (P@0.5)";
  return grid_table(protocol, result, result.textures[texture] + title, [=](const evaluate::Cell& cell) {
    const auto& outcome = cell.textures[texture];
    return share_text(of_success ? proportion_of(outcome.success) : proportion_of(outcome.rate),
                      with_intervals);
  });
}

inline WordTable summary_table(const Protocol& protocol, const ProtocolResult& result,
                               const ProtocolSection& section) {
  WordTable table{protocol.title + ": " + section.name,
                  {"texture", "found in", "P@0.5, %", "95 %", "AP50, %", "AP50:95, %", "mean best confidence",
                   "attack success, %", "95 %"}};
  for (std::size_t k = 0; k < result.textures.size(); ++k) {
    const auto& [rate, confidence, success, fates, precision] = section.cell.textures[k];
    const bool is_attack = result.is_attack(k) && success.views > 0;
    table.rows.push_back(
        {result.textures[k], std::to_string(rate.detected) + " of " + std::to_string(rate.views),
         rate.views > 0 ? fixed(100 * rate.p_at_50, 1) : "-", interval_text(rate.interval),
         per_cent(precision.ap50), per_cent(precision.ap), fixed(confidence, 3),
         is_attack ? fixed(100 * success.rate, 1) : "-", is_attack ? interval_text(success.interval) : "-"});
  }
  return table;
}

/// Frames of each fate with each texture: found, called something else, or lost.
inline WordTable fates_table(const ProtocolResult& result, std::size_t section) {
  const auto& [name, cell, effect, sweep, attention, car_share] = result.sections[section];
  WordTable table{"what the car is to the detector, frames: " + name, {"texture"}};
  table.header.insert(table.header.end(), evaluate::fate_names.begin(), evaluate::fate_names.end());
  table.header.push_back("renamed to");
  for (std::size_t k = 0; k < result.textures.size(); ++k) {
    const evaluate::FateCounts& fates = cell.textures[k].fates;
    std::vector<std::string> words{result.textures[k]};
    for (const std::size_t frames : fates.pictures) words.push_back(std::to_string(frames));
    const std::string names = new_names_text(fates, result.names_of(section));
    words.push_back(names.empty() ? "-" : names);
    table.rows.push_back(words);
  }
  return table;
}

/// Effect of the camouflage beyond the noise matched to it, section by section.
inline WordTable effect_table(const ProtocolResult& result) {
  WordTable table{
      "effect beyond matched noise (its figure minus the camouflage's)",
      {"", "mean best confidence", "95 %", "P@0.5, points", "95 %", "odds of being found, times", "95 %"}};
  const auto has_draws = [](const auto& section) { return section.effect && section.effect->draws > 1; };
  const bool with_rank = std::ranges::any_of(result.sections, has_draws);
  if (with_rank) table.header.emplace_back("draws that leave no more");
  for (const auto& section : result.sections) {
    if (!section.effect || section.effect->best_confidence.pairs == 0) continue;
    const auto& [control, confidence, rate, draws, draws_at_most, odds] = *section.effect;
    table.rows.push_back(
        {section.name, fixed(confidence.mean, 3), interval_text(confidence.interval, 1, 3),
         fixed(100 * rate.mean, 1), interval_text(rate.interval),
         are_readable(odds) ? odds_number(odds.ratio) : "-",
         are_readable(odds) ? "[" + odds_number(odds.interval[0]) + ", " + odds_number(odds.interval[1]) + "]"
                            : "-"});
    if (with_rank)
      table.rows.back().push_back(std::to_string(draws_at_most) + " of " + std::to_string(draws));
  }
  return table;
}

inline WordTable attention_table(const ProtocolResult& result, const ProtocolSection& section) {
  WordTable table{"attention on the car, % of the heat map: " + section.name + " (the car covers " +
                      fixed(100 * section.car_share, 1) + " % of the picture)",
                  {"texture", "attention", "less than clean, points", "95 %"}};
  for (std::size_t k = 0; k < section.attention.size(); ++k) {
    const auto& [mean, lost] = section.attention[k];
    table.rows.push_back({result.textures[k], fixed(100 * mean, 1), k == 0 ? "-" : fixed(100 * lost.mean, 1),
                          k == 0 ? "-" : interval_text(lost.interval)});
  }
  return table;
}

inline WordTable sweep_table(const ProtocolResult& result, const ProtocolSection& section) {
  WordTable table{"P@0.5 by confidence threshold, %: " + section.name, {"texture"}};
  for (const double threshold : swept_thresholds)
    table.header.push_back(evaluate::detail::short_number(threshold));
  for (std::size_t k = 0; k < result.textures.size(); ++k) {
    std::vector<std::string> words{result.textures[k]};
    for (const auto& rate : section.sweep[k])
      words.push_back(rate.views > 0 ? fixed(100 * rate.p_at_50, 1) : "-");
    table.rows.push_back(words);
  }
  return table;
}

inline std::string cell_name(const Protocol& protocol, std::size_t cell) {
  const auto& table = protocol.table;
  return table.row_title + " " + table.rows[cell / table.columns.size()] + ", " + table.column_title + " " +
         table.columns[cell % table.columns.size()];
}

/// The worst cell: where the camouflage hides the car least or, without a camouflage, where the detector
/// finds it least. If there are parts, the cell is from the first part, which begins with the table.
inline std::optional<std::size_t> worst_cell(const Protocol& protocol, const ProtocolResult& result) {
  auto cells = result.cells;
  if (!protocol.parts.empty()) cells.resize(protocol.parts.front().row_count * protocol.table.columns.size());
  return result.has_camouflage ? evaluate::least_hidden_cell(cells, 1) : evaluate::least_found_cell(cells, 0);
}

/// A sentence about the worst cell; empty if there is only one cell.
inline std::string worst_cell_text(const Protocol& protocol, const ProtocolResult& result) {
  if (protocol.table.cell_count() == 1) return {};  // no other cells
  const auto worst = worst_cell(protocol, result);
  if (!worst)
    return result.has_camouflage ? "attack success is not defined: the clean car is never found"
                                 : "no frames";
  const auto& cell = result.cells[*worst];
  if (!result.has_camouflage)
    return "worst cell: the plain car is found least at " + cell_name(protocol, *worst) + ", P@0.5 " +
           share_text(proportion_of(cell.textures[0].rate), true) + " %";
  return "worst cell: the camouflage hides the car least at " + cell_name(protocol, *worst) +
         ", attack success " + share_text(proportion_of(cell.textures[1].success), true) + " %; " +
         result.textures[2] + " there " + share_text(proportion_of(cell.textures[2].success), true) + " %";
}

/// Share of its effect that a camouflage keeps in the first part; empty where it is not defined.
inline std::string effect_kept_text(const Protocol& protocol, const ProtocolResult& result) {
  if (protocol.parts.size() != 2 || !result.has_camouflage) return {};
  const std::string first = protocol.parts[0].name, second = protocol.parts[1].name;
  if (!result.effect_kept)
    return second + ", the camouflage has no effect beyond " + result.textures[2] +
           " that its interval separates from none; the share kept is not defined";
  const auto& [ratio, interval] = *result.effect_kept;
  return "effect kept: " + first + ", the camouflage has " + fixed(100 * ratio, 0) + " % " +
         interval_text(interval, 100, 0) + " of the effect on mean best confidence that it has " + second;
}

inline std::vector<std::string> verdicts(const ProtocolResult& result) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < result.sections.size() && result.has_camouflage; ++i) {
    const auto& [name, cell, effect, sweep, attention, car_share] = result.sections[i];
    const auto found = [&of = cell.textures](std::size_t k) { return FoundCar{of[k].rate, of[k].fates}; };
    VerdictFigures figures{"frames", found(0), found(1), found(2)};
    if (effect) figures.beyond = effect->p_at_50;
    figures.class_names = result.names_of(i);
    const std::string words = verdict_text(figures);
    if (!words.empty()) sentences.push_back((result.sections.size() > 1 ? name + ": " : "") + words);
  }
  return sentences;
}

/// Sentences under the tables.
inline std::vector<std::string> findings(const Protocol& protocol, const ProtocolResult& result) {
  std::vector<std::string> sentences;
  for (const auto& text : {effect_kept_text(protocol, result), worst_cell_text(protocol, result)})
    if (!text.empty()) sentences.push_back(text);
  return sentences;
}
}  // namespace tapestry::shell
