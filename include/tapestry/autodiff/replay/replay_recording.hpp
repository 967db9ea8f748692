#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tapestry/autodiff/replay/growing_memory.hpp>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <unordered_map>
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
  bool* refused;  ///< by lane: whether a comparison differs from the recording
};

template <class T>
struct ReplayOperation;

/// Consecutive statements of one operation, and where their elements of each array begin. A run stores its
/// places, so that none waits for the one before.
template <class T>
struct ReplayRun {
  const ReplayOperation<T>* operation;
  std::uint32_t count;
  std::uint32_t result;  ///< slot of the first statement
  std::uint32_t operand;
  std::uint32_t constant;
  std::uint32_t partial;
  bool is_chain = false;   ///< each statement's first operand is the result before its own, and no other is
  bool is_needed = false;  ///< by lane: whether to compute it again in the reverse sweep
};

/// Functions and counts that all statements of one expression type share.
template <class T>
struct ReplayOperation {
  void (*forward)(const ReplayRun<T>&, const ReplayArrays<T>&) = nullptr;
  void (*backward)(const ReplayRun<T>&, const ReplayArrays<T>&) = nullptr;
  void (*backward_with_care)(const ReplayRun<T>&, const ReplayArrays<T>&) = nullptr;  ///< see LaneStatement
  std::size_t operand_count = 0;
  std::size_t constant_count = 0;
  std::size_t partial_count = 0;
  bool has_result = false;
  bool can_chain = false;
  bool is_cheap = false;        ///< to be computed again rather than kept
  bool reads_operands = false;  ///< on the way backwards
};

/// Statements in a window: few enough for their values to stay in the cache.
inline constexpr std::size_t replay_window = 4096;

/// A recording, or its last window, in the order in which it ran. Its slots, counted from 1 on, are inputs,
/// constants and results in the order in which they came.
template <class T>
struct ReplayRecording {
  struct Statement {
    const ReplayOperation<T>* operation;
    std::uint32_t first_operand;
    std::uint32_t first_constant;
    std::uint32_t result;  ///< its slot; 0 if it has none
    std::uint32_t depth;   ///< how many of its window must run one after another before it
  };
  struct Given {
    std::uint32_t slot;
    T value;
  };
  /// For slots of the window their depths; for others, the places that ReplayProgram has written.
  GrowingArray<std::uint32_t> places{};
  std::size_t first_of_window = 0;  ///< slot
  std::vector<Given> given{};       ///< slots that no statement computes, but for inputs
  GrowingArray<Statement> statements{};
  GrowingArray<std::uint32_t> operands{};
  GrowingArray<T> constants{};

  [[nodiscard]] std::size_t slot_count() const { return places.size(); }
  std::uint32_t append_slot(std::uint32_t depth) {
    *places.append(1) = depth;
    return static_cast<std::uint32_t>(places.size() - 1);
  }
  [[nodiscard]] std::uint32_t depth_of(std::uint32_t slot) const {
    return slot < first_of_window ? 0 : places[slot];
  }
  /// Appends slot 0, which is unused, and those of so many inputs: their places are these numbers.
  void append_inputs(std::size_t count) {
    std::uint32_t* const first = places.append(count + 1);
    std::iota(first, first + count + 1, 0U);
    first_of_window = count + 1;
  }
  void clear_window() {
    given.clear();
    statements.clear();
    operands.clear();
    constants.clear();
  }
};

/// Numbers the operations of a recording in the order in which they come.
template <class T>
class OperationNumbers {
 public:
  [[nodiscard]] std::uint32_t of(const ReplayOperation<T>* operation) {
    const ReplayOperation<T>*& last = operations_[reinterpret_cast<std::uintptr_t>(operation) / 16 % places];
    std::uint32_t& number = numbers_[static_cast<std::size_t>(&last - operations_.data())];
    if (last != operation) {
      last = operation;
      number = numbers_of_all_.try_emplace(operation, count()).first->second;
    }
    return number;
  }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(numbers_of_all_.size()); }

 private:
  static constexpr std::size_t places = 64;
  std::array<const ReplayOperation<T>*, places> operations_{};  ///< the last ones looked up
  std::array<std::uint32_t, places> numbers_{};
  std::unordered_map<const ReplayOperation<T>*, std::uint32_t> numbers_of_all_;
};

/// The order in which statements run: within a window, they go by their depth, then by their operation.
template <class T>
class ReplayOrder {
 public:
  /// Places in `window`; valid until the next call.
  [[nodiscard]] std::span<const std::uint32_t> of(
      std::span<const typename ReplayRecording<T>::Statement> window) {
    std::uint32_t depths = 0;
    for (std::size_t i = 0; i < window.size(); ++i) {
      depth_[i] = window[i].depth;
      depths = std::max(depths, depth_[i] + 1);
      operation_[i] = operations_.of(window[i].operation);
    }
    // A counting sort, first by operation, then by depth.
    std::iota(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(window.size()), 0U);
    const auto count = static_cast<std::uint32_t>(window.size());
    count_out(order_.data(), by_operation_.data(), count, operation_.data(), operations_.count());
    count_out(by_operation_.data(), order_.data(), count, depth_.data(), depths);
    return {order_.data(), window.size()};
  }

 private:
  /// Writes so many places to `to` in the order of their keys; equal keys keep the order of `from`.
  void count_out(const std::uint32_t* from, std::uint32_t* to, std::uint32_t count, const std::uint32_t* keys,
                 std::uint32_t key_count) {
    begins_.assign(key_count + 1, 0);
    for (std::uint32_t i = 0; i < count; ++i) ++begins_[keys[i] + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    for (std::uint32_t i = 0; i < count; ++i) to[begins_[keys[from[i]]]++] = from[i];
  }

  OperationNumbers<T> operations_;
  std::array<std::uint32_t, replay_window> depth_, operation_, by_operation_, order_;
  std::vector<std::uint32_t> begins_;
};

/// A complete recording.
template <class T>
[[nodiscard]] HugeVector<std::uint32_t> replay_order(const ReplayRecording<T>& recording) {
  HugeVector<std::uint32_t> all;
  all.reserve(recording.statements.size());
  ReplayOrder<T> order;
  const std::span<const typename ReplayRecording<T>::Statement> statements(recording.statements.data(),
                                                                           recording.statements.size());
  for (std::size_t begin = 0; begin < statements.size(); begin += replay_window)
    for (const std::uint32_t s :
         order.of(statements.subspan(begin, std::min(replay_window, statements.size() - begin))))
      all.push_back(static_cast<std::uint32_t>(begin) + s);
  return all;
}

}  // namespace tapestry::detail
