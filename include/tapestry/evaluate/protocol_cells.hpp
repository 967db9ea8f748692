#pragma once
#include <tapestry/evaluate/detail/protocol_outcomes.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

namespace tapestry::evaluate {
/// Results of one texture over the frames of a cell.
struct TextureCell {
  DetectionRate rate{};             ///< P@0.5 over the measured frames
  double mean_best_confidence = 0;  ///< over them, 0 without any
  AttackSuccess success{};          ///< relative to the clean texture, which hides nothing
  FateCounts fates{};               ///< of the measured frames
  PrecisionSummary precision{};     ///< of them
};

/// Some frames of a protocol.
struct Cell {
  std::size_t measured = 0;
  std::size_t left_out = 0;
  double mean_hidden_share = 0;         ///< over the measured frames, 0 without any
  std::vector<TextureCell> textures{};  ///< in the order of the outcomes
};

namespace detail {
/// Whether the car is found, for each picture of one texture as measured_values() orders them.
/// \param times  copies of each entry
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<bool> found_in(const ProtocolOutcomes& outcomes, std::size_t texture,
                                         Belongs belongs, std::size_t times = 1) {
  std::vector<bool> found;
  for (const double value : measured_values(outcomes, outcomes.found, texture, belongs))
    found.insert(found.end(), times, value != 0);
  return found;
}

/// Fates of the pictures of one texture, in the order of found_in().
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<ViewOutcome> fates_in(const ProtocolOutcomes& outcomes, std::size_t texture,
                                                Belongs belongs) {
  const auto fates = measured_values(outcomes, outcomes.fate, texture, belongs),
             names = measured_values(outcomes, outcomes.named, texture, belongs);
  std::vector<ViewOutcome> all;
  for (std::size_t i = 0; i < fates.size(); ++i)
    all.push_back({static_cast<Fate>(fates[i]), static_cast<std::size_t>(names[i])});
  return all;
}
}  // namespace detail

/// The cell of the frames with belongs(index); pending frames do not count.
/// \param pictures_a_view  photographs of one view
/// \throws ShapeError if the arrays of the outcomes differ in their extents, or there is no texture; as
///         detection_rate()
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] Cell cell_of(const ProtocolOutcomes& outcomes, Belongs belongs,
                           std::size_t pictures_a_view = 1) {
  if (outcomes.texture_count() == 0) throw ShapeError("cell_of: outcomes of no texture");
  require_shape("cell_of", "state", outcomes.state, {outcomes.frame_count()});
  require_shape("cell_of", "hidden_share", outcomes.hidden_share, {outcomes.frame_count()});
  Cell cell;
  std::vector<double> hidden;
  for (std::size_t frame = 0; frame < outcomes.frame_count(); ++frame) {
    if (outcomes.state_of(frame) == FrameState::pending || !belongs(frame)) continue;
    if (outcomes.state_of(frame) == FrameState::measured)
      hidden.push_back(outcomes.hidden_share(frame));
    else
      ++cell.left_out;
  }
  cell.measured = hidden.size();
  cell.mean_hidden_share = detail::mean_of(hidden);
  for (std::size_t k = 0; k < outcomes.texture_count(); ++k) {
    const PictureOrder order{pictures_a_view, outcomes.draws_of(k)};
    const auto found = detail::found_in(outcomes, k, belongs);
    cell.textures.push_back(
        {detection_rate(found, order),
         detail::mean_of(measured_values(outcomes, outcomes.best_confidence, k, belongs)),
         attack_success_rate(detail::found_in(outcomes, 0, belongs, order.draws), found, order),
         fate_counts(detail::fates_in(outcomes, k, belongs)),
         target_precision(ranked_boxes(outcomes, k, belongs))});
  }
  return cell;
}

