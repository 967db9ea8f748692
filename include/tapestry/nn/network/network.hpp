#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network_pass.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/simplify.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

/// A network at fixed extents: forward, and backward to its inputs and its weights. Results are the same bits
/// for any number of threads.
template <std::floating_point T>
class Network {
 public:
  /// \param shapes  extents of inputs, for those that the description leaves open or that are to be others; a
  ///                batch (axis 0) that is left open is 1
  /// \param pictures_channels_last  inputs of four axes are handed over as [N, H, W, C]
  /// \param simplifies  what runs is simplified() first; results differ in rounding
  /// \throws FileError (mismatch) naming every operator or attribute that is not supported, or an input whose
  ///         extents are open
  explicit Network(const NetworkDescription& description, const std::map<std::string, Shape>& shapes = {},
                   bool pictures_channels_last = false, bool simplifies = true)
      : program_(build(description, input_shapes(description, shapes), pictures_channels_last, simplifies)),
        use_(use_of(program_)),
        input_count_(program_.inputs.size()) {
    prepare();
  }

  [[nodiscard]] std::size_t input_count() const { return program_.inputs.size(); }
  [[nodiscard]] std::size_t output_count() const { return program_.outputs.size(); }
  [[nodiscard]] const Shape& input_shape(std::size_t i) const {
    return program_.values[program_.inputs.at(i)].shape;
  }
  [[nodiscard]] const Shape& output_shape(std::size_t i) const {
    return program_.values[program_.outputs.at(i)].shape;
  }
  [[nodiscard]] const std::string& output_name(std::size_t i) const {
    return program_.values[program_.outputs.at(i)].name;
  }

  void set_engine(Engine engine) { engine_ = engine; }

  /// Where each weight lies among constants(). Only these get an adjoint, from all that reads them. A
  /// constant of the description is several here, each with an adjoint of its own, if it is read in both
  /// layouts or if others are computed from it beforehand.
  [[nodiscard]] const std::vector<WeightBlock>& weights() const { return program_.weights; }
  /// All constants, weights among them.
  [[nodiscard]] const std::vector<T>& constants() const { return program_.constants; }
  /// Passes of before keep their results; for an adjoint forward() runs again.
  ///
  /// \throws ShapeError unless there are as many as constants()
  void set_constants(const std::vector<T>& constants) {
    if (constants.size() != program_.constants.size())
      throw ShapeError("Network: constants is [" + std::to_string(constants.size()) + "], expected [" +
                       std::to_string(program_.constants.size()) + "]");
    std::ranges::copy(constants, program_.constants.begin());  // in place: passes point to them
    prepare();
  }

  /// \param inputs  values of each input, of input_shape(), readable 128 bytes past their end
  /// \param pass    takes the results, and what `mode` says is kept
  void forward(const std::vector<const T*>& inputs, NetworkPass<T>& pass, Mode mode = Mode::inference) const {
    pass.forward(program_, use_, inputs, mode, engine_);
  }

  /// Adds the pullback of output_adjoints to inputs_adjoint and to constants_adjoint.
  ///
  /// \param pass               of forward() in another mode than inference; may be used again
  /// \param output_adjoints    one an output, of output_shape(); null stands for zeros
  /// \param inputs_adjoint     one an input; null where not wanted
  /// \param constants_adjoint  of as many values as constants(), or null; only weights() are added to
  /// \param outputs_gathered   one an output, null where not wanted, or none: all that reaches it, from its
  /// own
  ///                           adjoint and from what reads it, is added there. An output that stands within
  ///                           the network tells so what the others ask of a layer; needs an input's adjoint
  /// \throws DomainError if the pass kept nothing, or for constants unless it was for training
  void adjoint(NetworkPass<T>& pass, const std::vector<const T*>& output_adjoints,
               const std::vector<T*>& inputs_adjoint, T* constants_adjoint = nullptr,
               const std::vector<T*>& outputs_gathered = {}) const {
    pass.adjoint(program_, use_, output_adjoints, inputs_adjoint, constants_adjoint, outputs_gathered,
                 engine_);
  }

 private:
  [[nodiscard]] static Program<T> build(const NetworkDescription& description,
                                        const std::map<std::string, Shape>& shapes,
                                        bool pictures_channels_last, bool simplifies) {
    ProgramBuilder<T> builder(description, shapes, pictures_channels_last);
    Program<T> program = builder.build();
    if (!simplifies) return program;
    const NetworkDescription simple = simplified(description, builder.facts());
    return ProgramBuilder<T>(simple, shapes, pictures_channels_last).build();
  }

  [[nodiscard]] static std::map<std::string, Shape> input_shapes(const NetworkDescription& description,
                                                                 const std::map<std::string, Shape>& wanted) {
    std::map<std::string, Shape> shapes;
    for (const InputDescription& input : description.inputs) {
      if (const auto found = wanted.find(input.name); found != wanted.end()) {
        shapes.insert(*found);
        continue;
      }
      Shape shape;
      for (std::size_t axis = 0; axis < input.shape.size(); ++axis) {
        if (!input.shape[axis] && axis > 0)
          throw FileError(ErrorKind::mismatch,
                          {description.path, "",
                           "input " + in_quotes(input.name) + " has an open extent at axis " +
                               std::to_string(axis) + "; state the input's size"});
        shape.push_back(input.shape[axis].value_or(1));
      }
      shapes.emplace(input.name, std::move(shape));
    }
    return shapes;
  }

  /// Hands the constants to the operations that pack them.
  void prepare() {
    for (ProgramStep<T>& step : program_.steps) {
      std::vector<TensorView<const T>> operands(step.inputs.size());
      for (std::size_t i = 0; i < operands.size(); ++i) {
        if (step.inputs[i] == no_value) continue;
        const ProgramValue& value = program_.values[step.inputs[i]];
        operands[i] = {&value.shape,
                       value.is_constant() ? program_.constants.data() + value.constant : nullptr};
      }
      step.operation->prepare(operands);
    }
  }

  Program<T> program_;
  ProgramUse use_;
  std::size_t input_count_;
  Engine engine_ = Engine::automatic;
};

}  // namespace tapestry::nn
