#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
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
  bool* refused;  ///< of lanes: whether a comparison has come out otherwise than when recorded
};

template <class T>
struct ReplayOperation;

/// Consecutive statements of one operation, and where those of each array begin. A run knows its places, so
/// that none waits for the one before.
template <class T>
struct ReplayRun {
  const ReplayOperation<T>* operation;
  std::uint32_t count;
  std::uint32_t result;  ///< slot of the first statement
  std::uint32_t operand;
  std::uint32_t constant;
  std::uint32_t partial;
  bool is_chain = false;   ///< each statement's first operand is the result before its own, and no other is
  bool is_needed = false;  ///< of lanes: to be computed again on the way backwards
};

/// What all statements of one expression type have in common.
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

/// A recording in the order in which it ran.
template <class T>
struct ReplayRecording {
  struct Statement {
    const ReplayOperation<T>* operation;
    std::uint32_t first_operand;
    std::uint32_t first_constant;
    std::uint32_t result;  ///< its slot; 0 if it has none
  };
  HugeVector<T> slots{T(0)};  ///< values, from slot 1 on: inputs, constants and results as they came
  HugeVector<Statement> statements{};
  HugeVector<std::uint32_t> operands{};
  HugeVector<T> constants{};
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
  std::array<const ReplayOperation<T>*, places> operations_{};  ///< those asked for last
  std::array<std::uint32_t, places> numbers_{};
  std::unordered_map<const ReplayOperation<T>*, std::uint32_t> numbers_of_all_;
};

/// A window of statements is small enough for what it computes to stay near.
inline constexpr std::size_t replay_window = 4096;

/// The order in which statements run: within a window, they go by their depth, then by their operation.
template <class T>
class ReplayOrder {
 public:
  explicit ReplayOrder(const ReplayRecording<T>& recording)
      : recording_(recording), depth_of_slot_(recording.slots.size(), 0) {}

  /// The statements of the next window, until they are asked for again; none when there is no more.
  [[nodiscard]] std::span<const std::uint32_t> next() {
    const std::size_t begin = end_;
    end_ = std::min(begin + replay_window, recording_.statements.size());
    sort(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end_));
    return {order_.data(), end_ - begin};
  }

 private:
  /// Sorts by counting, first by operation, then by depth.
  void sort(std::uint32_t begin, std::uint32_t end) {
    std::uint32_t depths = 0;
    for (std::uint32_t s = begin; s < end; ++s) {
      depth_[s - begin] = depth_of(recording_.statements[s]);
      depths = std::max(depths, depth_[s - begin] + 1);
      operation_[s - begin] = operations_.of(recording_.statements[s].operation);
    }
    std::iota(by_operation_.begin(), by_operation_.begin() + (end - begin), 0U);
    std::uint32_t* const order = order_.data();
    count_out(by_operation_.data(), order, end - begin, operation_.data(), operations_.count());
    std::copy_n(order, end - begin, by_operation_.data());
    count_out(by_operation_.data(), order, end - begin, depth_.data(), depths);
    for (std::uint32_t i = 0; i < end - begin; ++i) order[i] += begin;
    for (std::uint32_t s = begin; s < end; ++s) depth_of_slot_[recording_.statements[s].result] = 0;
  }

  /// Writes so many places to `to` in the order of their keys, equal ones as they are in `from`.
  void count_out(const std::uint32_t* from, std::uint32_t* to, std::uint32_t count, const std::uint32_t* keys,
                 std::uint32_t key_count) {
    begins_.assign(key_count + 1, 0);
    for (std::uint32_t i = 0; i < count; ++i) ++begins_[keys[i] + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    for (std::uint32_t i = 0; i < count; ++i) to[begins_[keys[from[i]]]++] = from[i];
  }

  [[nodiscard]] std::uint32_t depth_of(const typename ReplayRecording<T>::Statement& statement) {
    std::uint32_t depth = 0;
    const std::uint32_t* const operands = recording_.operands.data() + statement.first_operand;
    for (std::size_t i = 0; i < statement.operation->operand_count; ++i)
      depth = std::max(depth, depth_of_slot_[operands[i]]);
    if (statement.result != 0) depth_of_slot_[statement.result] = depth + 1;
    return depth;
  }

  const ReplayRecording<T>& recording_;
  HugeVector<std::uint32_t> depth_of_slot_;
  OperationNumbers<T> operations_;
  std::array<std::uint32_t, replay_window> depth_, operation_, by_operation_, order_;
  std::size_t end_ = 0;
  std::vector<std::uint32_t> begins_;
};

/// The whole of it.
template <class T>
[[nodiscard]] HugeVector<std::uint32_t> replay_order(const ReplayRecording<T>& recording) {
  HugeVector<std::uint32_t> all;
  all.reserve(recording.statements.size());
  ReplayOrder<T> order(recording);
  for (auto window = order.next(); !window.empty(); window = order.next())
    all.insert(all.end(), window.begin(), window.end());
  return all;
}

}  // namespace tapestry::detail
