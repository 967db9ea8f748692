#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <tapestry/nn/workspace.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

/// State of one operation in one pass, kept from forward to adjoint beside its operands and results.
template <std::floating_point T>
struct OperationState {
  Buffer<T> values{};
  Buffer<std::uint8_t> bits{};
  Buffer<ElementIndex<T>> choices{};
  std::vector<double> statistics{};
};

/// One call of Operation::forward().
template <std::floating_point T>
struct ForwardCall {
  std::span<const TensorView<const T>> inputs;
  std::span<const TensorView<T>> outputs;  ///< not initialised
  OperationState<T>& state;
  bool keeps;  ///< whether the adjoint will be called
  Engine engine;
  std::size_t batch = 1;  ///< copies, one behind the other, of all operands and results that are not constant
  const MapWindow* window = nullptr;  ///< of the results: nothing else need be written; null: all
};

/// Values of operands and results are there only where Operation::adjoint_reads() lists them, in training
/// also where weight_adjoint_reads() does; all others are null.
template <std::floating_point T>
struct AdjointCall {
  std::span<const TensorView<const T>> inputs;
  std::span<const TensorView<const T>> outputs;
  std::span<const TensorView<T>> output_adjoints;  ///< null stands for zeros; at least one is there. Nobody
                                                   ///< reads them afterwards, so they may be overwritten
  std::span<const TensorView<T>> input_adjoints;   ///< null where not wanted
  std::span<bool> is_fresh;  ///< of input_adjoints: not initialised yet, so to be written, not added to
  OperationState<T>& state;
  Engine engine;
  std::size_t batch = 1;              ///< as in ForwardCall
  const MapWindow* window = nullptr;  ///< of the results, whose adjoints are defined there only; null: all
  const MapWindow* input_window = nullptr;  ///< of operand 0: nothing else need be written; null: all

  [[nodiscard]] bool wants(std::size_t input) const {
    return input < input_adjoints.size() && input_adjoints[input].is_there();
  }
  /// The adjoint of an input to add to: zeros if it was fresh.
  [[nodiscard]] T* accumulate(std::size_t input) const {
    T* const values = input_adjoints[input].values;
    if (is_fresh[input]) std::fill_n(values, batch * input_adjoints[input].size(), T(0));
    is_fresh[input] = false;
    return values;
  }
};

/// Which operands and results an adjoint reads the values of: bit i for the i-th.
struct AdjointReads {
  std::uint64_t inputs = 0;
  std::uint64_t outputs = 0;
};

/// One operator of a network at fixed extents, made by operators().
template <std::floating_point T>
class Operation {
 public:
  /// Shape and type of a result, known before it is computed.
  struct Result {
    Shape shape{};
    ElementType type = ElementType::floating;
  };

  /// \throws ShapeError as require_room()
  explicit Operation(std::vector<Result> results) : results_(std::move(results)) {
    for (const Result& result : results_) require_room(result.shape);
  }
  Operation(const Operation&) = delete;
  Operation& operator=(const Operation&) = delete;
  virtual ~Operation() = default;

  [[nodiscard]] const std::vector<Result>& results() const { return results_; }
  [[nodiscard]] const Shape& result_shape(std::size_t i = 0) const { return results_[i].shape; }

  /// Takes over constant operands, as packed weights; called again when they have changed. Operands that are
  /// not constant have no values here.
  virtual void prepare(std::span<const TensorView<const T>> /*constants*/) {}

  virtual void forward(const ForwardCall<T>& call) const = 0;

  /// Adds (∂outputs/∂inputs)ᵀ · output_adjoints to the input adjoints that are wanted, of which there is one
  /// at least, or writes those that are fresh. Operations whose results do not depend smoothly on anything
  /// leave it out.
  virtual void adjoint(const AdjointCall<T>& /*call*/) const {}
  [[nodiscard]] virtual AdjointReads adjoint_reads() const { return {}; }
  /// Values that the adjoint also reads where adjoints of constants are wanted.
  [[nodiscard]] virtual AdjointReads weight_adjoint_reads() const { return {}; }
  /// Whether result 0 depends on this operand with a derivative.
  [[nodiscard]] virtual bool is_differentiable(std::size_t /*input*/) const { return true; }
  /// Whether a constant operand is a weight that training changes.
  [[nodiscard]] virtual bool is_weight(std::size_t /*input*/) const { return false; }
  /// Whether it takes calls of several copies of its operands at once; others are called for each copy.
  [[nodiscard]] virtual bool takes_batches() const { return false; }
  /// Whether result 0 may lie where operand 0 does, of the same size.
  [[nodiscard]] virtual bool works_in_place() const { return false; }

  /// The window of every result, a map, whose bits depend on windows of the operands; with the adjoint, also
  /// where the results' adjoints are read to compute those of the operands within their windows. None: all.
  ///
  /// \param changed  of each operand; empty where it is constant
  [[nodiscard]] virtual std::optional<MapWindow> window_reached(Engine /*engine*/,
                                                                std::span<const MapWindow> changed,
                                                                bool /*with_adjoint*/) const {
    if (!is_pixelwise_) return std::nullopt;
    MapWindow reached{};
    for (const MapWindow& window : changed) reached = hull(reached, window);
    return reached;
  }
  /// The window of an operand that is read to compute a window of the results. Only where window_reached()
  /// is one.
  [[nodiscard]] virtual MapWindow window_read(Engine /*engine*/, std::size_t /*operand*/,
                                              const MapWindow& computed) const {
    return computed;
  }
  /// Multiply-adds of a convolution; 0 of others.
  [[nodiscard]] virtual double product_count() const { return 0; }

  /// States that every pixel of the results depends on the same pixel of the operands alone.
  void set_pixelwise() { is_pixelwise_ = true; }

 private:
  std::vector<Result> results_;
  bool is_pixelwise_ = false;
};

}  // namespace tapestry::nn