/// Mean over each view's pictures with one texture, of the measured frames with belongs(index).
///
/// \param values           [frame, column], of the outcomes
/// \param texture          its index in the outcomes
/// \param pictures_a_view  measured frames that follow one another and count as one
/// \throws ShapeError as measured_values(), or if a view lacks some of its pictures
template <class Values, std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<double> view_means(const ProtocolOutcomes& outcomes, const Values& values,
                                             std::size_t texture, Belongs belongs,
                                             std::size_t pictures_a_view = 1) {
  const auto pictures = measured_values(outcomes, values, texture, belongs);
  const std::size_t draws = outcomes.draws_of(texture);
  if (pictures_a_view == 0 || pictures.size() / draws % pictures_a_view != 0)
    throw ShapeError(
        {"view_means: ", pictures.size() / draws, " pictures are not ", pictures_a_view, " of each view"});
  return detail::means_of_views(pictures, pictures_a_view * draws);
}

/// Values of a texture, [draw, view], each the mean over a view's pictures, of the measured
/// frames with belongs(index).
///
/// \param values   [frame, column], of the outcomes, such as best_confidence or found
/// \param texture  its index in the outcomes
/// \throws ShapeError as view_means()
template <class Values, std::predicate<std::size_t> Belongs>
[[nodiscard]] Array<double, 2> draw_means(const ProtocolOutcomes& outcomes, const Values& values,
                                          std::size_t texture, Belongs belongs,
                                          std::size_t pictures_a_view = 1) {
  const std::size_t views = view_means(outcomes, values, texture, belongs, pictures_a_view).size();
  const auto pictures = measured_values(outcomes, values, texture, belongs);
  const std::size_t draws = outcomes.draws_of(texture);
  auto means = zeros<double, 2>({draws, views});
  for (std::size_t i = 0; i < pictures.size(); ++i)
    means(i % draws, i / (draws * pictures_a_view)) +=
        static_cast<double>(pictures[i]) / static_cast<double>(pictures_a_view);
  return means;
}

/// The rows' mean, repeated once for each draw.
[[nodiscard]] inline Array<double, 2> mean_for_draws(const Array<double, 2>& values, std::size_t draws) {
  const auto means = detail::means_over_draws(values);
  Array<double, 2> repeated(Extents<2>{draws, means.size()});
  for (std::size_t draw = 0; draw < draws; ++draw)
    for (std::size_t view = 0; view < means.size(); ++view) repeated(draw, view) = means[view];
  return repeated;
}

/// Differences between the draws of a control and a texture, whose own draws are averaged, [draw, view];
/// parameters as for draw_means().
template <class Values, std::predicate<std::size_t> Belongs>
[[nodiscard]] Array<double, 2> draw_differences(const ProtocolOutcomes& outcomes, const Values& values,
                                                std::size_t control, std::size_t texture, Belongs belongs,
                                                std::size_t pictures_a_view = 1) {
  auto differences = draw_means(outcomes, values, control, belongs, pictures_a_view);
  const auto means =
      mean_for_draws(draw_means(outcomes, values, texture, belongs, pictures_a_view), differences.shape(0));
  for (std::size_t i = 0; i < differences.size(); ++i) differences.data()[i] -= means.data()[i];
  return differences;
}

/// Attention that a texture draws away from the car: the share of heat maps on the car with the clean texture
/// minus the share with this one's draws, over the measured frames with belongs(index).
/// \throws ShapeError as measured_values()
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] PairedDifference attention_lost(const ProtocolOutcomes& outcomes, std::size_t texture,
                                              Belongs belongs) {
  auto differences = draw_differences(outcomes, outcomes.attention, texture, 0, belongs);
  for (double& difference : differences) difference = -difference;
  return two_level_difference(differences, {}, 1);
}

