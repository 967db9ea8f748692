#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tapestry/autodiff/arrays/elementwise.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <type_traits>
#include <utility>

namespace tapestry {

/// How the window of a convolution moves along both axes.
struct ConvolutionWindow {
  std::size_t stride = 1;
  std::size_t padding = 0;  ///< rows and columns of zeros on each side
};

namespace detail {

/// Outputs along an axis. \throws ShapeError if the window does not fit
[[nodiscard]] inline std::size_t convolved_extent(std::size_t extent, std::size_t taps,
                                                  const ConvolutionWindow& window) {
  if (window.stride == 0) throw ShapeError("convolve: stride 0");
  if (taps == 0 || extent + 2 * window.padding < taps)
    throw ShapeError("convolve: " + std::to_string(taps) + " taps for " +
                     std::to_string(extent + 2 * window.padding) + " elements with their padding");
  return (extent + 2 * window.padding - taps) / window.stride + 1;
}

/// Outputs first … last − 1 of an axis at which a tap meets an element rather than padding.
struct TapRange {
  std::size_t first;
  std::size_t last;
};
[[nodiscard]] inline TapRange outputs_of_tap(std::size_t tap, std::size_t extent, std::size_t outputs,
                                             const ConvolutionWindow& window) {
  const std::size_t first =
      tap >= window.padding ? 0 : (window.padding - tap + window.stride - 1) / window.stride;
  const std::size_t beyond = extent + window.padding;  // tap + output · stride stays below
  const std::size_t last = beyond <= tap ? 0 : (beyond - tap - 1) / window.stride + 1;
  return {std::min(first, outputs), std::max(std::min(first, outputs), std::min(last, outputs))};
}

/// Calls visit(weight's place, first input's place, first output's place, count) for runs of outputs of one
/// row that one weight takes from inputs `stride` apart.
template <class Visit>
void for_each_run(const Extents<3>& x, const Extents<4>& weights, const Extents<3>& y,
                  const ConvolutionWindow& window, Visit visit) {
  std::size_t weight = 0;
  for (std::size_t o = 0; o < weights[0]; ++o)
    for (std::size_t c = 0; c < weights[1]; ++c)
      for (std::size_t r = 0; r < weights[2]; ++r)
        for (std::size_t s = 0; s < weights[3]; ++s, ++weight) {
          const TapRange rows = outputs_of_tap(r, x[1], y[1], window);
          const TapRange columns = outputs_of_tap(s, x[2], y[2], window);
          if (columns.first == columns.last) continue;
          for (std::size_t row = rows.first; row < rows.last; ++row)
            visit(weight,
                  (c * x[1] + row * window.stride + r - window.padding) * x[2] +
                      columns.first * window.stride + s - window.padding,
                  (o * y[1] + row) * y[2] + columns.first, columns.last - columns.first);
        }
}

template <class T>
[[nodiscard]] ArrayVariable<T, 3> convolve_of(const ArrayVariable<T, 3>& x,
                                              const ArrayVariable<T, 4>& weights,
                                              const ConvolutionWindow& window) {
  require_shape("convolve", "weights", weights.value(),
                {weights.shape()[0], x.shape()[0], weights.shape()[2], weights.shape()[3]});
  const Extents<3> extents{weights.shape()[0], convolved_extent(x.shape()[1], weights.shape()[2], window),
                           convolved_extent(x.shape()[2], weights.shape()[3], window)};
  Array<T, 3> value = zeros<T, 3>(extents);
  const std::size_t step = window.stride;
  for_each_run(x.shape(), weights.shape(), extents, window,
               [&](std::size_t weight, std::size_t in, std::size_t out, std::size_t count) {
                 const T w = weights.value().data()[weight];
                 const T* const from = x.value().data() + in;
                 T* const to = value.data() + out;
                 for (std::size_t i = 0; i < count; ++i) to[i] += w * from[i * step];
               });
  const auto pullback = [kept_x = x.shared_value(), kept_weights = weights.shared_value(), window](
                            const Array<T, 3>& value_adjoint, Array<T, 3>* x_adjoint,
                            Array<T, 4>* weights_adjoint) {
    const std::size_t stride = window.stride;
    for_each_run(kept_x->shape(), kept_weights->shape(), value_adjoint.shape(), window,
                 [&](std::size_t weight, std::size_t in, std::size_t out, std::size_t count) {
                   const T* const g = value_adjoint.data() + out;
                   if (x_adjoint != nullptr) {
                     const T w = kept_weights->data()[weight];
                     for (std::size_t i = 0; i < count; ++i) x_adjoint->data()[in + i * stride] += w * g[i];
                   }
                   if (weights_adjoint == nullptr) return;
                   T sum = 0;
                   for (std::size_t i = 0; i < count; ++i) sum += kept_x->data()[in + i * stride] * g[i];
                   weights_adjoint->data()[weight] += sum;
                 });
  };
  return record_array(std::move(value), pullback, x, weights);
}
}  // namespace detail

/// Cross-correlation, what networks call a convolution, of one picture with zeros around it:
///
///   y[o, i, j] = Σ over c, r, s of weights[o, c, r, s] · x[c, i·stride + r − p, j·stride + s − p]
///
/// with p zeros at each side. At least one of the two is an array variable or a formula. Meant for small
/// pictures, in one thread; nn/ has the convolutions of detectors.
///
/// \param x        [C, H, W]
/// \param weights  [O, C, R, S]
/// \returns        [O, (H + 2·p − R) / stride + 1, (W + 2·p − S) / stride + 1]
/// \throws ShapeError if channels differ, the window is larger than the padded picture, or stride is 0
template <class X, class W>
requires(DifferentiableArray<X> || DifferentiableArray<W>)
    [[nodiscard]] auto convolve(const X& x, const W& weights, const ConvolutionWindow& window = {}) {
  using T = detail::ArrayScalarType<std::conditional_t<DifferentiableArray<X>, X, W>>;
  return detail::convolve_of<T>(ArrayVariable<T, 3>(x), ArrayVariable<T, 4>(weights), window);
}

}  // namespace tapestry
