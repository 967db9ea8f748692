#pragma once
#include <concepts>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/protocol_cells.hpp>
#include <vector>

#include "../view_list.hpp"
#include "protocol.hpp"

namespace tapestry::shell::detail {

/// Mean of the values; 0 if there are none.
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
    if (protocol.parts.size() == 2 && has_camouflage) {
      const auto in = [&](const ProtocolPart& part) {
        return [&](std::size_t i) { return part.holds(protocol.frames[i].row); };
      };
      const auto& part = protocol.parts[0];
      result.effect_kept = evaluate::effect_kept(
          outcomes, 2, 1, in(part), protocol.table.pictures_of_row(part.first_row), in(protocol.parts[1]));
    }
    return result;
  }
  for (std::size_t column = 0; column < protocol.table.columns.size(); ++column)
    result.sections.push_back(section_of(protocol, protocol.table.columns[column], result, outcomes,
                                         [&](std::size_t i) { return protocol.frames[i].column == column; }));
  return result;
}

/// The measured renders, each with every texture; views of photographs are not kept.
struct MeasuredFrames {
  std::vector<ViewFacts> views;
  std::vector<evaluate::Measurement> textures;

  /// \param shown  numbers of textures
  [[nodiscard]] ViewList list(const std::vector<std::size_t>& shown) const {
    ViewList list{views, {}, textures.at(shown.at(shown.size() > 1 ? 1 : 0)).name};
    for (const std::size_t k : shown) list.measurements.emplace_back(textures[k].name, &textures[k]);
    return list;
  }
  [[nodiscard]] ViewList list() const {
    std::vector<std::size_t> all(textures.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return list(all);
  }
};

inline MeasuredFrames measured_frames(const Protocol& protocol, const ProtocolResult& result,
                                      const evaluate::ProtocolOutcomes& outcomes) {
  MeasuredFrames measured;
  for (const auto& name : result.textures) measured.textures.push_back({name});
  for (std::size_t i = 0; i < protocol.frames.size(); ++i) {
    if (outcomes.state_of(i) != evaluate::FrameState::measured) continue;
    const auto& frame = protocol.frames[i];
    measured.views.push_back({protocol.table.rows[frame.row] + ", " + protocol.table.columns[frame.column],
                              frame.azimuth_deg, frame.elevation_deg, frame.distance,
                              outcomes.hidden_share(i), outcomes.car_share(i)});
    for (std::size_t k = 0; k < result.textures.size(); ++k) {
      measured.textures[k].found.push_back(outcomes.found(i, k) != 0);
      measured.textures[k].best_confidence.push_back(outcomes.best_confidence(i, k));
    }
  }
  return measured;
}

}  // namespace tapestry::shell::detail