/// Effect of a texture beyond a control in the measured frames with belongs(index): as effect_beyond() for a
/// control of one draw, else over the draws and the views.
///
/// \param control, texture   their numbers in the outcomes; the texture has one draw
/// \throws ShapeError as view_means(), or for another number of draws
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] Effect effect_of(const ProtocolOutcomes& outcomes, const std::string& name, std::size_t control,
                               std::size_t texture, Belongs belongs, std::size_t pictures_a_view = 1) {
  const auto differences =
      draw_differences(outcomes, outcomes.best_confidence, control, texture, belongs, pictures_a_view);
  const std::size_t draws = differences.shape(0), views = differences.shape(1);
  if (outcomes.draws_of(texture) != 1) throw ShapeError("effect_of: a texture of several draws");
  const auto found = draw_means(outcomes, outcomes.found, control, belongs, pictures_a_view);
  const auto painted =
      mean_for_draws(draw_means(outcomes, outcomes.found, texture, belongs, pictures_a_view), draws);
  Effect effect{name, two_level_difference(differences, {}, 1),
                two_level_rate_difference(found, painted,
                                          rate_difference(detail::found_in(outcomes, control, belongs),
                                                          detail::found_in(outcomes, texture, belongs, draws),
                                                          pictures_a_view * draws))};
  effect.odds_ratio = odds_ratio(found, painted, pictures_a_view, pictures_a_view);
  effect.draws = draws;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    double sum = 0;
    for (std::size_t view = 0; view < views; ++view) sum += differences(draw, view);
    effect.draws_at_most += sum <= 0 ? 1U : 0U;
  }
  return effect;
}

/// Mean of one effect divided by the mean of another, see two_level_ratio(). Nothing if the second does not
/// differ from 0, or if their views differ.
/// \param part, whole  effects, [draw, view]
[[nodiscard]] std::optional<PairedRatio> share_kept(const Array<double, 2>& part,
                                                    const Array<double, 2>& whole);

/// The effect of a texture beyond a control on mean best confidence in some frames, divided by that in
/// other frames of the same views in the same order. Nothing if the second does not differ from 0, or if
/// one of them lacks frames.
///
/// \param control, texture           their numbers in the outcomes
/// \param in_part, in_whole          which frames, by their indices
/// \param pictures_a_view_in_part    as for view_means(); the whole has one
/// \throws ShapeError as view_means()
template <std::predicate<std::size_t> InPart, std::predicate<std::size_t> InWhole>
[[nodiscard]] std::optional<PairedRatio> effect_kept(const ProtocolOutcomes& outcomes, std::size_t control,
                                                     std::size_t texture, InPart in_part,
                                                     std::size_t pictures_a_view_in_part, InWhole in_whole) {
  const auto effects = [&](auto belongs, std::size_t pictures_a_view) {
    return draw_differences(outcomes, outcomes.best_confidence, control, texture, belongs, pictures_a_view);
  };
  const auto part = effects(in_part, pictures_a_view_in_part), whole = effects(in_whole, 1);
  return share_kept(part, whole);
}

/// P@0.5 at other thresholds of confidence, one entry each; none may be below the meter's least threshold.
///
/// \param texture          its number in the outcomes
/// \param pictures_a_view  photographs of one view
/// \throws ShapeError if the arrays of the outcomes differ in their extents, or there is no such texture; as
///         detection_rate()
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<DetectionRate> sweep_of(const ProtocolOutcomes& outcomes, std::size_t texture,
                                                  const std::vector<double>& thresholds, Belongs belongs,
                                                  std::size_t pictures_a_view = 1) {
  return rates_above(thresholds, measured_values(outcomes, outcomes.found_confidence, texture, belongs),
                     {pictures_a_view, outcomes.draws_of(texture)});
}

/// The cells of a table, row by row.
/// \param frames  one for every frame of the outcomes
/// \throws ShapeError as cell_of(), or for another number of frames or a frame beside the table
[[nodiscard]] std::vector<Cell> cells_of(const ProtocolTable& table, const std::vector<ProtocolFrame>& frames,
                                         const ProtocolOutcomes& outcomes);

/// The cell where a texture hides the car least, by the upper end of attack success's interval, so that one
/// frame does not outweigh ninety. None where the clean car is never found.
///
/// \param texture  its number in the outcomes
[[nodiscard]] std::optional<std::size_t> least_hidden_cell(const std::vector<Cell>& cells,
                                                           std::size_t texture);

/// The cell where a detector finds the car least, by the upper end of P@0.5's interval. None without frames.
[[nodiscard]] std::optional<std::size_t> least_found_cell(const std::vector<Cell>& cells,
                                                          std::size_t texture);
}  // namespace tapestry::evaluate
