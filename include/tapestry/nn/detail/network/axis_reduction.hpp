#pragma once
#include <array>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/network/tensor.hpp>

namespace tapestry::nn {
/// Steps in memory between neighbours along each axis, in row-major order.
[[nodiscard]] inline std::vector<std::ptrdiff_t> strides_of(const Shape& shape) {
  std::vector<std::ptrdiff_t> strides(shape.size());
  std::ptrdiff_t stride = 1;
  for (std::size_t axis = shape.size(); axis-- > 0; stride *= static_cast<std::ptrdiff_t>(shape[axis]))
    strides[axis] = stride;
  return strides;
}

/// Nested loops, outermost first, that walk through several tensors at once, each with strides of its own:
/// 0 where a tensor stays at an element, below 0 where it is walked backwards.
template <std::size_t Tensors>
struct LoopNest {
  using Places = std::array<std::ptrdiff_t, Tensors>;
  /// One loop: how often it runs, and how far each operand moves.
  struct Loop {
    std::size_t extent = 1;
    Places strides{};
  };
  std::vector<Loop> loops{};

  [[nodiscard]] std::size_t size() const {
    std::size_t count = 1;
    for (const Loop& loop : loops) count *= loop.extent;
    return count;
  }

  /// Joins loops that can run as one, and drops loops of extent 1; at least one loop stays.
  void simplify() {
    std::vector<Loop> joined;
    for (const Loop& loop : loops) {
      if (loop.extent == 1) continue;
      const auto continues = [&](const Loop& outer) {
        for (std::size_t i = 0; i < Tensors; ++i)
          if (outer.strides[i] != loop.strides[i] * static_cast<std::ptrdiff_t>(loop.extent)) return false;
        return true;
      };
      if (!joined.empty() && continues(joined.back())) {
        joined.back() = {joined.back().extent * loop.extent, loop.strides};
      } else {
        joined.push_back(loop);
      }
    }
    if (joined.empty()) joined.push_back({});
    loops = std::move(joined);
  }

  /// Place of the element with this index; indices count the innermost loop first.
  [[nodiscard]] Places place_of(std::size_t element) const {
    Places place{};
    for (std::size_t l = loops.size(); l-- > 0; element /= loops[l].extent)
      for (std::size_t i = 0; i < Tensors; ++i)
        place[i] += static_cast<std::ptrdiff_t>(element % loops[l].extent) * loops[l].strides[i];
    return place;
  }
};

namespace detail {
inline constexpr std::size_t nest_block = 65536;  ///< elements that one thread takes at a time

/// Calls body(place, count) for runs first … last − 1 of a nest that has any element.
template <std::size_t Tensors, class Body>
void for_each_run(const LoopNest<Tensors>& nest, std::size_t first, std::size_t last, const Body& body) {
  const auto& loops = nest.loops;
  const std::size_t outer = loops.size() - 1;
  auto place = nest.place_of(first * loops.back().extent);
  std::vector<std::size_t> index(outer);
  for (std::size_t l = outer, rest = first; l-- > 0; rest /= loops[l].extent)
    index[l] = rest % loops[l].extent;
  for (std::size_t run = first; run < last; ++run) {
    body(place, loops.back().extent);
    for (std::size_t l = outer; l-- > 0;) {
      const bool wraps = ++index[l] == loops[l].extent;
      const auto steps = wraps ? 1 - static_cast<std::ptrdiff_t>(loops[l].extent) : std::ptrdiff_t(1);
      for (std::size_t i = 0; i < Tensors; ++i) place[i] += steps * loops[l].strides[i];
      if (!wraps) break;
      index[l] = 0;
    }
  }
}
}  // namespace detail

/// Calls body(place, count) for pieces of the innermost loop, one after another: `place` is where each tensor
/// is at the piece's first element.
template <std::size_t Tensors, class Body>
void for_each_run(const LoopNest<Tensors>& nest, const Body& body) {
  const std::size_t count = nest.size();
  if (count > 0) detail::for_each_run(nest, 0, count / nest.loops.back().extent, body);
}

/// The same on several threads, in any order, if there is enough work. The pieces do not depend on the number
/// of threads.
template <std::size_t Tensors, class Body>
void parallel_for_each_run(const LoopNest<Tensors>& nest, const Body& body) {
  const std::size_t count = nest.size();
  if (count == 0) return;
  const auto& last = nest.loops.back();
  const std::size_t runs = count / last.extent;
  if (last.extent <= detail::nest_block) {
    const std::size_t together = detail::nest_block / last.extent;
    parallel_for_blocks(runs, together, [&](std::size_t begin, std::size_t end) {
      detail::for_each_run(nest, begin, end, body);
    });
    return;
  }
  const std::size_t pieces = block_count(last.extent, detail::nest_block);
  parallel_for(runs * pieces, [&](std::size_t i) {
    const BlockRange range = block_range(i % pieces, last.extent, detail::nest_block);
    body(nest.place_of(i / pieces * last.extent + range.begin), range.end - range.begin);
  });
}

/// How a tensor in row-major order is reduced along some of its axes. Lanes are neighbours with one result
/// each. Where the last axis is itself reduced, a lane is a single value.
struct AxisReduction {
  LoopNest<2> kept{};     ///< loops over groups of lanes: places among values and results
  LoopNest<1> reduced{};  ///< loop over the values of a lane
  std::size_t lanes = 1;
  std::ptrdiff_t lane_step = 0;  ///< step from a lane's result to the next
  std::size_t count = 1;         ///< number of values that go to one result

