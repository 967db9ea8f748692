#pragma once
#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <utility>
#include <vector>

namespace tapestry::detail {

template <class T>
using HugeVector = std::vector<T, HugePageAllocator<T>>;

/// The arrays of a program.
template <class T>
struct ReplayArrays {
  T* values;    ///< of slots
  T* adjoints;  ///< of slots
  const std::uint32_t* operands;
  const T* constants;
  T* partials;
  bool* refused;  ///< of lanes: whether a comparison has come out otherwise than when recorded
};

template <class T>
struct ReplayOperation;

/// Consecutive statements of one operation, and where those of each array begin. A run knows its places, so
/// that none waits for the one before.
template <class T>
struct ReplayRun {
  const ReplayOperation<T>* operation;
  bool is_chain;  ///< each statement's first operand is the result before its own, and no other operand is
  std::uint32_t count;
  std::uint32_t result;  ///< slot of the first statement
  std::size_t operand;
  std::size_t constant;
  std::size_t partial;
};

/// What all statements of one expression type have in common.
template <class T>
struct ReplayOperation {
  void (*forward)(const ReplayRun<T>&, const ReplayArrays<T>&);
  void (*backward)(const ReplayRun<T>&, const ReplayArrays<T>&);
  void (*backward_with_care)(const ReplayRun<T>&, const ReplayArrays<T>&) = nullptr;  ///< see LaneStatement
  std::size_t operand_count = 0;
  std::size_t constant_count = 0;
  std::size_t partial_count = 0;
  bool has_result = false;
  bool can_chain = false;
  bool is_cheap = false;        ///< to be computed again rather than kept
  bool reads_operands = false;  ///< on the way backwards
};

/// A recording in the order in which it ran.
template <class T>
struct ReplayRecording {
  struct Statement {
    const ReplayOperation<T>* operation;
    std::uint32_t first_operand;
    std::uint32_t first_constant;
    std::uint32_t result;  ///< its slot; 0 if it has none
  };
  std::vector<T> slots{T(0)};  ///< values, from slot 1 on: inputs, constants and results as they came
  std::vector<Statement> statements{};
  std::vector<std::uint32_t> operands{};
  std::vector<T> constants{};
};

/// The order in which statements run. Within a window, statements go by their depth, then by their operation;
/// a window is small enough for what it computes to stay near.
inline constexpr std::size_t replay_window = 4096;

template <class T>
[[nodiscard]] std::uint32_t replay_depth(const ReplayRecording<T>& recording, std::size_t s,
                                         std::vector<std::uint32_t>& depth_of_slot) {
  const auto& statement = recording.statements[s];
  std::uint32_t depth = 0;
  for (std::size_t i = 0; i < statement.operation->operand_count; ++i)
    depth = std::max(depth, depth_of_slot[recording.operands[statement.first_operand + i]]);
  if (statement.result != 0) depth_of_slot[statement.result] = depth + 1;
  return depth;
}

template <class T>
[[nodiscard]] std::vector<std::uint32_t> replay_order(const ReplayRecording<T>& recording) {
  const std::size_t count = recording.statements.size();
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::uint32_t> depth_of_slot(recording.slots.size(), 0), depth(count);
  for (std::size_t begin = 0; begin < count; begin += replay_window) {
    const std::size_t end = std::min(begin + replay_window, count);
    for (std::size_t s = begin; s < end; ++s) depth[s] = replay_depth(recording, s, depth_of_slot);
    std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
                     order.begin() + static_cast<std::ptrdiff_t>(end), [&](auto a, auto b) {
                       const auto &left = recording.statements[a], &right = recording.statements[b];
                       return depth[a] != depth[b] ? depth[a] < depth[b]
                                                   : std::less<>()(left.operation, right.operation);
                     });
    for (std::size_t s = begin; s < end; ++s) depth_of_slot[recording.statements[s].result] = 0;
  }
  return order;
}

}  // namespace tapestry::detail
