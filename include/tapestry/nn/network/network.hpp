#pragma once
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>
#include <tapestry/nn/network/network_pass.hpp>

/// \file
/// The first header of nn/network/: networks of ONNX's operators, forward and backward.
///
///   forward   v_k = f_k(v_i, …)                 for each node, in order
///   adjoint   v̄_i += (∂f_k/∂v_i)ᵀ · v̄_k         for each node, in reverse order
///
///   NetworkDescription --> simplified() --> Program -----------> NetworkPass
///   nodes by name          fewer nodes      at fixed extents     values and adjoints of one run
///
/// Each node becomes an Operation with forward() and adjoint(); its kernels are in nn/.
///
/// Read next: description.hpp, operation.hpp, a small operator such as operators/pass_on.hpp, program.hpp,
/// network_pass.hpp.

namespace tapestry::nn {
/// A network at fixed extents: forward, and backward to its inputs and its weights. Results are the same bits
/// for any number of threads.
template <std::floating_point T>
class Network {
 public:
  /// \param shapes  extents of inputs, if the description leaves them open or they should differ; an open
  ///                batch (axis 0) is 1
  /// \param pictures_channels_last  inputs of four axes are handed over as [N, H, W, C]
  /// \param simplifies  runs the simplified() network; results differ in rounding
  /// \throws FileError (mismatch) naming every operator or attribute that is not supported, or an input whose
  ///         extents are open
  explicit Network(NetworkDescription description, const std::map<std::string, Shape>& shapes = {},
                   bool pictures_channels_last = false, bool simplifies = true)
      : Network(build(std::move(description), input_shapes(description, shapes), pictures_channels_last,
                      simplifies)) {}

  /// A network of the same weights that also computes its derivative along a direction ẋ:
  ///
  ///   inputs (x …, ẋ …), outputs (y …, ẏ …)    y = f(x)    ẏ = J(x)·ẋ
  ///
  /// Its adjoint of seeds (a on y, b on ẏ) is x̄ = Jᵀa + D(Jᵀb)[ẋ], second order, and Jᵀb for ẋ. Every input
  /// of floating-point numbers has a ẋ, and every output a ẏ, which is 0 where nothing depends on x.
  ///
  /// \param of_weights  each weight has a direction, too: the weight of its name with "#0" behind it, zeros
  ///                    at first. Operators other than products leave it out of weights()
  /// \throws DomainError naming an operator whose second order is not known
  [[nodiscard]] Network with_tangents(bool of_weights = false) const;

  /// Extents of all inputs; parameters and errors as in the constructor.
  [[nodiscard]] static std::map<std::string, Shape> input_shapes(const NetworkDescription& description,
                                                                 const std::map<std::string, Shape>& wanted);

  [[nodiscard]] std::size_t input_count() const { return program_.inputs.size(); }
  [[nodiscard]] std::size_t output_count() const { return program_.outputs.size(); }
  [[nodiscard]] const Shape& input_shape(std::size_t i) const {
    return program_.values[program_.inputs.at(i)].shape;
  }
  [[nodiscard]] const Shape& output_shape(std::size_t i) const {
    return program_.values[program_.outputs.at(i)].shape;
  }

  void set_engine(Engine engine) { engine_ = engine; }

  /// The step that makes a value, for NetworkPass::state(). \throws DomainError if none does
  [[nodiscard]] std::size_t step_of(const std::string& value) const;

  /// Position of each weight in weights(). A constant of the description counts several times here, each with
  /// its own adjoint, if it is read in both layouts or if other constants are computed from it beforehand. A
  /// simplified network gives them new names; otherwise a constant that is only moved keeps its name.
  [[nodiscard]] const std::vector<WeightBlock>& weight_blocks() const { return program_.weights; }
  /// Place of a block's elements in the constant that it is named after.
  /// \throws DomainError for a moved constant of more than 2^24 elements
  [[nodiscard]] static std::vector<std::size_t> places_of(const WeightBlock& block);
  /// Values of the constants that training changes, one after another.
  [[nodiscard]] std::span<const T> weights() const {
    return {program_.constants.data(), program_.weight_count};
  }
  /// Earlier passes keep their results; before an adjoint, forward() must run again.
  ///
  /// \throws ShapeError unless there are as many as weights()
  void set_weights(std::span<const T> weights);

  /// \param inputs  values of each input, of input_shape(), readable 128 bytes past their end
  /// \param pass    receives the results, and what `mode` keeps
  /// \param batch   number of copies of the inputs' extents, one behind the other, at least 1. Each has its
  ///                own results: the same bits as alone
  void forward(const std::vector<const T*>& inputs, NetworkPass<T>& pass, Mode mode = Mode::inference,
               std::size_t batch = 1) const {
    pass.forward(program_, use_, inputs, mode, engine_, batch);
  }

  /// forward() of a single input picture, [1, H, W, C], that changes from call to call only within a window.
  /// The results are the same bits. Values that the window does not reach are taken from `kept`. `kept` is
  /// filled when it does not apply: at first, and when the rest of the picture, the weights, the engine or
  /// the mode have changed. adjoint() then adds to the input's adjoint within the window only. In
  /// Mode::training everything is computed and nothing is kept.
  ///
  /// \param window  the picture is constant outside of it; may be empty
  /// \throws DomainError for a network of other inputs
  void forward_within(const T* picture, const MapWindow& window, KeptValues<T>& kept, NetworkPass<T>& pass,
                      Mode mode = Mode::inference) const;

  /// Share of the multiply-adds of a whole pass, from 0 to 1, that forward_within() leaves out.
  [[nodiscard]] double share_kept(const MapWindow& window, Mode mode = Mode::input_gradient) const;

  /// Adds the pullback of output_adjoints to inputs_adjoint and to weights_adjoint.
  ///
  /// \param pass               of forward() in another mode than inference; may be used again
  /// \param output_adjoints    one an output, of output_shape() for each of the pass's batch; null stands for
  ///                           zeros
  /// \param inputs_adjoint     one an input, likewise; null where not wanted
  /// \param weights_adjoint    of as many values as weights(), from all that reads them, or null
  /// \param outputs_gathered   one an output, null where not wanted, or none: receives the total gradient at
  ///                           an output within the network, from its own adjoint and from later layers.
  ///                           Requires an input's adjoint
  /// \throws DomainError if the pass kept nothing, or for weights unless it was for training
  void adjoint(NetworkPass<T>& pass, const std::vector<const T*>& output_adjoints,
               const std::vector<T*>& inputs_adjoint, T* weights_adjoint = nullptr,
               const std::vector<T*>& outputs_gathered = {}) const;

 private:
  explicit Network(Program<T> program)
      : program_(std::move(program)), use_(use_of(program_)), input_count_(program_.inputs.size()) {
    prepare();
  }

  [[nodiscard]] static Program<T> build(NetworkDescription&& description,
                                        const std::map<std::string, Shape>& shapes,
                                        bool pictures_channels_last, bool simplifies);

  /// Hands the constants to the operations that pack them.
  void prepare();

  [[nodiscard]] const Shape& picture_map(const char* operation) const;

  Program<T> program_;
  ProgramUse use_;
  std::size_t input_count_;
  Engine engine_ = Engine::automatic;
  std::shared_ptr<const void> version_{};  ///< changes with the weights
};

extern template class Network<float>;
extern template class Network<double>;
}  // namespace tapestry::nn
