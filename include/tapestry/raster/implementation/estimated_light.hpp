#pragma once
#include <tapestry/raster/estimated_light.hpp>

namespace tapestry::raster {
namespace detail {

/// max(0, n·L) · V of each point; a null view shadows nothing.
[[nodiscard]] inline std::vector<double> sun_shares(const std::vector<LitPoint>& points,
                                                    const geometry::Vector3& towards,
                                                    const ParallelView* view) {
  std::vector<double> shares(points.size(), 0.0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double cosine = geometry::dot(points[p].normal, towards);
    if (cosine > 0)
      shares[p] = cosine * (view != nullptr ? view->visible_share(points[p].face, points[p].point) : 1);
  }
  return shares;
}

/// A candidate for the sun, and how well it explains the points with its best sky.
struct SunCandidate {
  geometry::Vector3 towards{0, 0, 1};
  std::shared_ptr<const ParallelView> shadow{};
  std::vector<double> shares{};
  LightWeights weights{};
  double residual = 0;
};

[[nodiscard]] inline SunCandidate try_sun(const SkyBasis& basis, const std::vector<LitPoint>& points,
                                          const geometry::Vector3& towards,
                                          std::shared_ptr<const ParallelView> shadow) {
  SunCandidate sun{towards, std::move(shadow), {}, {}, 0};
  sun.shares = sun_shares(points, towards, sun.shadow.get());
  const LightEquations equations = basis.with_sun(sun.shares);
  sun.weights = non_negative_least_squares(equations);
  sun.residual = equations.residual(sun.weights);
  return sun;
}

/// Height of the lowest sun that is searched, for a direction of length 1.
inline constexpr double lowest_sun = 0.1;

/// The sun above the horizon that explains the points best: searched in 128 directions without shadows, then
/// with shadows around the best of them, ever closer.
[[nodiscard]] inline SunCandidate best_sun(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                           const SkyBasis& basis, std::size_t shadow_pixels) {
  constexpr std::size_t count = 256;  // over the whole sphere
  std::vector<SunCandidate> coarse(static_cast<std::size_t>(count * (1 - lowest_sun)) / 2);
  parallel_for(coarse.size(), [&](std::size_t i) {
    coarse[i] = try_sun(basis, points, spiral_direction(i, count), nullptr);
  });
  const auto is_better = [](const SunCandidate& a, const SunCandidate& b) { return a.residual < b.residual; };
  const auto with_shadow = [&](const geometry::Vector3& towards) {
    return try_sun(basis, points, towards,
                   std::make_shared<const ParallelView>(mesh, towards, shadow_pixels));
  };
  SunCandidate best = with_shadow(std::min_element(coarse.begin(), coarse.end(), is_better)->towards);
  for (const double step : {0.16, 0.08, 0.04, 0.02, 0.01})
    for (int turn = 0; turn < 6; ++turn) {
      const geometry::Vector3 side = geometry::normalised(
          geometry::cross(best.towards, std::abs(best.towards[2]) < 0.9 ? geometry::Vector3{0, 0, 1}
                                                                        : geometry::Vector3{1, 0, 0}));
      const double angle = turn * std::numbers::pi / 3;
      const auto across =
          geometry::add(geometry::scale(side, std::cos(angle)),
                        geometry::scale(geometry::cross(best.towards, side), std::sin(angle)));
      const auto towards = geometry::normalised(geometry::add(best.towards, geometry::scale(across, step)));
      if (!(towards[2] > lowest_sun)) continue;
      auto other = with_shadow(towards);
      if (is_better(other, best)) best = std::move(other);
    }
  return best;
}

/// The colour that fits points of known shading best, and each point's distance.
struct ColourFit {
  std::array<double, 3> colour{0, 0, 0};
  std::vector<double> distance{};  ///< Euclidean
  double error = 0;                ///< mean absolute error over points and channels
};

[[nodiscard]] inline ColourFit fit_colour(const std::vector<LitPoint>& points,
                                          const std::vector<double>& shading,
                                          const std::vector<double>& counts) {
  ColourFit fit;
  double square = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    square += counts[p] * shading[p] * shading[p];
    fit.colour = geometry::add(fit.colour, geometry::scale(points[p].colour, counts[p] * shading[p]));
  }
  fit.colour = geometry::scale(fit.colour, square > 0 ? 1 / square : 0);
  fit.distance.resize(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const auto off = geometry::subtract(geometry::scale(fit.colour, shading[p]), points[p].colour);
    fit.distance[p] = geometry::length(off);
    for (const double channel : off)
      fit.error += std::abs(channel) / (3 * static_cast<double>(points.size()));
  }
  return fit;
}

/// Weights of points by their distances: 1 / (1 + (d / 2.385 σ)²), Cauchy's, with σ = 1.4826 · their median.
[[nodiscard]] inline std::vector<double> robust_counts(const std::vector<double>& distances) {
  auto sorted = distances;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double scale = 2.385 * 1.4826 * *middle;
  std::vector<double> counts(distances.size(), 1.0);
  if (!(scale > 0)) return counts;
  for (std::size_t p = 0; p < counts.size(); ++p)
    counts[p] = 1 / (1 + (distances[p] / scale) * (distances[p] / scale));
  return counts;
}

inline void require_lit_points(const geometry::Mesh& mesh, const std::vector<LitPoint>& points) {
  if (points.empty()) throw DomainError("estimated_light: expected points of the photograph");
  for (const LitPoint& p : points)
    if (!geometry::is_finite(p.point) || !geometry::is_finite(p.normal) || !geometry::is_finite(p.colour) ||
        !std::isfinite(p.open) || p.face >= mesh.faces.size())
      throw DomainError("estimated_light: a point is not finite, or on no face of the mesh");
}

inline void require_paint(const std::optional<std::array<double, 3>>& paint) {
  for (const double channel : paint.value_or(std::array<double, 3>{1, 1, 1}))
    if (!(channel > 0) || !std::isfinite(channel))
      throw DomainError("estimated_light: paint must be finite and above 0");
}

/// Sets sun, sky and their colour from the weights and shading of the points and from the observed colour
/// `product`: for this paint, or else white, with the 99th percentile of the shading at 1.
/// \returns  the factor that divided the light and multiplied the product
inline double set_light(EstimatedLight& estimate, const LightWeights& weights, std::vector<double> shading,
                        const std::optional<std::array<double, 3>>& paint) {
  OutdoorLight& light = estimate.light;
  light.sun = weights[lobe_count];
  light.sky = {};
  for (std::size_t i = 0; i < lobe_count; ++i) {
    const Harmonics lobe = sky_lobe(i);
    for (std::size_t k = 0; k < 9; ++k) light.sky[k] += weights[i] * lobe[k];
  }
  if (paint) {
    for (std::size_t c = 0; c < 3; ++c) light.colour[c] = estimate.product[c] / (*paint)[c];
    return 1;
  }
  const auto bright = shading.begin() + static_cast<std::ptrdiff_t>(99 * (shading.size() - 1) / 100);
  std::nth_element(shading.begin(), bright, shading.end());
  const double brightest = *bright > 0 ? *bright : 1;
  light.sun /= brightest;
  for (double& coefficient : light.sky) coefficient /= brightest;
  estimate.product = geometry::scale(estimate.product, brightest);
  return 1 / brightest;
}

/// Corners of a face are moved inwards by this share before their hiders are looked up.
inline constexpr double occlusion_inset = 0.25;

/// Sums of cosines over the open directions of a face, not yet divided by those over all directions.
struct OcclusionSums {
  std::array<double, 2> whole{0, 0};            ///< of each side
  std::array<std::array<double, 3>, 2> open{};  ///< of each side, at each corner
};

inline void add_direction(const geometry::Mesh& mesh, std::size_t face, const geometry::Vector3& direction,
                          const ParallelView& view, OcclusionSums& sums) {
  std::array<geometry::Vector3, 3> corner;
  for (std::size_t k = 0; k < 3; ++k)
    corner[k] = mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])];
  const double cosine =
      geometry::dot(geometry::normalised(geometry::cross(geometry::subtract(corner[1], corner[0]),
                                                         geometry::subtract(corner[2], corner[0]))),
                    direction);
  if (cosine == 0 || !std::isfinite(cosine)) return;
  const std::size_t side = cosine > 0 ? 0 : 1;
  sums.whole[side] += std::abs(cosine);
  const auto middle =
      geometry::scale(geometry::add(geometry::add(corner[0], corner[1]), corner[2]), occlusion_inset / 3);
  for (std::size_t k = 0; k < 3; ++k)
    sums.open[side][k] +=
        std::abs(cosine) *
        view.visible_share(face, geometry::add(geometry::scale(corner[k], 1 - occlusion_inset), middle));
}

}  // namespace detail

