#pragma once
#include <tapestry/autodiff/variable.hpp>

namespace tapestry::detail {
/// A tape and its inputs for the length of a call, in memory that an earlier call on this thread has left:
/// fresh pages can cost more than the statements on them. Each nested call has its own. Memory of tapes that
/// held arrays, or of more than 128 MiB with adjoints, is not left. Not for destructors of objects of static
/// storage, since the thread's own objects are gone by then.
template <class T>
class SpareTape {
 public:
  SpareTape() : held_(std::exchange(left(), Held())) {}
  SpareTape(const SpareTape&) = delete;
  SpareTape& operator=(const SpareTape&) = delete;
  ~SpareTape() {
    try {
      const auto& state = *held_.tape.shared_state();
      if (state.adjoint_lane != nullptr || is_large(state)) return;
      held_.tape.clear();
      left() = std::move(held_);
    } catch (...) {  // it is only not left
    }
  }

  [[nodiscard]] Tape<T>& operator*() { return held_.tape; }
  [[nodiscard]] Tape<T>* operator->() { return &held_.tape; }

  [[nodiscard]] std::span<const Variable<T>> input(std::span<const T> values) {
    held_.inputs.resize(values.size());
    held_.tape.input(values, held_.inputs);
    return held_.inputs;
  }

 private:
  struct Held {
    Tape<T> tape;
    std::vector<Variable<T>> inputs;
  };

  [[nodiscard]] bool is_large(const TapeState<T>& state) const {
    return state.chunk_bytes() + held_.tape.statement_count() * sizeof(T) +
               held_.inputs.capacity() * sizeof(Variable<T>) >
           most_bytes;
  }

  static constexpr std::size_t most_bytes = std::size_t(1) << 27U;

  static Held& left() {
    static thread_local Held held;
    return held;
  }

  Held held_;
};
}  // namespace tapestry::detail
