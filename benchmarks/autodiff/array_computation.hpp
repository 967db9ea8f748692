#pragma once
#include "array_forms.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {
template <class Objective>
concept HasArrayForm = requires {
  ArrayForm<Objective, double>::extents();
};

/// Records an array form and reverses it, keeping the tape's memory from run to run. The gradient stays where
/// the tape left it until it is read.
template <HasArrayForm Objective, class T, class Form = ArrayForm<Objective, T>>
class ArrayTape final : public Computation {
  static constexpr std::size_t rank = std::tuple_size_v<decltype(Form::extents())>;

 public:
  explicit ArrayTape(const Objective& objective) : form_(objective) {
    x_ = detail::constants<T, rank>(objective.start(), form_.extents());
  }
  void run() override {
    const auto scope = tape_.activate();
    tape_.clear();
    input_ = tape_.input(x_);
    const Variable<T> result = form_(input_);
    value_ = static_cast<double>(result.value());
    tape_.reverse(result);
  }
  void finish() override {
    const Array<T, rank>& adjoint = input_.adjoint();
    gradient_.assign(adjoint.begin(), adjoint.end());
  }

 private:
  Form form_;
  ArrayVariable<T, rank> x_, input_;
  Tape<T> tape_;
};
}  // namespace tapestry::benchmarks
