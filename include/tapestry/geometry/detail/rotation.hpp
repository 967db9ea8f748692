#pragma once
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {
namespace detail {
/// sin θ/θ, (1 − cos θ)/θ² and (θ − sin θ)/θ³, by their series Σ (−θ²)ᵏ/(2k + n)!, n = 1, 2, 3, where the
/// closed forms would cancel: below θ = ½ eight terms leave less than 1e-18.
template <class Scalar>
[[nodiscard]] std::array<Scalar, 3> rotation_factors(const Scalar& squared_angle) {
  using std::cos, std::sin, std::sqrt;
  std::array<Scalar, 3> factors{};
  if (squared_angle < Scalar(0.25)) {
    for (std::size_t n = 0; n < 3; ++n) {
      double factorial = n == 2 ? 6 : static_cast<double>(n + 1);
      Scalar power(1);
      for (std::size_t k = 0; k < 8; ++k) {
        factors[n] = factors[n] + power / factorial;
        const auto next = static_cast<double>(2 * k + n + 2);
        factorial *= next * (next + 1);
        power = -power * squared_angle;
      }
    }
    return factors;
  }
  const Scalar angle = sqrt(squared_angle);
  const Scalar half = sin(angle / 2) / angle;
  return {sin(angle) / angle, 2 * half * half, (angle - sin(angle)) / (angle * squared_angle)};
}

/// 1 + b·[w]× + c·[w]×², where [w]×² = w·wᵀ − θ²·1.
template <class Scalar>
[[nodiscard]] std::array<std::array<Scalar, 3>, 3> cross_polynomial(const std::array<Scalar, 3>& w,
                                                                    const Scalar& b, const Scalar& c) {
  const Scalar squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  std::array<std::array<Scalar, 3>, 3> m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = c * w[i] * w[j];
    m[i][i] = m[i][i] + 1 - c * squared;
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    m[i][j] = m[i][j] - b * w[k];
    m[i][k] = m[i][k] + b * w[j];
  }
  return m;
}
}  // namespace detail

/// The rotation about w by |w| radians (Rodrigues), smooth for every w, also at 0 and |w| = π:
///   exp([w]×) = 1 + sin θ/θ · [w]× + (1 − cos θ)/θ² · [w]×².
/// For any scalar with sin, cos and sqrt.
template <class Scalar>
[[nodiscard]] std::array<std::array<Scalar, 3>, 3> exponential_map(const std::array<Scalar, 3>& w) {
  const auto factors = detail::rotation_factors(Scalar(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
  return detail::cross_polynomial(w, factors[0], factors[1]);
}

/// J with exp(w + δ) = exp(w)·exp(J·δ) + O(δ²):
///   J = 1 − (1 − cos θ)/θ² · [w]× + (θ − sin θ)/θ³ · [w]×².
/// Source: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), appendix B.
[[nodiscard]] inline Matrix3 right_jacobian(const Vector3& w) {
  const auto factors = detail::rotation_factors(dot(w, w));
  return detail::cross_polynomial(w, -factors[1], factors[2]);
}

/// Adds Σ_ij rotation_adjoint_ij · ∂exp(w)_ij/∂w to w_adjoint. As dR = R·[J·dw]×, only the part of
/// M = Rᵀ·rotation_adjoint that is not symmetric counts.
inline void exponential_map_adjoint(const Vector3& w, const Matrix3& rotation_adjoint, Vector3& w_adjoint) {
  const Matrix3 rotation = exponential_map(w);
  const auto m = [&](std::size_t i, std::size_t j) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += rotation[k][i] * rotation_adjoint[k][j];
    return sum;
  };
  const Vector3 turn{m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)};
  w_adjoint = add(w_adjoint, multiply_transposed(right_jacobian(w), turn));
}
}  // namespace tapestry::geometry
