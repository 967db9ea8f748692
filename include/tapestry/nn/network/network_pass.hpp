#pragma once
#include <tapestry/nn/network/window_plan.hpp>

namespace tapestry::nn {
template <std::floating_point T>
class Network;

/// The results of one forward pass over a Network, and what its adjoint needs. A pass may be used again, and
/// then keeps its memory; two threads must not share one.
template <std::floating_point T>
class NetworkPass {
 public:
  /// Values of a result in row-major order, for each of the batch. The pass owns them, until it is used
  /// again.
  [[nodiscard]] const T* output(std::size_t i) const { return where_[outputs_.at(i)]; }
  [[nodiscard]] std::size_t output_count() const { return outputs_.size(); }
  /// Whether forward_within() filled it, so that adjoints are defined within windows only.
  [[nodiscard]] bool is_within() const { return plan_ != nullptr; }

  /// State that a step kept for its adjoint, of the first image of the batch; see Network::step_of().
  [[nodiscard]] OperationState<T>& state(std::size_t step) { return states_.at(step * batch_); }

  /// Adds the time of all later calls to `times`, which must stay; null measures nothing.
  void set_times(PassTimes* times) {
    forward_times_ = times == nullptr ? nullptr : &times->forward;
    adjoint_times_ = times == nullptr ? nullptr : &times->adjoint;
  }

  /// Takes the side of every kink (the signs of leaky units and the choices of max-pooling) from another pass
  /// over the same network, in another precision or by another engine. A forward pass in float flips a few
  /// signs next to zero, and each flip changes the gradient by a step. A pass in double with the sides of the
  /// float pass is therefore a reference that differs by rounding only.
  /// \throws DomainError unless both passes are forward()'s for a gradient of as many pictures
  template <class U>
  void copy_branches(const NetworkPass<U>& other) {
    if (mode_ == Mode::inference || other.mode_ == Mode::inference || is_within() || other.is_within() ||
        states_.size() != other.states_.size())
      throw DomainError("copy_branches: the passes are not both for a gradient of the same pictures");
    for (std::size_t i = 0; i < states_.size(); ++i) {
      std::copy_n(other.states_[i].bits.data(), states_[i].bits.size(), states_[i].bits.data());
      for (std::size_t k = 0; k < states_[i].choices.size(); ++k)
        states_[i].choices.data()[k] = static_cast<ElementIndex<T>>(other.states_[i].choices.data()[k]);
    }
  }

 private:
  template <std::floating_point U>
  friend class NetworkPass;
  friend class Network<T>;

  /// \param kept   of the one picture, null if nothing is kept
  /// \param holds  whether only windows are computed, from what is kept; else it is filled
  void forward(const Program<T>& program, const ProgramUse& use, const std::vector<const T*>& inputs,
               Mode mode, Engine engine, std::size_t batch, KeptValues<T>* kept = nullptr,
               bool holds = false);

  void begin(const Program<T>& program, const std::vector<const T*>& inputs, Mode mode, std::size_t batch);

  /// Elements of a value that a step makes, over the whole batch.
  [[nodiscard]] std::size_t size_of_all(const Program<T>& program, std::size_t value) const {
    return batch_ * size_of(program.values[value].shape);
  }

  /// A value's elements for one of the batch. Constants are the same for all.
  template <class Element>
  [[nodiscard]] static TensorView<Element> view(const ProgramValue& value, Element* values, std::size_t n) {
    const bool is_own = values != nullptr && !value.is_constant();
    return {&value.shape, is_own ? values + n * size_of(value.shape) : values};
  }

  [[nodiscard]] bool is_active(const ProgramUse& use, std::size_t value) const {
    return use.follows_inputs[value] || (mode_ == Mode::training && use.follows_weights[value]);
  }

  /// Whether a set of operands or results has the i-th.
  [[nodiscard]] static bool has(std::uint64_t which, std::size_t i) {
    return i < 64 && (which >> i & 1U) != 0;
  }

  [[nodiscard]] AdjointReads reads_of(const ProgramStep<T>& step) const;

  /// Finds the values to keep: the results, and those that an adjoint will read.
  void find_kept(const Program<T>& program, const ProgramUse& use);

