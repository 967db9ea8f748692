#pragma once
#include "../report.hpp"
#include "../view_list.hpp"
#include "protocol.hpp"

namespace tapestry::shell {
/// Number of draws of each texture: neighbours of one name are its draws.
inline std::vector<std::size_t> draws_of(const std::vector<evaluate::Control>& textures) {
  std::vector<std::size_t> draws;
  for (std::size_t k = 0; k < textures.size(); ++k)
    if (k > 0 && textures[k].name == textures[k - 1].name)
      ++draws.back();
    else
      draws.push_back(1);
  return draws;
}

/// Names of the columns of the outcomes; second and further draws are numbered.
inline std::vector<std::string> column_names(const ProtocolResult& result,
                                             const evaluate::ProtocolOutcomes& outcomes) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < result.textures.size(); ++k)
    for (std::size_t draw = 1; draw <= outcomes.draws_of(k); ++draw) {
      names.push_back(result.textures[k]);
      if (draw > 1) names.back().append(" ").append(std::to_string(draw));
    }
  return names;
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
    section.attention.push_back(
        {evaluate::detail::mean_of(evaluate::measured_values(outcomes, outcomes.attention, k, belongs)),
         evaluate::attention_lost(outcomes, k, belongs)});
  std::vector<double> car_shares;
  for (std::size_t frame = 0; frame < outcomes.frame_count(); ++frame)
    if (outcomes.state_of(frame) == evaluate::FrameState::measured && belongs(frame))
      car_shares.push_back(outcomes.car_share(frame));
  section.car_share = evaluate::detail::mean_of(car_shares);
  return section;
}

/// Frames of a protocol that are summarised together, each section of a report.
struct MeasuredPart {
  std::string name;
  std::function<bool(std::size_t frame)> belongs;
  std::size_t pictures_a_view = 1;
};

/// The parts of a protocol: a detector's photographs, the parts of renders, or all of them.
/// \param protocol  must outlive the result
inline std::vector<MeasuredPart> measured_parts(const Protocol& protocol) {
  std::vector<MeasuredPart> parts;
  if (protocol.on_photographs)
    for (std::size_t column = 0; column < protocol.table.columns.size(); ++column)
      parts.push_back({protocol.table.columns[column],
                       [&protocol, column](std::size_t i) { return protocol.frames[i].column == column; }});
  for (const auto& part : protocol.parts)
    parts.push_back({part.name,
                     [&protocol, part](std::size_t i) { return part.holds(protocol.frames[i].row); },
                     protocol.table.pictures_of_row(part.first_row)});
  if (parts.empty()) parts.push_back({"all frames", [](std::size_t) { return true; }});
  return parts;
}

inline ProtocolResult result_of(const Protocol& protocol, const std::vector<evaluate::Control>& textures,
                                bool has_camouflage, const evaluate::ProtocolOutcomes& outcomes) {
  ProtocolResult result;
  for (const auto& texture : textures)
    if (result.textures.empty() || result.textures.back() != texture.name)
      result.textures.push_back(texture.name);
  result.has_camouflage = has_camouflage;
  result.noise_in_place = evaluate::noise_in_place(textures);
  result.has_bare = !protocol.bare_name.empty();
  result.cells = evaluate::cells_of(protocol.table, protocol.frames, outcomes);
  const auto parts = measured_parts(protocol);
  for (const auto& [name, belongs, pictures_a_view] : parts)
    result.sections.push_back(section_of(protocol, name, result, outcomes, belongs, pictures_a_view));
  if (protocol.parts.size() == 2 && has_camouflage)
    result.effect_kept =
        evaluate::effect_kept(outcomes, 2, 1, parts[0].belongs, parts[0].pictures_a_view, parts[1].belongs);
  return result;
}

/// The measured renders, each with every texture; views of photographs are not kept.
struct MeasuredFrames {
  std::vector<ViewFacts> views;
  std::vector<evaluate::Measurement> textures;  ///< by the columns of the outcomes

  /// \param shown  columns
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
  for (const auto& name : column_names(result, outcomes)) measured.textures.push_back({name});
  for (std::size_t i = 0; i < protocol.frames.size(); ++i) {
    if (outcomes.state_of(i) != evaluate::FrameState::measured) continue;
    const auto& frame = protocol.frames[i];
    measured.views.push_back({protocol.table.rows[frame.row] + ", " + protocol.table.columns[frame.column],
                              frame.azimuth_deg, frame.elevation_deg, frame.distance,
                              outcomes.hidden_share(i), outcomes.car_share(i)});
    for (std::size_t k = 0; k < outcomes.column_count(); ++k) {
      measured.textures[k].found.push_back(outcomes.found(i, k) != 0);
      measured.textures[k].best_confidence.push_back(outcomes.best_confidence(i, k));
    }
  }
  return measured;
}
}  // namespace tapestry::shell
