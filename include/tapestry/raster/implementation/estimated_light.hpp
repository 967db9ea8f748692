#pragma once
#include <map>
#include <tapestry/raster/implementation/light_search.hpp>

namespace tapestry::raster {
namespace detail {
/// Sets the errors of an estimate on some points.
inline void set_errors(EstimatedLight& estimate, const FittedLight& light,
                       const std::vector<LitPoint>& points) {
  const auto shadings = LightFit(points, std::nullopt).shadings(light.candidate);
  double paint = 0, all = 0, count = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::size_t other = light.others[points[p].face];
    const bool is_other = other > 0;
    const double off =
        LightFit::difference(LightFit::modelled(is_other ? light.other[other - 1] : light.candidate.product,
                                                light.candidate.colour, shadings[p]),
                             points[p].colour);
    all += off;
    paint += is_other ? 0 : off;
    count += is_other ? 0 : 1;
  }
  const auto whole = static_cast<double>(points.size());
  estimate.error = count > 0 ? paint / count : 0;
  estimate.error_of_all = all / whole;
  estimate.other_share = 1 - count / whole;
}

/// Sets the light from what was fitted: for known paint, or else white, with the 97th percentile of the light
/// on the points at 1.
inline void set_light(EstimatedLight& estimate, const FittedLight& fitted, const LightFit& fit,
                      bool is_paint_known) {
  PhotographedLight& light = estimate.light;
  const LightCandidate& candidate = fitted.candidate;
  double brightest = 1;
  if (!is_paint_known) {
    auto shadings = fit.shadings(candidate);
    const auto bright = shadings.begin() + static_cast<std::ptrdiff_t>(97 * (shadings.size() - 1) / 100);
    std::nth_element(shadings.begin(), bright, shadings.end());
    brightest = (*bright)[0];
  }
  estimate.product = geometry::scale(candidate.product, std::max(0.0, brightest));
  for (std::size_t half = 0; half < 2; ++half)
    estimate.other[half] = geometry::scale(fitted.other[half], std::max(0.0, brightest));
  estimate.others = fitted.others;
  if (!(brightest > 0)) brightest = 1;  // no light at all
  light.sun = candidate.weights[0] / brightest;
  light.coat.emplace(NeutralCoat{candidate.exponent, {}, candidate.weights[light_terms - 1], {}});
  for (std::size_t k = 0; k < 9; ++k) {
    light.sky[k] = candidate.weights[1 + k] / brightest;
    light.coat->surroundings[k] = candidate.weights[body_terms + k];
  }
  std::copy_n(candidate.weights.begin() + body_terms + 9, height_band_count, light.coat->bands.begin());
  light.direction = candidate.towards;
  light.shadow = candidate.shadow;
  light.colour = candidate.colour;
}

/// Leaves photographs out in turn. Which faces are of another colour is known from all of them: it belongs to
/// the car.
[[nodiscard]] inline std::optional<HeldOut> held_out(
    const geometry::Mesh& mesh, const std::map<std::size_t, std::vector<LitPoint>>& views,
    const std::optional<Colour>& paint, std::size_t shadow_pixels, const LightFit& all,
    const EstimatedLight& whole) {
  if (views.size() < 2) return std::nullopt;
  const auto count = static_cast<double>(views.size());
  HeldOut result;
  for (const auto& left_out : views) {
    std::vector<LitPoint> rest;
    std::ranges::copy_if(all.points(), std::back_inserter(rest),
                         [&](const LitPoint& point) { return point.view != left_out.first; });
    const auto fitted = fitted_light(mesh, rest, paint, shadow_pixels, &whole.others);
    EstimatedLight other;
    set_errors(other, fitted, left_out.second);
    result.error += other.error / count;
    result.error_of_all += other.error_of_all / count;
    set_light(other, fitted, all, paint.has_value());
    result.sun_turn_rad =
        std::max(result.sun_turn_rad, LightSearch::angle(whole.light.direction, other.light.direction));
    if (whole.light.sun > 0)
      result.sun_change = std::max(result.sun_change, std::abs(other.light.sun / whole.light.sun - 1));
  }
  return result;
}

inline void require_lit_points(const geometry::Mesh& mesh, const std::vector<LitPoint>& points) {
  if (points.empty()) throw DomainError("estimated_light: expected points of the photograph");
  for (const LitPoint& p : points) {
    if (!geometry::is_finite(p.point) || !geometry::is_finite(p.normal) || !geometry::is_finite(p.colour) ||
        !std::isfinite(p.open) || p.face >= mesh.faces.size())
      throw DomainError("estimated_light: a point is not finite, or on no face of the mesh");
    if (!(geometry::length(p.to_eye) > 0.5)) throw DomainError("estimated_light: a point without an eye");
  }
}

inline void require_paint(const std::optional<Colour>& paint) {
  for (const double channel : paint.value_or(Colour{1, 1, 1}))
    if (!(channel > 0) || !std::isfinite(channel))
      throw DomainError("estimated_light: paint must be finite and above 0");
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

CoatedPoint PreparedPhotographedLight::coated(std::size_t face, const std::array<double, 3>& b) const {
  CoatedPoint seen =
      coated_point(normal(face, b), geometry::normalised(geometry::subtract(eye, point(face, b))));
  if (coat) seen.fresnel = clear_coat_f0 + (1 - clear_coat_f0) * std::pow(1 - seen.n_dot_v, coat->exponent);
  return seen;
}

std::array<double, 3> PreparedPhotographedLight::reflected(std::size_t face,
                                                           const std::array<double, 3>& b) const {
  if (!coat) return {0, 0, 0};
  const CoatedPoint seen = coated(face, b);
  const HeightBands bands = height_bands(seen.mirrored[2]);
  const double mirrored =
      std::max(0.0, std::inner_product(bands.begin(), bands.end(), coat->bands.begin(),
                                       dot(spherical_harmonics(seen.mirrored), coat->surroundings))) *
      open_share(face, b);
  const double sun =
      ggx_reflection(seen.normal, seen.to_eye, towards, seen.n_dot_v, glint_alpha, clear_coat_f0).value;
  const double glint = sun > 0 ? coat->glint * visible_share(face, b) * sun : 0;
  return geometry::scale(light_colour, seen.fresnel * mirrored + glint);
}

PreparedPhotographedLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                  const PhotographedLight& light) {
  return {prepare(mesh, camera, static_cast<const OutdoorLight&>(light)), light, geometry::eye_of(camera),
          light.coat};
}

EstimatedLight estimated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                               const std::optional<std::array<double, 3>>& paint, std::size_t shadow_pixels) {
  detail::require_lit_points(mesh, points);
  detail::require_paint(paint);
  const detail::LightFit all(points, paint);
  const auto fitted = detail::fitted_light(mesh, points, paint, shadow_pixels);
  EstimatedLight estimate;
  detail::set_light(estimate, fitted, all, paint.has_value());
  detail::set_errors(estimate, fitted, points);
  estimate.sun_within_rad = fitted.within_rad;
  std::map<std::size_t, std::vector<LitPoint>> views;
  for (const LitPoint& point : points) views[point.view].push_back(point);
  estimate.views = views.size();
  estimate.held_out = detail::held_out(mesh, views, paint, shadow_pixels, all, estimate);
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