  void run(const Program<T>& program, const ProgramUse& use, std::size_t s, Engine engine);

  /// Whether a step's first result takes over the memory of its first operand, which no later step reads.
  [[nodiscard]] bool takes_over_first(const Program<T>& program, const ProgramUse& use, std::size_t s) const;

  void release(const ProgramUse& use, std::size_t value, std::size_t step);

  void adjoint(const Program<T>& program, const ProgramUse& use, const std::vector<const T*>& output_adjoints,
               const std::vector<T*>& inputs_adjoint, T* weights_adjoint,
               const std::vector<T*>& outputs_gathered, Engine engine);

  void seed(const Program<T>& program, std::size_t i, const T* adjoint);

  /// A result whose adjoint is wanted. The result may be a copy, in the other layout, of the value that later
  /// layers read; then it is the adjoint of that value.
  struct Gathered {
    std::size_t value;
    T* goal;
    const ProgramStep<T>* conversion;  ///< step that makes the copy; null if there is none
  };

  void find_gathered(const Program<T>& program, const std::vector<T*>& outputs_gathered);

  void gather(const Program<T>& program, const Gathered& wanted, Engine engine);

  [[nodiscard]] bool wants(const ProgramUse& use, const ProgramStep<T>& step, std::size_t i) const;

  void pull_back(const Program<T>& program, const ProgramUse& use, std::size_t s, Engine engine);

  /// \param goals     where each operand's adjoint is gathered, null where it is not wanted
  /// \param is_first  whether this step writes it first, of each operand
  /// \param n         first picture of the batch
  /// \param batch     number of pictures
  void call_adjoint(const Program<T>& program, const ProgramUse& use, std::size_t s,
                    const std::vector<T*>& goals, const std::vector<std::uint8_t>& is_first, std::size_t n,
                    std::size_t batch, Engine engine);

  [[nodiscard]] T* goal_of(const Program<T>& program, std::size_t value, std::uint8_t& is_first);

  /// Calls body(first of the batch, how many) for each call of an operation.
  template <class Body>
  void for_each_call(const ProgramStep<T>& step, Body body) const {
    if (step.operation->takes_batches()) return body(std::size_t(0), batch_);
    for (std::size_t n = 0; n < batch_; ++n) body(n, std::size_t(1));
  }

  /// The window of a value that is computed, forward or backward; null for all of it.
  [[nodiscard]] static const MapWindow* window_of(const MapWindowPlan* plan, std::size_t value) {
    return plan != nullptr && value != no_value && plan->changed[value] ? &*plan->changed[value] : nullptr;
  }

  /// Adds the gathered adjoint of the picture to the caller's, within the window.
  void add_within(const Program<T>& program, T* input_adjoint);

  Mode mode_ = Mode::inference;
  std::size_t batch_ = 1;
  std::shared_ptr<const MapWindowPlan> plan_{};  ///< after forward() with something kept
  KeptValues<T>* kept_ = nullptr;                ///< during such a forward()
  bool holds_ = false;
  OperationTimes* forward_times_ = nullptr;  ///< null if nothing is measured
  OperationTimes* adjoint_times_ = nullptr;
  std::vector<std::size_t> outputs_;
  std::vector<Buffer<T>> buffers_;  ///< one for each value that a step makes
  std::vector<const T*> where_;     ///< each value, constants and inputs included
  std::vector<bool> is_kept_;
  std::vector<OperationState<T>> states_;  ///< one for each step and each of the batch
  std::vector<Buffer<T>> adjoints_;        ///< one for each value, while it is gathered
  std::vector<T*> goals_;                  ///< receive the adjoints of inputs and weights
  std::vector<Gathered> gathered_;         ///< results whose adjoints are wanted
  std::vector<bool> is_scaled_;            ///< steps whose adjoint_scale() the results' adjoints have taken
  bool wants_inputs_ = false;
  bool wants_weights_ = false;
  std::vector<TensorView<const T>> inputs_;
  std::vector<TensorView<T>> results_;
  Workspace<T> workspace_;
};

extern template class NetworkPass<float>;
extern template class NetworkPass<double>;
}  // namespace tapestry::nn
