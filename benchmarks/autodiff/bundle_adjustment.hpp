#pragma once
#include <algorithm>
#include <array>
#include "seeded.hpp"

namespace tapestry::benchmarks {
/// Bundle adjustment as in the public ADBench suite, on drawn cameras and points: 20 cameras of 11 parameters
/// (rotation, centre, focal length, principal point, two radial distortions), 500 points, each seen by 10
/// cameras, and a weight an observation. Residuals of an observation: the weighted reprojection error, two
/// numbers, and 1 − weight².
struct BundleProblem {
  static constexpr std::size_t cameras = 20, points = 500, views = 10, observations = points * views;
  static constexpr std::size_t camera_size = 11, block = camera_size + 3 + 1, residuals = 3 * observations;
  static constexpr std::size_t first_point = cameras * camera_size, first_weight = first_point + 3 * points;

  std::vector<double> seen = uniform(2 * observations, -.3, .3, 61);
  [[nodiscard]] static std::vector<double> start() {
    auto x = uniform(first_weight + observations, -1, 1, 62);
    for (std::size_t camera = 0; camera < cameras; ++camera) {
      double* const p = x.data() + camera * camera_size;
      for (std::size_t i = 0; i < 3; ++i) p[i] *= .3;
      p[5] -= 5;
      p[6] = 1 + p[6] * .1;
      for (std::size_t i = 7; i < camera_size; ++i) p[i] *= .05;
    }
    for (std::size_t i = first_weight; i < x.size(); ++i) x[i] = .75 + .25 * x[i];
    return x;
  }
  [[nodiscard]] static std::size_t point(std::size_t observation) { return observation / views; }
  [[nodiscard]] static std::size_t camera(std::size_t observation) {
    return (7 * observation + point(observation)) % cameras;  // another one each time that a point is seen
  }

  /// The inputs of an observation's residuals: camera, point, weight.
  template <class S>
  [[nodiscard]] static std::array<S, block> block_of(const S* x, std::size_t observation) {
    std::array<S, block> inputs;
    std::copy_n(x + camera(observation) * camera_size, camera_size, inputs.begin());
    std::copy_n(x + first_point + 3 * point(observation), 3, inputs.begin() + camera_size);
    inputs[block - 1] = x[first_weight + observation];
    return inputs;
  }

  /// The weighted reprojection error.
  template <class S>
  static void reproject(const S* camera, const S* point, const S& weight, const double* seen, S* error) {
    const S x = point[0] - camera[3], y = point[1] - camera[4], z = point[2] - camera[5];
    const S angle = sqrt(camera[0] * camera[0] + camera[1] * camera[1] + camera[2] * camera[2]);
    const S s = sin(angle), c = cos(angle);
    const S u = camera[0] / angle, v = camera[1] / angle, w = camera[2] / angle;
    const S along = (u * x + v * y + w * z) * (1. - c);
    const S depth = z * c + (u * y - v * x) * s + w * along;
    const S a = (x * c + (v * z - w * y) * s + u * along) / depth;
    const S b = (y * c + (w * x - u * z) * s + v * along) / depth;
    const S square = a * a + b * b;
    const S scale = camera[6] * (1. + camera[9] * square + camera[10] * square * square);
    error[0] = weight * (camera[7] + scale * a - seen[0]);
    error[1] = weight * (camera[8] + scale * b - seen[1]);
  }

