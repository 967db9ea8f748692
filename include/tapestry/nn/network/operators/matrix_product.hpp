#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/convolution_weight_adjoint.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/packed_convolution.hpp>

namespace tapestry::nn {

/// Extents of c[rows, columns] = a[rows, depth] · b[depth, columns].
struct ProductShape {
  std::size_t rows = 1, depth = 1, columns = 1;

  /// The same as a convolution of pixels, each on its own.
  [[nodiscard]] ConvolutionShape convolution() const {
    ConvolutionShape shape;
    shape.rows.input = shape.rows.output = rows;
    shape.in_channels = depth;
    shape.out_channels = columns;
    return shape;
  }
};

/// b of a product, packed; b[k, n] is at b[k · row_step + n · column_step].
template <std::floating_point T>
[[nodiscard]] PackedConvolution<T> pack_matrix(const ProductShape& shape, const T* b, std::size_t row_step,
                                               std::size_t column_step) {
  return pack_convolution<T>(shape.convolution(), [&](std::size_t i) {
    return b[i % shape.depth * row_step + i / shape.depth * column_step];
  });
}

/// c (+)= a · b, row-major.
template <std::floating_point T>
void multiply(const T* a, const PackedConvolution<T>& b, bool adds, T* c) {
  Epilogue<T> end{};
  end.adds = adds;
  convolve(b, 1, a, end, c, b.shape.out_size());
}

/// b_adjoint += scale · aᵀ · c_adjoint, where b[k, n] is at b_adjoint[k · row_step + n · column_step].
/// \param a, c_adjoint  readable 128 bytes past their end
template <std::floating_point T>
void multiply_adjoint(const ProductShape& shape, const T* a, const T* c_adjoint, T scale,
                      std::size_t row_step, std::size_t column_step, T* b_adjoint) {
  static thread_local Buffer<T> partial, sum;
  sum.resize(shape.depth * shape.columns);
  sum.fill_zero();
  convolution_weight_adjoint(shape.convolution(), 1, a, c_adjoint, partial, sum.data());
  for (std::size_t n = 0; n < shape.columns; ++n)
    for (std::size_t k = 0; k < shape.depth; ++k)
      b_adjoint[k * row_step + n * column_step] += scale * sum.data()[n * shape.depth + k];
}

/// to[columns, rows] = from[rows, columns]ᵀ
template <class T>
void transpose_matrix(const T* from, std::size_t rows, std::size_t columns, T* to) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) to[j * rows + i] = from[i * columns + j];
}

}  // namespace tapestry::nn
