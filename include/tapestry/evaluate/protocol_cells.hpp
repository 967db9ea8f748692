#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/fate.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <tapestry/evaluate/views.hpp>
#include <vector>

namespace tapestry::evaluate {

/// Progress of a protocol's frame.
enum class FrameState : std::uint8_t {
  pending = 0,
  measured = 1,
  left_out = 2,  ///< nothing of the car shows, or the protocol's change cannot be made to it
};

/// Outcomes of a detector on every picture of a protocol: each frame with each texture, the clean one first.
struct ProtocolOutcomes {
  Array<std::uint8_t, 1> state;       ///< [frame], a FrameState
  Array<std::uint8_t, 2> found;       ///< [frame, texture], 0 or 1
  Array<std::uint8_t, 2> fate;        ///< [frame, texture], a Fate
  Array<std::uint16_t, 2> named;      ///< [frame, texture], class of the box that decides it; 0 for lost
  Array<double, 2> best_confidence;   ///< [frame, texture], see best_confidence()
  Array<double, 2> found_confidence;  ///< [frame, texture], see ViewResult
  Array<double, 2> attention;         ///< [frame, texture], share of a heat map on the car; 0 without maps
  Array<double, 1> hidden_share;      ///< [frame], of the car's silhouette, 0 where nothing is laid over it
  Array<double, 1> car_share;         ///< [frame], of the picture, that the car covers

  ProtocolOutcomes() = default;
  ProtocolOutcomes(std::size_t frames, std::size_t textures)
      : state(zeros<std::uint8_t, 1>({frames})),
        found(zeros<std::uint8_t, 2>({frames, textures})),
        fate(zeros<std::uint8_t, 2>({frames, textures})),
        named(zeros<std::uint16_t, 2>({frames, textures})),
        best_confidence(zeros<double, 2>({frames, textures})),
        found_confidence(zeros<double, 2>({frames, textures})),
        attention(zeros<double, 2>({frames, textures})),
        hidden_share(zeros<double, 1>({frames})),
        car_share(zeros<double, 1>({frames})) {}

  [[nodiscard]] std::size_t frame_count() const { return found.shape(0); }
  [[nodiscard]] std::size_t texture_count() const { return found.shape(1); }
  [[nodiscard]] FrameState state_of(std::size_t frame) const { return static_cast<FrameState>(state(frame)); }
};

/// Results of one texture over the frames of a cell.
struct TextureCell {
  DetectionRate rate{};             ///< P@0.5 over the measured frames
  double mean_best_confidence = 0;  ///< over them, 0 without any
  AttackSuccess success{};          ///< relative to the clean texture, for which nothing is hidden
  FateCounts fates{};               ///< of the measured frames
};

/// Some frames of a protocol.
struct Cell {
  std::size_t measured = 0;
  std::size_t left_out = 0;
  double mean_hidden_share = 0;         ///< over the measured frames, 0 without any
  std::vector<TextureCell> textures{};  ///< in the order of the outcomes
};

/// The cell of the frames for which belongs(index) holds; frames that are pending count nowhere.
/// \param pictures_a_view  as for detection_rate()
/// \throws ShapeError if the arrays of the outcomes differ in their extents, or there is no texture
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] Cell cell_of(const ProtocolOutcomes& outcomes, Belongs belongs,
                           std::size_t pictures_a_view = 1) {
  const std::size_t frames = outcomes.frame_count(), textures = outcomes.texture_count();
  require_shape("cell_of", "state", outcomes.state, {frames});
  require_shape("cell_of", "fate", outcomes.fate, {frames, textures});
  require_shape("cell_of", "named", outcomes.named, {frames, textures});
  require_shape("cell_of", "best_confidence", outcomes.best_confidence, {frames, textures});
  require_shape("cell_of", "hidden_share", outcomes.hidden_share, {frames});
  if (textures == 0) throw ShapeError("cell_of: outcomes of no texture");
  Cell cell;
  std::vector<std::vector<bool>> found(textures);
  std::vector<std::vector<ViewOutcome>> fates(textures);
  std::vector<double> confidence(textures, 0.0);
  double hidden = 0;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    if (outcomes.state_of(frame) == FrameState::pending || !belongs(frame)) continue;
    if (outcomes.state_of(frame) != FrameState::measured) {
      ++cell.left_out;
      continue;
    }
    ++cell.measured;
    hidden += outcomes.hidden_share(frame);
    for (std::size_t k = 0; k < textures; ++k) {
      found[k].push_back(outcomes.found(frame, k) != 0);
      fates[k].push_back({static_cast<Fate>(outcomes.fate(frame, k)), outcomes.named(frame, k)});
      confidence[k] += outcomes.best_confidence(frame, k);
    }
  }
  const auto mean = [&](double sum) {
    return cell.measured > 0 ? sum / static_cast<double>(cell.measured) : 0.0;
  };
  cell.mean_hidden_share = mean(hidden);
  for (std::size_t k = 0; k < textures; ++k)
    cell.textures.push_back({detection_rate(found[k], pictures_a_view), mean(confidence[k]),
                             attack_success_rate(found[0], found[k], pictures_a_view),
                             fate_counts(fates[k])});
  return cell;
}

