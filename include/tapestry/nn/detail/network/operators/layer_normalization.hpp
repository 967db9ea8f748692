#pragma once
#include <tapestry/nn/detail/network/operators/channel_extents.hpp>

namespace tapestry::nn {
/// LayerNormalization of [rows, size]: scale · (x − mean)/√(variance + ε) + bias, with the mean and the
/// biased variance of each row, summed in double.
template <std::floating_point T>
class LayerNormalization : public Operation<T> {
 public:
  /// \param scale, bias  place of the value for each element of a row
  LayerNormalization(const Shape& shape, std::vector<std::size_t> scale, std::vector<std::size_t> bias,
                     double epsilon)
      : Operation<T>({{shape, ElementType::floating}}),
        size_(scale.size()),
        rows_(size_of(shape) / size_),
        scale_(std::move(scale)),
        bias_(std::move(bias)),
        epsilon_(epsilon) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    parallel_for(rows_, [&](std::size_t row) {
      const Row normal(*this, in + row * size_);
      for (std::size_t i = 0; i < size_; ++i)
        out[row * size_ + i] =
            static_cast<T>(normal(i) * scale(call.inputs, i) +
                           (bias_.empty() ? 0 : static_cast<double>(call.inputs[2].values[bias_[i]])));
    });
  }

  /// The adjoint, computed as in GroupNormalization.
  void adjoint(const AdjointCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    const T* const adjoint = call.output_adjoints[0].values;
    const auto at = [&](std::size_t row, std::size_t i) {
      return static_cast<double>(adjoint[row * size_ + i]);
    };
    if (call.wants(0)) {
      T* const to = call.accumulate(0);
      parallel_for(rows_, [&](std::size_t row) {
        const Row normal(*this, in + row * size_);
        double sum = 0, product = 0;
        for (std::size_t i = 0; i < size_; ++i) {
          const double g = at(row, i) * scale(call.inputs, i);
          sum += g;
          product += g * normal(i);
        }
        for (std::size_t i = 0; i < size_; ++i)
          to[row * size_ + i] +=
              static_cast<T>(normal.inverse * (at(row, i) * scale(call.inputs, i) -
                                               (sum + normal(i) * product) / static_cast<double>(size_)));
      });
    }
    if (!call.wants(1) && !call.wants(2)) return;
    std::vector<double> sums(size_, 0), products(size_, 0);
    for (std::size_t row = 0; row < rows_; ++row) {
      const Row normal(*this, in + row * size_);
      for (std::size_t i = 0; i < size_; ++i) {
        sums[i] += at(row, i);
        products[i] += at(row, i) * normal(i);
      }
    }
    hand_on(call, 1, scale_, products);
    hand_on(call, 2, bias_, sums);
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {0b11, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return input == 1 || input == 2; }

 private:
  /// The normalised values of a row.
  struct Row {
    const T* x;
    double mean = 0, inverse = 0;

    Row(const LayerNormalization& owner, const T* values) : x(values) {
      const auto count = static_cast<double>(owner.size_);
      for (std::size_t i = 0; i < owner.size_; ++i) mean += static_cast<double>(x[i]);
      mean /= count;
      double squares = 0;
      for (std::size_t i = 0; i < owner.size_; ++i) {
        const double off = static_cast<double>(x[i]) - mean;
        squares += off * off;
      }
      inverse = 1 / std::sqrt(squares / count + owner.epsilon_);
    }
    double operator()(std::size_t i) const { return (static_cast<double>(x[i]) - mean) * inverse; }
  };

  [[nodiscard]] double scale(std::span<const TensorView<const T>> inputs, std::size_t i) const {
    return static_cast<double>(inputs[1].values[scale_[i]]);
  }

  static void hand_on(const AdjointCall<T>& call, std::size_t input, const std::vector<std::size_t>& places,
                      const std::vector<double>& values) {
    if (!call.wants(input)) return;
    T* const to = call.accumulate(input);
    for (std::size_t i = 0; i < values.size(); ++i) to[places[i]] += static_cast<T>(values[i]);
  }

  std::size_t size_, rows_;
  std::vector<std::size_t> scale_, bias_;  ///< no bias if it is empty
  double epsilon_;
};

namespace detail {
/// Place in an operand, repeated over `shape`, of each element's value.
/// \throws ShapeError if it cannot be repeated so
[[nodiscard]] inline std::vector<std::size_t> repeated_places(const Shape& shape, const Shape& operand) {
  Shape own = operand;
  const auto refuse = [&] {
    throw ShapeError({"a weight is ", operand, ", which does not fit rows of ", shape});
  };
  if (own.size() > shape.size()) refuse();
  if (size_of(shape) > (std::size_t(1) << 24U)) throw ShapeError({"rows of ", shape, " are too large"});
  own.insert(own.begin(), shape.size() - own.size(), 1);
  std::vector<std::size_t> places{0};
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (own[axis] != 1 && own[axis] != shape[axis]) refuse();
    std::vector<std::size_t> next;
    next.reserve(places.size() * shape[axis]);
    for (const std::size_t place : places)
      for (std::size_t i = 0; i < shape[axis]; ++i)
        next.push_back(place * own[axis] + (own[axis] == 1 ? 0 : i));
    places = std::move(next);
  }
  return places;
}
}  // namespace detail

