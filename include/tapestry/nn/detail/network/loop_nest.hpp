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

}  // namespace tapestry::nn
