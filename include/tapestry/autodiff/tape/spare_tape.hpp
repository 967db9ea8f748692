#pragma once
#include <cstddef>
#include <tapestry/autodiff/tape.hpp>
#include <utility>

namespace tapestry::detail {

/// A tape for the length of a call, in memory that an earlier call on this thread has left: fresh pages can
/// cost more than what is recorded on them. Of nested calls each has a tape of its own. What arrays were
/// recorded on, or takes more than 128 MiB with its adjoints, is not left. Not for destructors of objects of
/// static storage: the thread's own objects are gone by then.
template <class T>
class SpareTape {
 public:
  SpareTape() : tape_(std::move(left())) {}
  SpareTape(const SpareTape&) = delete;
  SpareTape& operator=(const SpareTape&) = delete;
  ~SpareTape() {
    try {
      const auto& state = *tape_.shared_state();
      if (state.array_memory != nullptr || is_large(state)) return;
      tape_.clear();
      left() = std::move(tape_);
    } catch (...) {  // it is only not left
    }
  }

  [[nodiscard]] Tape<T>& operator*() { return tape_; }
  [[nodiscard]] Tape<T>* operator->() { return &tape_; }

 private:
  [[nodiscard]] bool is_large(const TapeState<T>& state) const {
    return state.chunk_bytes() + tape_.statement_count() * sizeof(T) > most_bytes;
  }

  static constexpr std::size_t most_bytes = std::size_t(1) << 27U;

  static Tape<T>& left() {
    static thread_local Tape<T> tape;
    return tape;
  }

  Tape<T> tape_;
};

}  // namespace tapestry::detail