  AxisReduction() = default;
  /// \param to_strides  of the results, for the axes that stay
  AxisReduction(const Shape& shape, const std::vector<bool>& is_reduced,
                const std::vector<std::ptrdiff_t>& to_strides) {
    const auto strides = strides_of(shape);
    std::size_t last = shape.size();
    while (last > 0 && shape[last - 1] == 1) --last;
    for (std::size_t axis = 0; axis < last; ++axis) {
      if (is_reduced[axis]) {
        reduced.loops.push_back({shape[axis], {strides[axis]}});
      } else {
        kept.loops.push_back({shape[axis], {strides[axis], to_strides[axis]}});
      }
    }
    count = reduced.size();
    const bool has_lanes = last > 0 && !is_reduced[last - 1];
    reduced.simplify();
    kept.simplify();
    if (!has_lanes) return;
    lanes = kept.loops.back().extent;  // stride 1, because it ends in the last axis
    lane_step = kept.loops.back().strides[1];
    kept.loops.pop_back();
    kept.simplify();
  }
};

namespace detail {
inline constexpr std::size_t lane_block = 64;
using Lanes = std::array<double, lane_block>;

/// sums[l] = Step(sums[l], from[l]) for the lanes of one place.
template <class Step, std::floating_point T>
void reduce_lanes(const T* from, const Lanes& shifts, Lanes& sums, std::size_t lanes) {
  struct Body {
    const T* from;
    const double* shifts;
    double* sums;
    [[gnu::always_inline]] void operator()(std::size_t l) const {
      sums[l] = Step::next(sums[l], static_cast<double>(from[l]) - shifts[l]);
    }
  };
  tapestry::detail::plain_block<16>(lanes, Body{from, shifts.data(), sums.data()});
}

/// The same for neighbours that belong to one lane, in sixteen parts side by side.
template <class Step, std::floating_point T>
[[nodiscard]] double reduce_run(const T* from, double shift, double sum, std::size_t count) {
  std::size_t i = 0;
  if (count >= 32) {
    double parts[16];
    std::fill_n(parts, 16, Step::first());
    for (; i + 16 <= count; i += 16)
      for (std::size_t k = 0; k < 16; ++k)
        parts[k] = Step::next(parts[k], static_cast<double>(from[i + k]) - shift);
    for (const double part : parts) sum = Step::join(sum, part);
  }
  for (; i < count; ++i) sum = Step::next(sum, static_cast<double>(from[i]) - shift);
  return sum;
}
}  // namespace detail

/// Calls finish(place of the result, Step's sum) for each result, on several threads where there is work.
///
/// Step has first(), next(sum, value) and join(sum, sum), all in double. Each sum is taken in an order that
/// the extents alone decide.
/// \param shifts  numbers subtracted from the values of each result, laid out like the results; or null
template <class Step, std::floating_point T, class Finish>
void reduce(const AxisReduction& plan, const T* from, const T* shifts, const Finish& finish) {
  const std::size_t groups = plan.kept.size(), blocks = block_count(plan.lanes, detail::lane_block);
  const std::size_t tasks = groups * blocks, work = std::min(plan.lanes, detail::lane_block) * plan.count;
  const auto run_task = [&](std::size_t task) {
    const auto place = plan.kept.place_of(task / blocks);
    const BlockRange range = block_range(task % blocks, plan.lanes, detail::lane_block);
    const std::size_t lanes = range.end - range.begin;
    const T* const first = from + place[0] + range.begin;
    const auto result = [&](std::size_t lane) {
      return place[1] + static_cast<std::ptrdiff_t>(range.begin + lane) * plan.lane_step;
    };
    detail::Lanes sums, shift{};
    sums.fill(Step::first());
    for (std::size_t l = 0; l < lanes && shifts != nullptr; ++l)
      shift[l] = static_cast<double>(shifts[result(l)]);
    for_each_run(plan.reduced, [&](const auto& at, std::size_t count) {
      if (plan.lanes == 1 && plan.reduced.loops.back().strides[0] == 1) {
        sums[0] = detail::reduce_run<Step>(first + at[0], shift[0], sums[0], count);
        return;
      }
      for (std::size_t i = 0; i < count; ++i)
        detail::reduce_lanes<Step>(
            first + at[0] + static_cast<std::ptrdiff_t>(i) * plan.reduced.loops.back().strides[0], shift,
            sums, lanes);
    });
    for (std::size_t l = 0; l < lanes; ++l) finish(result(l), sums[l]);
  };
  const std::size_t together = std::max<std::size_t>(detail::nest_block / std::max<std::size_t>(work, 1), 1);
  parallel_for_blocks(tasks, together, [&](std::size_t begin, std::size_t end) {
    for (std::size_t task = begin; task < end; ++task) run_task(task);
  });
}

/// Σ x.
struct SumStep {
  static double first() { return 0; }
  static double next(double sum, double value) { return sum + value; }
  static double join(double sum, double part) { return sum + part; }
};

/// NaN before everything.
struct LargestStep {
  static double first() { return -std::numeric_limits<double>::infinity(); }
  static double next(double best, double value) { return value > best || value != value ? value : best; }
  static double join(double best, double part) { return best != best ? best : next(best, part); }
};
/// to[place] = scale · Σ of its values, or += that.
template <std::floating_point T>
void sum_to(const AxisReduction& plan, const T* from, double scale, bool is_uninitialised, T* to) {
  reduce<SumStep>(plan, from, static_cast<const T*>(nullptr), [&](std::ptrdiff_t place, double sum) {
    to[place] = static_cast<T>(scale * sum) + (is_uninitialised ? T(0) : to[place]);
  });
}
}  // namespace tapestry::nn
