#pragma once
#include <tapestry/evaluate/meter.hpp>

namespace tapestry::evaluate {
/// Outcome of a frame of a protocol.
enum class FrameState : std::uint8_t {
  pending = 0,
  measured = 1,
  left_out = 2,  ///< no part of the car shows, or the protocol's change is impossible
};

/// Outcomes of a detector on every picture of a protocol: each frame with each texture, the clean one first.
/// The draws of a random control are one texture, with a column each.
struct ProtocolOutcomes {
  Array<std::uint8_t, 1> state;       ///< [frame], a FrameState
  Array<std::uint8_t, 2> found;       ///< [frame, column], 0 or 1
  Array<std::uint8_t, 2> fate;        ///< [frame, column], a Fate
  Array<std::uint16_t, 2> named;      ///< [frame, column], class of the box that decides it; 0 for lost
  Array<double, 2> best_confidence;   ///< [frame, column], see best_confidence()
  Array<double, 2> found_confidence;  ///< [frame, column], see ViewResult
  Array<double, 2> attention;         ///< [frame, column], share of a heat map on the car; 0 without maps
  Array<float, 3> ranked;         ///< [frame, column, 2 · box], confidence and IoU, see ViewResult::ranked
  Array<double, 1> hidden_share;  ///< [frame], of the car's silhouette, 0 where nothing is laid over it
  Array<double, 1> car_share;     ///< [frame], of the picture, that the car covers
  std::vector<std::size_t> draws{};  ///< of each texture, side by side; empty: one of each

  ProtocolOutcomes() = default;
  ProtocolOutcomes(std::size_t frames, std::size_t columns)
      : state(zeros<std::uint8_t, 1>({frames})),
        found(zeros<std::uint8_t, 2>({frames, columns})),
        fate(zeros<std::uint8_t, 2>({frames, columns})),
        named(zeros<std::uint16_t, 2>({frames, columns})),
        best_confidence(zeros<double, 2>({frames, columns})),
        found_confidence(zeros<double, 2>({frames, columns})),
        attention(zeros<double, 2>({frames, columns})),
        ranked(zeros<float, 3>({frames, columns, 2 * most_ranked})),
        hidden_share(zeros<double, 1>({frames})),
        car_share(zeros<double, 1>({frames})) {}

  [[nodiscard]] std::size_t frame_count() const { return found.shape(0); }
  [[nodiscard]] std::size_t column_count() const { return found.shape(1); }
  [[nodiscard]] std::size_t texture_count() const { return draws.empty() ? column_count() : draws.size(); }
  [[nodiscard]] std::size_t draws_of(std::size_t texture) const { return draws.empty() ? 1 : draws[texture]; }
  /// Column of a texture's first draw.
  [[nodiscard]] std::size_t first_column(std::size_t texture) const {
    return draws.empty()
               ? texture
               : std::accumulate(draws.begin(), draws.begin() + static_cast<std::ptrdiff_t>(texture),
                                 std::size_t{0});
  }
  [[nodiscard]] FrameState state_of(std::size_t frame) const { return static_cast<FrameState>(state(frame)); }
};

/// Calls visit(frame, column) for each draw of one texture in each measured frame with belongs(index), a
/// frame's draws one after another.
/// \param texture  its number in the outcomes
/// \throws ShapeError if there is no such texture, or the number of draws is not that of columns
template <std::predicate<std::size_t> Belongs, std::invocable<std::size_t, std::size_t> Visit>
void for_each_measured(const ProtocolOutcomes& outcomes, std::size_t texture, Belongs belongs, Visit visit) {
  require_shape("for_each_measured", "state", outcomes.state, {outcomes.frame_count()});
  if (texture >= outcomes.texture_count())
    throw ShapeError({"measured_values: texture ", texture, " of ", outcomes.texture_count()});
  const std::size_t first = outcomes.first_column(texture), last = first + outcomes.draws_of(texture);
  if (last > outcomes.column_count())
    throw ShapeError({"measured_values: draws up to column ", last, " of ", outcomes.column_count()});
  for (std::size_t frame = 0; frame < outcomes.frame_count(); ++frame)
    if (outcomes.state_of(frame) == FrameState::measured && belongs(frame))
      for (std::size_t column = first; column < last; ++column) visit(frame, column);
}

/// Values of one texture, in the order of for_each_measured().
/// \param values   of the outcomes, [frame, column]
/// \throws ShapeError if values are not of the outcomes' extents; as for_each_measured()
template <class Value, std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<double> measured_values(const ProtocolOutcomes& outcomes,
                                                  const Array<Value, 2>& values, std::size_t texture,
                                                  Belongs belongs) {
  require_shape("measured_values", "values", values, {outcomes.frame_count(), outcomes.column_count()});
  std::vector<double> numbers;
  for_each_measured(outcomes, texture, belongs, [&](std::size_t frame, std::size_t column) {
    numbers.push_back(static_cast<double>(values(frame, column)));
  });
  return numbers;
}

/// ViewResult::ranked of the pictures of one texture, in the order of for_each_measured().
template <std::predicate<std::size_t> Belongs>
[[nodiscard]] std::vector<std::vector<BoxOnTarget>> ranked_boxes(const ProtocolOutcomes& outcomes,
                                                                 std::size_t texture, Belongs belongs) {
  std::vector<std::vector<BoxOnTarget>> pictures;
  for_each_measured(outcomes, texture, belongs, [&](std::size_t frame, std::size_t column) {
    auto& boxes = pictures.emplace_back();
    for (std::size_t i = 0; i < 2 * most_ranked && outcomes.ranked(frame, column, i) > 0; i += 2)
      boxes.push_back({outcomes.ranked(frame, column, i), outcomes.ranked(frame, column, i + 1)});
  });
  return pictures;
}
}  // namespace tapestry::evaluate