/// Values of one texture, one for each measured frame for which belongs(index) holds.
///
/// \param values   of the outcomes, [frame, texture]
/// \param texture  its number in them
/// \throws ShapeError if values are not of the outcomes' extents, or there is no such texture
template <class Value, std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<double> measured_values(const ProtocolOutcomes& outcomes,
                                                  const Array<Value, 2>& values, std::size_t texture,
                                                  Belongs belongs) {
  require_shape("measured_values", "values", values, {outcomes.frame_count(), outcomes.texture_count()});
  if (texture >= outcomes.texture_count())
    throw ShapeError("measured_values: texture " + std::to_string(texture) + " of " +
                     std::to_string(outcomes.texture_count()));
  std::vector<double> numbers;
  for (std::size_t frame = 0; frame < outcomes.frame_count(); ++frame)
    if (outcomes.state_of(frame) == FrameState::measured && belongs(frame))
      numbers.push_back(static_cast<double>(values(frame, texture)));
  return numbers;
}

/// Attention that a texture draws away from the car: the share of heat maps on the car with the clean texture
/// minus that with this one, over the measured frames for which belongs(index) holds.
/// \throws ShapeError as measured_values()
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] PairedDifference attention_lost(const ProtocolOutcomes& outcomes, std::size_t texture,
                                              Belongs belongs) {
  return paired_bootstrap(measured_values(outcomes, outcomes.attention, 0, belongs),
                          measured_values(outcomes, outcomes.attention, texture, belongs));
}

/// Means of the pictures of each view with one texture, over the measured frames for which belongs(index)
/// holds.
///
/// \param values           [frame, texture], of the outcomes
/// \param texture          its number there
/// \param pictures_a_view  measured frames that follow one another and count as one
/// \throws ShapeError if the arrays of the outcomes differ in their extents, there is no such texture, or a
///         view lacks some of its pictures
template <class Values, std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<double> view_means(const ProtocolOutcomes& outcomes, const Values& values,
                                             std::size_t texture, Belongs belongs,
                                             std::size_t pictures_a_view = 1) {
  const auto pictures = measured_values(outcomes, values, texture, belongs);
  if (pictures_a_view == 0 || pictures.size() % pictures_a_view != 0)
    throw ShapeError("view_means: " + std::to_string(pictures.size()) + " pictures are not " +
                     std::to_string(pictures_a_view) + " of each view");
  return detail::means_of_views(pictures, pictures_a_view);
}

