#pragma once
#include <array>
#include <concepts>
#include <cstddef>

namespace tapestry::image {
/// A 3 × 3 matrix of rows: of colours, or of homogeneous coordinates.
template <std::floating_point T>
using Matrix3 = std::array<std::array<T, 3>, 3>;

inline constexpr Matrix3<double> identity3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< the identity

/// m · x
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] constexpr std::array<T, 3> product(const Matrix3<T>& m,
                                                                     const std::array<T, 3>& x) {
  const auto row = [&](std::size_t i) { return m[i][0] * x[0] + (m[i][1] * x[1] + m[i][2] * x[2]); };
  return {row(0), row(1), row(2)};
}

/// a · b
template <std::floating_point T>
[[nodiscard]] constexpr Matrix3<T> composed(const Matrix3<T>& a, const Matrix3<T>& b) {
  Matrix3<T> all{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) all[i][j] += a[i][k] * b[k][j];
  return all;
}
/// mᵀ
template <std::floating_point T>
[[nodiscard]] constexpr Matrix3<T> transposed(const Matrix3<T>& m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}

/// scale · m, in another scalar.
template <std::floating_point T>
[[nodiscard]] constexpr Matrix3<T> scaled(const Matrix3<double>& m, double scale = 1) {
  Matrix3<T> all{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) all[i][j] = static_cast<T>(scale * m[i][j]);
  return all;
}

/// m⁻¹, by cofactors; not finite where the determinant is 0.
[[nodiscard]] constexpr Matrix3<double> inverse(const Matrix3<double>& m) {
  Matrix3<double> all{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t down = (j + 1) % 3, lower = (j + 2) % 3, right = (i + 1) % 3, farther = (i + 2) % 3;
      all[i][j] = m[down][right] * m[lower][farther] - m[down][farther] * m[lower][right];
    }
  const double determinant = m[0][0] * all[0][0] + m[0][1] * all[1][0] + m[0][2] * all[2][0];
  return scaled<double>(all, 1 / determinant);
}
}  // namespace tapestry::image
