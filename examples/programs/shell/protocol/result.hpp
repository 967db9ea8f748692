#pragma once
#include <concepts>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/effect.hpp>
#include <tapestry/evaluate/protocol_cells.hpp>
#include <vector>

#include "protocol.hpp"

namespace tapestry::shell::detail {

/// 0 without values.
inline double mean_of(const std::vector<double>& values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

template <std::predicate<std::size_t> Belongs>
ProtocolSection section_of(const Protocol& protocol, const std::string& name, const ProtocolResult& result,
                           const evaluate::ProtocolOutcomes& outcomes, Belongs belongs,
                           std::size_t pictures_a_view = 1) {
  ProtocolSection section{name, evaluate::cell_of(outcomes, belongs, pictures_a_view)};
  if (result.has_camouflage)
    section.effect = evaluate::effect_of(outcomes, result.textures[2], 2, 1, belongs, pictures_a_view);
  for (std::size_t k = 0; k < result.textures.size(); ++k)
    section.sweep.push_back(evaluate::sweep_of(outcomes, k, swept_thresholds, belongs, pictures_a_view));
  for (std::size_t k = 0; k < result.textures.size() && protocol.maps_attention; ++k)
    section.attention.push_back({mean_of(evaluate::measured_values(outcomes, outcomes.attention, k, belongs)),
                                 evaluate::attention_lost(outcomes, k, belongs)});
  std::vector<double> car_shares;
  for (std::size_t frame = 0; frame < outcomes.frame_count(); ++frame)
    if (outcomes.state_of(frame) == evaluate::FrameState::measured && belongs(frame))
      car_shares.push_back(outcomes.car_share(frame));
  section.car_share = mean_of(car_shares);
  return section;
}

/// The effect of the first section as a share of the second's, over the views of both; nothing where that of
/// the second cannot be told from none.
inline std::optional<evaluate::PairedRatio> effect_kept(const Protocol& protocol,
                                                        const ProtocolResult& result,
                                                        const evaluate::ProtocolOutcomes& outcomes) {
  if (result.sections.size() != 2 || !result.sections[1].effect) return std::nullopt;
  if (!(result.sections[1].effect->best_confidence.interval[0] > 0)) return std::nullopt;
  std::vector<std::vector<double>> effects;
  for (const auto& part : protocol.parts) {
    const auto means = [&](std::size_t texture) {
      return evaluate::view_means(
          outcomes, outcomes.best_confidence, texture,
          [&](std::size_t i) { return part.holds(protocol.frames[i].row); },
          protocol.table.pictures_of_row(part.first_row));
    };
    auto& effect = effects.emplace_back(means(2));
    const auto camouflage = means(1);
    for (std::size_t view = 0; view < effect.size(); ++view) effect[view] -= camouflage[view];
  }
  if (effects[0].size() != effects[1].size()) return std::nullopt;
  return evaluate::paired_ratio(effects[0], effects[1]);
}

inline ProtocolResult result_of(const Protocol& protocol,
                                const std::vector<evaluate::Control<float>>& textures, bool has_camouflage,
                                const evaluate::ProtocolOutcomes& outcomes) {
  ProtocolResult result;
  for (const auto& texture : textures) result.textures.push_back(texture.name);
  result.has_camouflage = has_camouflage;
  result.has_bare = !protocol.bare_name.empty();
  result.cells = evaluate::cells_of(protocol.table, protocol.frames, outcomes);
  if (!protocol.on_photographs) {
    if (protocol.parts.empty())
      result.sections.push_back(
          section_of(protocol, "all frames", result, outcomes, [](std::size_t) { return true; }));
    for (const auto& part : protocol.parts)
      result.sections.push_back(section_of(
          protocol, part.name, result, outcomes,
          [&](std::size_t i) { return part.holds(protocol.frames[i].row); },
          protocol.table.pictures_of_row(part.first_row)));
    result.effect_kept = effect_kept(protocol, result, outcomes);
    return result;
  }
  for (std::size_t column = 0; column < protocol.table.columns.size(); ++column)
    result.sections.push_back(section_of(protocol, protocol.table.columns[column], result, outcomes,
                                         [&](std::size_t i) { return protocol.frames[i].column == column; }));
  return result;
}

}  // namespace tapestry::shell::detail