/// Effect of a texture beyond a control in the measured frames for which belongs(index) holds; computed as by
/// effect_beyond().
///
/// \param control, texture   their numbers in the outcomes
/// \throws ShapeError as view_means()
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] Effect effect_of(const ProtocolOutcomes& outcomes, const std::string& name, std::size_t control,
                               std::size_t texture, Belongs belongs, std::size_t pictures_a_view = 1) {
  const auto means = [&](std::size_t k) {
    return view_means(outcomes, outcomes.best_confidence, k, belongs, pictures_a_view);
  };
  const auto found = [&](std::size_t k) {
    const auto values = measured_values(outcomes, outcomes.found, k, belongs);
    return std::vector<bool>(values.begin(), values.end());
  };
  return {name, paired_bootstrap(means(control), means(texture)),
          rate_difference(found(control), found(texture), pictures_a_view)};
}

/// The effect of a texture beyond a control on mean best confidence in some frames, as a share of that in
/// others which show the same views in the same order. Nothing where the latter does not differ from none, or
/// where frames were left out in one of them alone.
///
/// \param control, texture           their numbers in the outcomes
/// \param in_part, in_whole          which frames, by their indices
/// \param pictures_a_view_in_part    as for view_means(); of the whole there is one
/// \throws ShapeError as view_means()
template <std::predicate<std::size_t> InPart, std::predicate<std::size_t> InWhole>
[[nodiscard]] std::optional<PairedRatio> effect_kept(const ProtocolOutcomes& outcomes, std::size_t control,
                                                     std::size_t texture, InPart in_part,
                                                     std::size_t pictures_a_view_in_part, InWhole in_whole) {
  const auto effects = [&](auto belongs, std::size_t pictures_a_view) {
    auto differences = view_means(outcomes, outcomes.best_confidence, control, belongs, pictures_a_view);
    const auto means = view_means(outcomes, outcomes.best_confidence, texture, belongs, pictures_a_view);
    for (std::size_t view = 0; view < means.size(); ++view) differences[view] -= means[view];
    return differences;
  };
  const auto part = effects(in_part, pictures_a_view_in_part), whole = effects(in_whole, 1);
  const std::vector<double> none(whole.size(), 0.0);
  if (part.size() != whole.size() || whole.empty() || !(paired_bootstrap(whole, none).interval[0] > 0))
    return std::nullopt;
  return paired_ratio(part, whole);
}

/// P@0.5 at other thresholds of confidence, one entry each; none may be below the meter's least threshold.
///
/// \param texture          its number in the outcomes
/// \param pictures_a_view  as for detection_rate()
/// \throws ShapeError if the arrays of the outcomes differ in their extents, or there is no such texture
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<DetectionRate> sweep_of(const ProtocolOutcomes& outcomes, std::size_t texture,
                                                  const std::vector<double>& thresholds, Belongs belongs,
                                                  std::size_t pictures_a_view = 1) {
  const auto confidences = measured_values(outcomes, outcomes.found_confidence, texture, belongs);
  std::vector<DetectionRate> rates;
  for (const double threshold : thresholds) {
    std::vector<bool> found;
    for (const double confidence : confidences) found.push_back(confidence > threshold);
    rates.push_back(detection_rate(found, pictures_a_view));
  }
  return rates;
}

/// The cells of a table, row by row.
/// \param frames  one for every frame of the outcomes
/// \throws ShapeError as cell_of(), or for another number of frames or a frame beside the table
[[nodiscard]] std::vector<Cell> cells_of(const ProtocolTable& table, const std::vector<ProtocolFrame>& frames,
                                         const ProtocolOutcomes& outcomes);

/// The cell in which a texture hides the car least: that of the lowest attack success, compared by the upper
/// end of its interval, so that one frame does not outweigh ninety. None where the clean car is never found.
///
/// \param texture  its number in the outcomes
[[nodiscard]] std::optional<std::size_t> least_hidden_cell(const std::vector<Cell>& cells,
                                                           std::size_t texture);

/// The cell in which a detector finds the car least, compared by the upper end of P@0.5's interval. None
/// without frames.
[[nodiscard]] std::optional<std::size_t> least_found_cell(const std::vector<Cell>& cells,
                                                          std::size_t texture);

}  // namespace tapestry::evaluate
