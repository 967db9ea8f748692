#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/program.hpp>
#include <tapestry/nn/workspace.hpp>
#include <vector>

namespace tapestry::nn {

template <std::floating_point T>
class Network;

/// The results of one forward pass over a Network, and what its adjoint needs. A pass may be used again, and
/// then keeps its memory; two threads must not share one.
template <std::floating_point T>
class NetworkPass {
 public:
  /// Values of a result in row-major order, the pass's own until it is used again.
  [[nodiscard]] const T* output(std::size_t i) const { return where_[outputs_.at(i)]; }

 private:
  friend class Network<T>;

  void forward(const Program<T>& program, const ProgramUse& use, const std::vector<const T*>& inputs,
               Mode mode, Engine engine);

  void begin(const Program<T>& program, const std::vector<const T*>& inputs, Mode mode);

  [[nodiscard]] bool is_active(const ProgramUse& use, std::size_t value) const {
    return use.follows_inputs[value] || (mode_ == Mode::training && use.follows_weights[value]);
  }

  /// Whether a set of operands or results has the i-th.
  [[nodiscard]] static bool has(std::uint64_t which, std::size_t i) {
    return i < 64 && (which >> i & 1U) != 0;
  }

  [[nodiscard]] AdjointReads reads_of(const ProgramStep<T>& step) const;

  /// Values that an adjoint will read are kept until then, and so are results.
  void find_kept(const Program<T>& program, const ProgramUse& use);

  void run(const Program<T>& program, const ProgramUse& use, std::size_t s, Engine engine);

  /// Whether a step's first result takes the memory of its first operand, which nobody else reads any more.
  [[nodiscard]] bool takes_over_first(const Program<T>& program, const ProgramUse& use, std::size_t s) const;

  void release(const ProgramUse& use, std::size_t value, std::size_t step);

  void adjoint(const Program<T>& program, const ProgramUse& use, const std::vector<const T*>& output_adjoints,
               const std::vector<T*>& inputs_adjoint, T* constants_adjoint,
               const std::vector<T*>& outputs_gathered, Engine engine);

  void seed(const Program<T>& program, std::size_t i, const T* adjoint);

  /// A result whose adjoint is wanted: that of the value that the network goes on with, of which the result
  /// may be a copy in the other layout.
  struct Gathered {
    std::size_t value;
    T* goal;
    const ProgramStep<T>* conversion;  ///< that makes the copy; null if there is none
  };

  void find_gathered(const Program<T>& program, const std::vector<T*>& outputs_gathered);

  void gather(const Program<T>& program, const Gathered& wanted, Engine engine);

  [[nodiscard]] bool wants(const ProgramUse& use, const ProgramStep<T>& step, std::size_t i) const;

  void pull_back(const Program<T>& program, const ProgramUse& use, std::size_t s, Engine engine);

  /// Where an operand's adjoint is gathered, and whether it is written for the first time.
  [[nodiscard]] T* goal_of(const Program<T>& program, const ProgramStep<T>& step, std::size_t i,
                           bool& is_fresh);

  Mode mode_ = Mode::inference;
  std::vector<std::size_t> outputs_;
  std::vector<Buffer<T>> buffers_;  ///< of each value that a step makes
  std::vector<const T*> where_;     ///< each value, constants and inputs included
  std::vector<bool> is_kept_;
  std::vector<OperationState<T>> states_;  ///< of each step
  std::vector<Buffer<T>> adjoints_;        ///< of each value, while they are gathered
  std::vector<T*> goals_;                  ///< where adjoints of inputs and weights go
  std::vector<Gathered> gathered_;         ///< results whose adjoints are wanted
  bool wants_inputs_ = false;
  bool wants_weights_ = false;
  std::vector<TensorView<const T>> inputs_;
  std::vector<TensorView<T>> results_;
  Workspace<T> workspace_;
};

}  // namespace tapestry::nn