/// LayerNormalization without the results Mean and InvStdDev.
template <std::floating_point T>
void add_layer_normalization(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    context.ignore("stash_type");  // sums are in double
    const Shape& shape = context.input(0).shape;
    const std::size_t axis = context.axis(context.integer("axis", -1), shape.size());
    if (size_of(shape) == 0 || shape.empty()) throw ShapeError("input 0 is empty");
    const Shape row(shape.begin() + static_cast<std::ptrdiff_t>(axis), shape.end());
    std::vector<std::size_t> bias;
    if (context.has_input(2)) bias = detail::repeated_places(row, context.input(2).shape);
    return std::make_unique<LayerNormalization<T>>(shape,
                                                   detail::repeated_places(row, context.input(1).shape),
                                                   std::move(bias), context.number("epsilon", 1e-5));
  };
  table["LayerNormalization"] = {LayoutRule::plain, 1, false, {{2, 3}}, make};
}

/// LRN: y = x · d^−β with d = bias + α/size · Σ x² over `size` neighbouring channels.
template <std::floating_point T>
class LocalResponseNormalization : public Operation<T> {
 public:
  /// Its settings, as ONNX names them.
  struct Numbers {
    std::size_t size = 1;
    double alpha = 1e-4, beta = 0.75, bias = 1;
  };

  LocalResponseNormalization(const Shape& shape, const ChannelExtents& extents, const Numbers& numbers)
      : Operation<T>({{shape, ElementType::floating}}), extents_(extents), numbers_(numbers) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    for_each_pixel([&](std::size_t image, std::size_t pixel, std::vector<double>& x, std::vector<double>& d) {
      read(in, image, pixel, x, d);
      for (std::size_t c = 0; c < extents_.channels; ++c)
        out[extents_.at(image, c, pixel)] = static_cast<T>(x[c] * std::pow(d[c], -numbers_.beta));
    });
  }

  /// ∂L/∂x_i = g_i·d_i^−β − 2αβ/size · x_i · Σ g_j·x_j·d_j^(−β−1), over the j that have i as a neighbour.
  void adjoint(const AdjointCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    const T* const adjoint = call.output_adjoints[0].values;
    T* const to = call.accumulate(0);
    for_each_pixel([&](std::size_t image, std::size_t pixel, std::vector<double>& x, std::vector<double>& d) {
      read(in, image, pixel, x, d);
      const double factor = 2 * numbers_.alpha * numbers_.beta / static_cast<double>(numbers_.size);
      for (std::size_t j = 0; j < extents_.channels; ++j) {
        const auto g = static_cast<double>(adjoint[extents_.at(image, j, pixel)]);
        const double power = std::pow(d[j], -numbers_.beta);
        to[extents_.at(image, j, pixel)] += static_cast<T>(g * power);
        for (std::size_t i = first(j); i < end(j); ++i)
          to[extents_.at(image, i, pixel)] -= static_cast<T>(factor * x[i] * g * x[j] * power / d[j]);
      }
    });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {1, 0}; }

 private:
  /// Neighbours of channel c. If `size` is even, one more lies behind c than before it.
  [[nodiscard]] std::size_t first(std::size_t c) const {
    const std::size_t before = (numbers_.size - 1) / 2;
    return c > before ? c - before : 0;
  }
  [[nodiscard]] std::size_t end(std::size_t c) const {
    return std::min(extents_.channels, c + numbers_.size / 2 + 1);
  }

  template <class Body>
  void for_each_pixel(Body body) const {
    parallel_for(extents_.images * extents_.pixels, [&](std::size_t task) {
      static thread_local std::vector<double> x, d;
      body(task / extents_.pixels, task % extents_.pixels, x, d);
    });
  }

  void read(const T* in, std::size_t image, std::size_t pixel, std::vector<double>& x,
            std::vector<double>& d) const {
    x.resize(extents_.channels);
    d.resize(extents_.channels);
    for (std::size_t c = 0; c < extents_.channels; ++c)
      x[c] = static_cast<double>(in[extents_.at(image, c, pixel)]);
    for (std::size_t c = 0; c < extents_.channels; ++c) {
      double squares = 0;
      for (std::size_t i = first(c); i < end(c); ++i) squares += x[i] * x[i];
      d[c] = numbers_.bias + numbers_.alpha / static_cast<double>(numbers_.size) * squares;
    }
  }

  ChannelExtents extents_;
  Numbers numbers_;
};

template <std::floating_point T>
void add_local_response_normalization(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    typename LocalResponseNormalization<T>::Numbers numbers;
    if (!context.has_attribute("size")) throw DomainError("attribute 'size' is missing");
    numbers.size = static_cast<std::size_t>(context.integer("size", 1));
    numbers.alpha = context.number("alpha", numbers.alpha);
    numbers.beta = context.number("beta", numbers.beta);
    numbers.bias = context.number("bias", numbers.bias);
    return std::make_unique<LocalResponseNormalization<T>>(context.input(0).shape, channel_extents(context),
                                                           numbers);
  };
  table["LRN"] = {LayoutRule::channels_last, 1, false, {{1, 1}}, make, {{"size", 1, std::int64_t(1) << 20U}}};
}
}  // namespace tapestry::nn