  /// All residuals: two of each observation, then one of each.
  template <class S>
  void residuals_of(const S* x, S* result) const {
    for (std::size_t o = 0; o < observations; ++o) {
      const S& weight = x[first_weight + o];
      reproject(x + camera(o) * camera_size, x + first_point + 3 * point(o), weight, seen.data() + 2 * o,
                result + 2 * o);
      result[2 * observations + o] = 1. - weight * weight;
    }
  }
};

/// An observation's weighted errors, and their derivatives by its inputs, [2, block], by hand.
template <class T>
std::array<T, 2> hand_block(const T* in, const double* seen, T* jacobian) {
  const T *const r = in, *const centre = in + 3, *const point = in + BundleProblem::camera_size;
  const T focal = in[6], weight = in[BundleProblem::block - 1];
  const T angle = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]), s = std::sin(angle),
          c = std::cos(angle);
  const T u[3] = {r[0] / angle, r[1] / angle, r[2] / angle};
  const T y[3] = {point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]};
  const T across[3] = {u[1] * y[2] - u[2] * y[1], u[2] * y[0] - u[0] * y[2], u[0] * y[1] - u[1] * y[0]};
  const T along = u[0] * y[0] + u[1] * y[1] + u[2] * y[2];
  T p[3], by_angle[3], by_y[3][3], by_u[3][3];
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = y[i] * c + across[i] * s + u[i] * along * (1 - c);
    by_angle[i] = across[i] * c - y[i] * s + u[i] * along * s;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t k = 3 - i - j;  // of i ≠ j, the third
      const T sign = (j + 3 - i) % 3 == 1 ? T(-1) : T(1);
      by_y[i][j] = i == j ? c + u[i] * u[i] * (1 - c) : sign * s * u[k] + u[i] * u[j] * (1 - c);
      by_u[i][j] = i == j ? (1 - c) * (along + u[i] * y[i]) : (1 - c) * u[i] * y[j] - sign * s * y[k];
    }
  }
  const T a[2] = {p[0] / p[2], p[1] / p[2]};
  const T square = a[0] * a[0] + a[1] * a[1], lens = 1 + in[9] * square + in[10] * square * square;
  const T bend = 2 * in[9] + 4 * in[10] * square;
  std::array<T, 2> errors;
  for (std::size_t e = 0; e < 2; ++e) {
    T* const row = jacobian + e * BundleProblem::block;
    const T off = in[7 + e] + focal * lens * a[e] - static_cast<T>(seen[e]);
    errors[e] = weight * off;
    const T scale = weight * focal;
    const T by_a[2] = {scale * ((e == 0 ? lens : T(0)) + a[e] * bend * a[0]),
                       scale * ((e == 1 ? lens : T(0)) + a[e] * bend * a[1])};
    const T by_p[3] = {by_a[0] / p[2], by_a[1] / p[2], -(by_a[0] * a[0] + by_a[1] * a[1]) / p[2]};
    T turned = 0, by_axis[3], inward = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      turned += by_p[j] * by_angle[j];
      by_axis[j] = by_p[0] * by_u[0][j] + by_p[1] * by_u[1][j] + by_p[2] * by_u[2][j];
      row[BundleProblem::camera_size + j] =
          by_p[0] * by_y[0][j] + by_p[1] * by_y[1][j] + by_p[2] * by_y[2][j];
      row[3 + j] = -row[BundleProblem::camera_size + j];
      inward += by_axis[j] * u[j];
    }
    for (std::size_t j = 0; j < 3; ++j) row[j] = turned * u[j] + (by_axis[j] - inward * u[j]) / angle;
    row[6] = weight * lens * a[e];
    row[7 + e] = weight;
    row[8 - e] = 0;
    row[9] = scale * a[e] * square;
    row[10] = scale * a[e] * square * square;
    row[BundleProblem::block - 1] = off;
  }
  return errors;
}

/// ½ Σ of all squared residuals.
struct Bundle : BundleProblem {
  static constexpr const char* name = "bundle";

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    std::vector<S> all(residuals);
    residuals_of(x, all.data());
    S total = 0;
    for (const S& residual : all) total += residual * residual;
    return 0.5 * total;
  }
};

template <class T>
T hand_adjoint(const Bundle& bundle, const T* x, T* gradient) {
  using B = BundleProblem;
  std::fill_n(gradient, B::first_weight + B::observations, T(0));
  T total = 0, jacobian[2 * B::block];
  for (std::size_t o = 0; o < B::observations; ++o) {
    const auto in = B::block_of(x, o);
    const auto errors = hand_block(in.data(), bundle.seen.data() + 2 * o, jacobian);
    const T weight = in[B::block - 1], rest = 1 - weight * weight;
    total += errors[0] * errors[0] + errors[1] * errors[1] + rest * rest;
    const auto entry = [&](std::size_t k) {
      return errors[0] * jacobian[k] + errors[1] * jacobian[B::block + k];
    };
    T* const camera = gradient + B::camera(o) * B::camera_size;
    T* const point = gradient + B::first_point + 3 * B::point(o);
    for (std::size_t k = 0; k < B::camera_size; ++k) camera[k] += entry(k);
    for (std::size_t k = 0; k < 3; ++k) point[k] += entry(B::camera_size + k);
    gradient[B::first_weight + o] = entry(B::block - 1) - 2 * weight * rest;
  }
  return total / 2;
}

/// The Jacobian of the residuals, and as value their sum. It is kept as [observations, 2, block], its other
/// entries being 0, and behind it the derivatives of 1 − weight², [observations].
struct BundleJacobian : BundleProblem {
  static constexpr const char* name = "bundle-jacobian";
  static constexpr std::size_t entries = (2 * block + 1) * observations;

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    std::vector<S> all(residuals);
    residuals_of(x, all.data());
    S total = 0;
    for (const S& residual : all) total += residual;
    return total;
  }
};

template <class T>
T hand_adjoint(const BundleJacobian& bundle, const T* x, T* jacobian) {
  using B = BundleProblem;
  T total = 0;
  for (std::size_t o = 0; o < B::observations; ++o) {
    const auto in = B::block_of(x, o);
    const auto errors = hand_block(in.data(), bundle.seen.data() + 2 * o, jacobian + 2 * B::block * o);
    const T weight = in[B::block - 1];
    jacobian[2 * B::block * B::observations + o] = -2 * weight;
    total += errors[0] + errors[1] + 1 - weight * weight;
  }
  return total;
}
}  // namespace tapestry::benchmarks
