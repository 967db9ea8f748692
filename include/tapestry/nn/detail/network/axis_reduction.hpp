#pragma once
#include <tapestry/core/block_loop.hpp>
#include <tapestry/nn/detail/network/loop_nest.hpp>

namespace tapestry::nn {

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
