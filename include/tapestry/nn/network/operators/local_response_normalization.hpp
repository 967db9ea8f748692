#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/network/operators/channel_extents.hpp>
#include <vector>

namespace tapestry::nn {

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

  /// ∂L/∂x_i = g_i·d_i^−β − 2αβ/size · x_i · Σ g_j·x_j·d_j^(−β−1), over those j whose neighbour i is.
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
  /// Neighbours of channel c, of which an even size has one more behind it.
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
  table["LRN"] = {LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
                    typename LocalResponseNormalization<T>::Numbers numbers;
                    const std::int64_t size = context.integer("size", 0);
                    if (size < 1 || size > (std::int64_t(1) << 20U))
                      throw DomainError("attribute 'size' is " + std::to_string(size));
                    numbers.size = static_cast<std::size_t>(size);
                    numbers.alpha = context.number("alpha", numbers.alpha);
                    numbers.beta = context.number("beta", numbers.beta);
                    numbers.bias = context.number("bias", numbers.bias);
                    return std::make_unique<LocalResponseNormalization<T>>(context.input(0).shape,
                                                                           channel_extents(context), numbers);
                  }};
}

}  // namespace tapestry::nn
