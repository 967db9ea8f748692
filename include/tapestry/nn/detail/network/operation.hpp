#pragma once
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/network/tensor.hpp>

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
  bool keeps;  ///< whether adjoint() will be called
  Engine engine;
  std::size_t batch = 1;  ///< copies of all operands and results that are not constant, one behind the other
  const MapWindow* window = nullptr;  ///< of the results: the rest need not be written; null: all
};

/// Factors of a result's adjoint: a curve's slopes, or `slope` where a bit of `gate` is not set; or null.
template <std::floating_point T>
struct AdjointScale {
  const T* factor = nullptr;
  const std::uint8_t* gate = nullptr;
  T slope = 1;

  [[nodiscard]] bool is_there() const { return factor != nullptr || gate != nullptr; }
};

/// Arguments of Operation::adjoint(). Operands and results have values only where adjoint_reads() lists them,
/// and in training where weight_adjoint_reads() does; all others are null.
template <std::floating_point T>
struct AdjointCall {
  std::span<const TensorView<const T>> inputs;
  std::span<const TensorView<const T>> outputs;
  std::span<const TensorView<T>> output_adjoints;  ///< null stands for zeros; at least one has values.
                                                   ///< They may be overwritten
  std::span<const TensorView<T>> input_adjoints;   ///< null where not wanted
  std::span<bool> is_uninitialised;  ///< whether an input_adjoint is uninitialised: write it, do not add
  OperationState<T>& state;
  Engine engine;
  std::size_t batch = 1;                    ///< as in ForwardCall
  const MapWindow* window = nullptr;        ///< window of the results with defined adjoints; null: all
  const MapWindow* input_window = nullptr;  ///< of operand 0: the rest need not be written; null: all
  bool is_scaled = false;                   ///< whether output_adjoints have taken adjoint_scale()
  AdjointScale<T> input_scale{};            ///< applied to the whole adjoint of operand 0 as it is written

  [[nodiscard]] bool wants(std::size_t input) const {
    return input < input_adjoints.size() && input_adjoints[input].is_there();
  }
  /// The adjoint of an input to add to: zeros if it was fresh.
  [[nodiscard]] T* accumulate(std::size_t input) const {
    T* const values = input_adjoints[input].values;
    if (is_uninitialised[input]) std::fill_n(values, batch * input_adjoints[input].size(), T(0));
    is_uninitialised[input] = false;
    return values;
  }
};

/// Operands and results whose values an adjoint reads: bit i for the i-th.
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

  /// Takes over constant operands, for example as packed weights; called again when they have changed.
  /// Operands that are not constant have no values here.
  virtual void prepare(std::span<const TensorView<const T>> /*constants*/) {}

  virtual void forward(const ForwardCall<T>& call) const = 0;

  /// Adds (∂outputs/∂inputs)ᵀ · output_adjoints to the input adjoints that are wanted (at least one is), or
  /// writes those that are fresh. Operations without a derivative do not override it.
  virtual void adjoint(const AdjointCall<T>& /*call*/) const {}
  [[nodiscard]] virtual AdjointReads adjoint_reads() const { return {}; }
  /// Values that the adjoint also reads if adjoints of constants are wanted.
  [[nodiscard]] virtual AdjointReads weight_adjoint_reads() const { return {}; }
  /// Whether result 0 has a derivative with respect to this operand.
  [[nodiscard]] virtual bool is_differentiable(std::size_t /*input*/) const { return true; }
  /// The scale of result 0's adjoint, if another operation may apply it: the one that adds to it last.
  [[nodiscard]] virtual AdjointScale<T> adjoint_scale(const OperationState<T>& /*state*/) const { return {}; }
  /// Whether adjoint() applies such a scale to the adjoint of operand 0.
  [[nodiscard]] virtual bool scales_adjoint(const AdjointScale<T>& /*scale*/) const { return false; }
  /// Whether a constant operand is a weight that training changes.
  [[nodiscard]] virtual bool is_weight(std::size_t /*input*/) const { return false; }
  /// Whether one call may take several copies of the operands; if not, there is one call a copy.
  [[nodiscard]] virtual bool takes_batches() const { return false; }
  /// Whether result 0 may take the memory of operand 0, which has the same size.
  [[nodiscard]] virtual bool works_in_place() const { return false; }

  /// The window of every result, a map, whose bits depend on windows of the operands. With the adjoint: also
  /// the window of the results' adjoints that the operands' adjoints read within their windows. None: all.
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
  /// The window of an operand that is read to compute a window of the results. Only called where
  /// window_reached() returns a window.
  [[nodiscard]] virtual MapWindow window_read(Engine /*engine*/, std::size_t /*operand*/,
                                              const MapWindow& computed) const {
    return computed;
  }
  /// Multiply-adds of a convolution; 0 of others.
  [[nodiscard]] virtual double product_count() const { return 0; }

  /// to[i] = the element of `from`, of operand 0's extents, that forward() has chosen for result i; of
  /// operations that choose elements of their operand.
  virtual void apply_choice(const OperationState<T>& /*state*/, const T* /*from*/, T* /*to*/) const {}

  /// States that every pixel of the results depends on the same pixel of the operands alone.
  void set_pixelwise() { is_pixelwise_ = true; }

 private:
  std::vector<Result> results_;
  bool is_pixelwise_ = false;
};
}  // namespace tapestry::nn
