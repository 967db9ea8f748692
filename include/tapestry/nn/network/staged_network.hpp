#pragma once
#include <tapestry/nn/detail/network/plan_budget.hpp>
#include <tapestry/nn/network/network.hpp>

namespace tapestry::nn {
template <std::floating_point T>
class StagedNetwork;

/// Results of one run of a StagedNetwork, and what its adjoint needs. Keep it from run to run: stages with
/// the extents and integers of the last run are not made again.
template <std::floating_point T>
class StagedPass {
 public:
  [[nodiscard]] std::size_t output_count() const { return outputs_.size(); }
  /// Values of a result, in row-major order of output_shape(i).
  [[nodiscard]] const T* output(std::size_t i) const { return outputs_.at(i).values; }
  /// Extents of a result, which may change from run to run.
  [[nodiscard]] const Shape& output_shape(std::size_t i) const { return outputs_.at(i).shape; }
  /// Number of networks of fixed extents that ran one after the other.
  [[nodiscard]] std::size_t stage_count() const { return runs_.size(); }
  /// How many of them were made by the last run.
  [[nodiscard]] std::size_t made_count() const { return made_count_; }

 private:
  friend class StagedNetwork<T>;

  /// A part of the network at the extents of one run: nodes that can run, and those that wait for their
  /// results.
  struct Stage {
    std::shared_ptr<const Stage> before{};
    std::map<std::string, Constant> found{};  ///< integers and truths that the stages before have computed
    std::map<std::string, Shape> shapes{};    ///< extents of the numbers known before
    std::unique_ptr<Network<T>> network{};    ///< null if there is nothing to run
    std::vector<std::string> inputs{}, outputs{};  ///< of the network
    std::vector<ElementType> types{};              ///< of its outputs
    NetworkDescription rest{};                     ///< the nodes that wait
    std::optional<Engine> engine{};                ///< as of StagedNetwork
    PlanBudget budget{};                           ///< nodes left behind this stage
  };
  struct Run {
    std::shared_ptr<const Stage> stage{};
    NetworkPass<T> pass{};
  };
  struct Value {
    const T* values = nullptr;
    Shape shape{};
    ElementType type = ElementType::floating;
  };

  std::vector<std::unique_ptr<Run>> runs_{};
  std::map<std::string, Value> known_{};  ///< inputs, and results of networks
  std::vector<Value> outputs_{};
  std::map<std::string, Buffer<T>> constants_{};  ///< results that are known beforehand
  std::size_t made_count_ = 0;
};

/// A network whose extents depend on values: of boxes kept by suppression, of a condition's branch, of a
/// number of rounds. It runs as networks of fixed extents, one after the other: each has all nodes whose
/// extents are known. Integers and truths that it computes are constants of the next. Gradients run back
/// through all of them. Selections (by NonMaxSuppression, NonZero, TopK, a condition) count as constant: they
/// are, except where they jump.
template <std::floating_point T>
class StagedNetwork {
 public:
  /// \param shapes  extents of inputs, as of Network
  /// \param budget  for all plans of a run
  /// \throws FileError (mismatch) naming operators that are not supported, or an input whose extents are open
  explicit StagedNetwork(NetworkDescription description, const std::map<std::string, Shape>& shapes = {},
                         PlanBudget budget = {});

  /// Sets how later passes compute convolutions, see Network::set_engine().
  void set_engine(Engine engine);

  [[nodiscard]] std::size_t input_count() const { return inputs_.size(); }
  [[nodiscard]] const Shape& input_shape(std::size_t i) const { return shapes_.at(inputs_.at(i).name); }

  /// \param inputs  values of each input, of input_shape(), readable 128 bytes past their end
  /// \throws FileError (mismatch) naming nodes that cannot be run at the extents that come out; limit for
  ///         loops beyond PlanBudget
  void forward(const std::vector<const T*>& inputs, StagedPass<T>& pass, Mode mode = Mode::inference) const;

  /// Adds the adjoint of each input to `inputs_adjoint`.
  /// \param output_adjoints   of each result of pass.output_shape(); null for one without
  /// \param outputs_gathered  as of Network::adjoint(): receives the whole adjoint of results that others
  ///                          depend on; null for others; empty: of none
  void adjoint(StagedPass<T>& pass, const std::vector<const T*>& output_adjoints,
               const std::vector<T*>& inputs_adjoint, const std::vector<T*>& outputs_gathered = {}) const;

 private:
  using Stage = typename StagedPass<T>::Stage;
  using Value = typename StagedPass<T>::Value;

  /// Divides nodes into a network of those that can run and the rest.
  [[nodiscard]] static std::shared_ptr<const Stage> made(NetworkDescription description, Stage stage);

  /// The stage behind another one, whose results are known: the last run's, or a new one.
  [[nodiscard]] std::shared_ptr<const Stage> next(const std::shared_ptr<const Stage>& before,
                                                  StagedPass<T>& pass,
                                                  const std::shared_ptr<const Stage>& last) const;

  /// Results of nodes that choose by values, such as NonMaxSuppression, and whose operands are known.
  static void choose(const Stage& before, const StagedPass<T>& pass, std::map<std::string, Constant>& found);

  void run(StagedPass<T>& pass, typename StagedPass<T>::Run& run, Mode mode) const;

  void take_outputs(StagedPass<T>& pass, const Stage& last) const;

  std::vector<InputDescription> inputs_;
  std::map<std::string, Shape> shapes_;
  std::vector<std::string> outputs_;
  std::shared_ptr<const Stage> first_;
  std::optional<Engine> engine_{};  ///< each network's own if not set
};

extern template class StagedNetwork<float>;
extern template class StagedNetwork<double>;
}  // namespace tapestry::nn
