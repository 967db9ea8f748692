#pragma once
#include <tapestry/raster/lighting.hpp>

namespace tapestry::raster {

/// A point of a surface in a photograph.
struct LitPoint {
  std::size_t face = 0;
  geometry::Vector3 point{0, 0, 0};       ///< in the world
  geometry::Vector3 normal{0, 0, 1};      ///< of length 1, on the visible side
  double open = 1;                        ///< visible share of the sky, see AmbientOcclusion
  std::array<double, 3> colour{0, 0, 0};  ///< in the photograph, in proportion to light; at 1 it is a bound
  geometry::Vector3 to_eye{0, 0, 0};      ///< of length 1; of length 0 where nothing is mirrored
};

namespace detail {

/// Number of sky parts, whose sum is nowhere negative: distant lights from above, and the ground, which is
/// equally bright everywhere.
inline constexpr std::size_t lobe_count = 33;

/// A part of the sky: a distant light that gives a surface facing it about 1.
[[nodiscard]] inline Harmonics sky_lobe(std::size_t index) {
  const double pi = std::numbers::pi;
  if (index + 1 == lobe_count)
    return {std::sqrt(pi), 0, -std::sqrt(3 * pi) / 2, 0, 0, 0, 0, 0, 0};  // all below
  Harmonics lobe = spherical_harmonics(spiral_direction(index, 2 * (lobe_count - 1)));
  for (double& coefficient : lobe) coefficient *= pi;
  return lobe;
}

/// Unknowns of the estimate: a weight for each lobe, then the sun's.
inline constexpr std::size_t weight_count = lobe_count + 1;
using LightWeights = std::array<double, weight_count>;

/// Sums of products, Σ basis·basisᵀ and Σ basis·brightness.
struct LightEquations {
  std::array<LightWeights, weight_count> product{};
  LightWeights right{};
  double square = 0;  ///< Σ brightness²

  [[nodiscard]] double residual(const LightWeights& weights) const {
    double sum = square;
    for (std::size_t i = 0; i < weight_count; ++i) {
      double row = -2 * right[i];
      for (std::size_t j = 0; j < weight_count; ++j) row += product[i][j] * weights[j];
      sum += weights[i] * row;
    }
    return std::max(0.0, sum);
  }
};

/// Least squares with weights ≥ 0: coordinate descent, until no weight moves by a millionth of the largest.
[[nodiscard]] inline LightWeights non_negative_least_squares(const LightEquations& equations) {
  LightWeights weights{};
  for (int sweep = 0; sweep < 400; ++sweep) {
    double moved = 0, largest = 0;
    for (std::size_t i = 0; i < weight_count; ++i) {
      const double diagonal = equations.product[i][i];
      if (!(diagonal > 0)) continue;
      double slope = equations.right[i];
      for (std::size_t j = 0; j < weight_count; ++j) slope -= equations.product[i][j] * weights[j];
      const double weight = std::max(0.0, weights[i] + slope / diagonal);
      moved = std::max(moved, std::abs(weight - weights[i]));
      largest = std::max(largest, weight);
      weights[i] = weight;
    }
    if (moved <= 1e-6 * largest) break;
  }
  return weights;
}

/// Shading of each point by lobes of the sky.
class SkyBasis {
 public:
  explicit SkyBasis(const std::vector<LitPoint>& points) : points_(points), shading_(points.size()) {
    std::array<Harmonics, lobe_count> lobes;
    for (std::size_t i = 0; i < lobe_count; ++i) lobes[i] = sky_lobe(i);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Harmonics transfer = sky_transfer(points[p].normal);
      for (std::size_t i = 0; i < lobe_count; ++i) shading_[p][i] = points[p].open * dot(transfer, lobes[i]);
    }
    weigh(std::vector<double>(points.size(), 1.0));
  }

  /// Sets the weight of each point.
  void weigh(std::vector<double> counts) {
    counts_ = std::move(counts);
    equations_ = {};
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const double target = brightness(points_[p]);
      equations_.square += counts_[p] * target * target;
      for (std::size_t i = 0; i < lobe_count; ++i) {
        const double counted = counts_[p] * shading_[p][i];
        equations_.right[i] += counted * target;
        for (std::size_t j = 0; j < lobe_count; ++j) equations_.product[i][j] += counted * shading_[p][j];
      }
    }
    smooth();
  }

  [[nodiscard]] static double brightness(const LitPoint& point) {
    return (point.colour[0] + point.colour[1] + point.colour[2]) / 3;
  }

  /// The equations with a sun, given its light on each point.
  [[nodiscard]] LightEquations with_sun(const std::vector<double>& sun) const {
    LightEquations equations = equations_;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (sun[p] == 0) continue;
      const double counted = counts_[p] * sun[p];
      for (std::size_t i = 0; i < lobe_count; ++i)
        equations.product[lobe_count][i] += counted * shading_[p][i];
      equations.product[lobe_count][lobe_count] += counted * sun[p];
      equations.right[lobe_count] += counted * brightness(points_[p]);
    }
    for (std::size_t i = 0; i < lobe_count; ++i)
      equations.product[i][lobe_count] = equations.product[lobe_count][i];
    return equations;
  }

  /// Shading of point p for these weights.
  [[nodiscard]] double shading(std::size_t p, const LightWeights& weights, double sun) const {
    double sum = weights[lobe_count] * sun;
    for (std::size_t i = 0; i < lobe_count; ++i) sum += weights[i] * shading_[p][i];
    return sum;
  }

 private:
  /// Adds λ · Σ (weight − mean weight)² over the sky above the ground, λ three tenths of the mean diagonal:
  /// so light that a sun explains equally well does not become a bright place in the sky.
  void smooth() {
    constexpr std::size_t above = lobe_count - 1;
    double trace = 0;
    for (std::size_t i = 0; i < above; ++i) trace += equations_.product[i][i];
    const double strength = 0.3 * trace / above;
    for (std::size_t i = 0; i < above; ++i) {
      equations_.product[i][i] += strength;
      for (std::size_t j = 0; j < above; ++j) equations_.product[i][j] -= strength / above;
    }
  }

  const std::vector<LitPoint>& points_;
  std::vector<std::array<double, lobe_count>> shading_;
  std::vector<double> counts_;
  LightEquations equations_;
};

}  // namespace detail

}  // namespace tapestry::raster
