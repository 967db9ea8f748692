#pragma once
#include <tapestry/nn/network/program.hpp>

namespace tapestry::nn {
/// Rows and columns of each value that a pass must recompute when the network's only input, a picture stored
/// channels last, changes within a window. Values that are not maps of one picture are recomputed whole.
struct MapWindowPlan {
  Engine engine = Engine::automatic;  ///< engine whose tiles the windows contain
  MapWindow picture{};                ///< window of the picture that changes; may be empty
  /// Part of each value whose bits depend on the picture's window; adjoints are needed only there. None: all.
  std::vector<std::optional<MapWindow>> changed{};
  /// `changed`, and the values around it that are read to compute other changed values. None: all.
  std::vector<std::optional<MapWindow>> read{};
};

/// The rows and columns of a value that is a map of one picture; nothing for others.
[[nodiscard]] inline std::optional<MapWindow> map_of(const ProgramValue& value) {
  if (!value.channels_last || value.is_constant() || value.shape.size() != 4 || value.shape[0] != 1)
    return std::nullopt;
  return MapWindow{{0, value.shape[1]}, {0, value.shape[2]}};
}

/// \param picture       the window that changes
/// \param with_adjoint  whether the input's adjoint within the window is wanted, too
template <std::floating_point T>
[[nodiscard]] MapWindowPlan plan_windows(const Program<T>& program, Engine engine, const MapWindow& picture,
                                         bool with_adjoint) {
  MapWindowPlan plan;
  plan.engine = engine;
  plan.picture = picture;
  plan.changed.resize(program.values.size());
  if (program.inputs.size() == 1)
    if (const auto map = map_of(program.values[program.inputs[0]]))
      plan.changed[program.inputs[0]] = at_least_a_pixel(picture, map->rows.end, map->columns.end);
  const auto is_computed = [&](std::size_t v) { return v != no_value && !program.values[v].is_constant(); };
  for (const ProgramStep<T>& step : program.steps) {
    std::vector<MapWindow> operands(step.inputs.size());  // empty for constants
    bool has_windows = true;
    for (std::size_t i = 0; i < operands.size(); ++i) {
      if (!is_computed(step.inputs[i])) continue;
      has_windows = has_windows && plan.changed[step.inputs[i]];
      operands[i] = plan.changed[step.inputs[i]].value_or(MapWindow{});
    }
    const auto reached =
        has_windows ? step.operation->window_reached(engine, operands, with_adjoint) : std::nullopt;
    for (const std::size_t output : step.outputs)
      if (const auto whole = map_of(program.values[output]);
          whole && reached && !reached->is_empty() && !reached->covers(whole->rows.end, whole->columns.end))
        plan.changed[output] = reached;
  }
  plan.read = plan.changed;
  for (const std::size_t output : program.outputs) plan.read[output].reset();
  for (const ProgramStep<T>& step : program.steps)
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      const std::size_t input = step.inputs[i];
      if (!is_computed(input) || !plan.read[input]) continue;
      if (const auto& out = plan.changed[step.outputs.front()]) {
        plan.read[input] = hull(*plan.read[input], step.operation->window_read(engine, i, *out));
      } else {
        plan.read[input].reset();
      }
    }
  return plan;
}

/// Share of a program's multiply-adds that a plan saves, from 0 to 1.
template <std::floating_point T>
[[nodiscard]] double share_left_out(const Program<T>& program, const MapWindowPlan& plan) {
  double all = 0, left_out = 0;
  for (const ProgramStep<T>& step : program.steps) {
    const double products = step.operation->product_count();
    all += products;
    const std::size_t output = step.outputs.front();
    const auto& changed = plan.changed[output];
    if (products == 0 || !changed) continue;
    const auto pixels =
        static_cast<double>(program.values[output].shape[1] * program.values[output].shape[2]);
    left_out += products * (1 - static_cast<double>(changed->height() * changed->width()) / pixels);
  }
  return all > 0 ? left_out / all : 0;
}

/// Calls body(place, count) for the elements of a map that lie in the window `outer`, or anywhere, but not in
/// `inner`, in runs that lie side by side.
template <class Body>
void for_each_outside(const Shape& map, const std::optional<MapWindow>& outer, const MapWindow& inner,
                      Body body) {
  const std::size_t width = map[2], channels = map[3];
  const MapWindow all = outer.value_or(MapWindow{{0, map[1]}, {0, width}});
  const auto piece = [&](std::size_t y, std::size_t begin, std::size_t end) {
    if (begin < end) body((y * width + begin) * channels, (end - begin) * channels);
  };
  for (std::size_t y = all.rows.begin; y < all.rows.end; ++y) {
    if (y < inner.rows.begin || y >= inner.rows.end) {
      piece(y, all.columns.begin, all.columns.end);
    } else {
      piece(y, all.columns.begin, inner.columns.begin);
      piece(y, inner.columns.end, all.columns.end);
    }
  }
}

/// Digest of a picture's elements outside a window. It differs if one element does, and is equal for one in
/// 2^64 of other changes.
template <std::floating_point T>
[[nodiscard]] std::uint64_t digest_outside(const Shape& map, const MapWindow& window, const T* values) {
  constexpr std::uint64_t odd = 0x9E3779B97F4A7C15;
  using Word = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  std::array<std::uint64_t, 4> lanes{};  // side by side: a product takes as long as four
  for_each_outside(map, std::nullopt, window, [&](std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      std::uint64_t& lane = lanes[i % 4];
      lane = std::rotl((lane ^ std::bit_cast<Word>(values[i])) * odd, 29);
    }
  });
  for (std::size_t k = 1; k < 4; ++k) lanes[0] = std::rotl((lanes[0] ^ lanes[k]) * odd, 29);
  return lanes[0];
}

/// The memory of a network about a picture that changes from pass to pass within one window: for each value,
/// the pixels around its own window that are read to compute the changed ones. See Network::forward_within().
template <std::floating_point T>
struct KeptValues {
  std::shared_ptr<const MapWindowPlan> plan{};  ///< null: nothing is kept
  std::vector<Buffer<T>> rings{};               ///< one for each value; empty if nothing is needed
  std::uint64_t surroundings = 0;               ///< digest_outside() of the last pass's picture
  std::weak_ptr<const void> constants{};        ///< constants of the last pass
  Mode mode = Mode::inference;                  ///< mode of the last pass

  [[nodiscard]] std::size_t bytes() const {
    std::size_t count = 0;
    for (const auto& ring : rings) count += ring.size();
    return count * sizeof(T);
  }

  /// Copies a value's ring from its elements, or back.
  void save(const Shape& map, std::size_t value, const T* values) {
    std::size_t count = 0;
    for_each_piece(map, value, [&](std::size_t, std::size_t size) { count += size; });
    rings[value].resize(count);
    T* to = rings[value].data();
    for_each_piece(map, value, [&](std::size_t first, std::size_t size) {
      std::memcpy(to, values + first, size * sizeof(T));
      to += size;
    });
  }
  void restore(const Shape& map, std::size_t value, T* values) const {
    const T* from = rings[value].data();
    for_each_piece(map, value, [&](std::size_t first, std::size_t size) {
      std::memcpy(values + first, from, size * sizeof(T));
      from += size;
    });
  }

 private:
  template <class Body>
  void for_each_piece(const Shape& map, std::size_t value, Body body) const {
    if (plan->changed[value]) for_each_outside(map, plan->read[value], *plan->changed[value], body);
  }
};
}  // namespace tapestry::nn