EstimatedLight estimated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                               const std::optional<std::array<double, 3>>& paint, std::size_t shadow_pixels) {
  detail::require_lit_points(mesh, points);
  detail::require_paint(paint);
  detail::SkyBasis basis(points);
  std::vector<double> counts(points.size(), 1.0), shading(points.size());
  detail::SunCandidate sun;
  detail::ColourFit fit;
  for (int round = 0; round < 4; ++round) {
    if (round > 0) basis.weigh(counts = detail::robust_counts(fit.distance));
    sun = detail::best_sun(mesh, points, basis, shadow_pixels);
    for (std::size_t p = 0; p < points.size(); ++p) shading[p] = basis.shading(p, sun.weights, sun.shares[p]);
    fit = detail::fit_colour(points, shading, counts);
  }
  EstimatedLight estimate{{}, fit.colour, fit.error};
  estimate.light.direction = sun.towards;
  estimate.light.shadow = sun.shadow;
  detail::set_light(estimate, sun.weights, std::move(shading), paint);
  return estimate;
}

double AmbientOcclusion::at(std::size_t face, std::size_t side, const std::array<double, 3>& b) const {
  const auto& corner = open[face][side];
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += b[k] * static_cast<double>(corner[k]);
  return sum;
}

AmbientOcclusion ambient_occlusion(const geometry::Mesh& mesh, std::size_t directions, std::size_t pixels) {
  if (directions == 0 || directions > 65536)
    throw DomainError({"ambient_occlusion: directions is ", directions, ", expected 1 to 65536"});
  std::vector<detail::OcclusionSums> sums(mesh.faces.size());
  constexpr std::size_t block = 1024;
  for (std::size_t index = 0; index < directions; ++index) {
    const geometry::Vector3 direction = spiral_direction(index, directions);
    const ParallelView view(mesh, direction, pixels);
    parallel_for_blocks(sums.size(), block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t face = begin; face < end; ++face)
        detail::add_direction(mesh, face, direction, view, sums[face]);
    });
  }
  AmbientOcclusion result;
  result.open.resize(sums.size());
  for (std::size_t face = 0; face < sums.size(); ++face)
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& open = sums[face].open[side];
      const double whole = sums[face].whole[side], mean = (open[0] + open[1] + open[2]) / 3;
      for (std::size_t k = 0; k < 3; ++k) {
        const double at_corner = (open[k] - detail::occlusion_inset * mean) / (1 - detail::occlusion_inset);
        result.open[face][side][k] =
            whole > 0 ? static_cast<float>(std::clamp(at_corner / whole, 0.0, 1.0)) : 1.0F;
      }
    }
  return result;
}

}  // namespace tapestry::raster
