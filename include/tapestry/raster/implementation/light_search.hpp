#pragma once
#include <tapestry/raster/implementation/light_fit.hpp>

namespace tapestry::raster {
namespace detail {
/// Height of the lowest sun that is searched, for a direction of length 1.
inline constexpr double lowest_sun = 0.1;

/// Exponents of coats that are tried.
inline constexpr std::array<double, 7> coat_exponents{0.5, 0.75, 1, 1.5, 2, 3, 5};

/// The light that explains points of photographs best.
class LightSearch {
 public:
  LightSearch(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
              const std::optional<Colour>& paint, std::size_t shadow_pixels)
      : mesh_(mesh),
        shadow_pixels_(shadow_pixels),
        all_(points, paint),
        some_(thinned(points, 6000), paint),
        few_(thinned(points, 1500), paint) {}

  /// Searches 115 directions without shadows under three coats, then around the best eight with shadows, ever
  /// closer, also to other exponents; then takes the mean of all as good.
  [[nodiscard]] LightCandidate best() {
    constexpr std::size_t count = 256, least = 115;  // over the whole sphere, above lowest_sun
    std::vector<LightCandidate> suns;
    for (const std::size_t exponent : {std::size_t{0}, std::size_t{3}, coat_exponents.size() - 1})
      for (std::size_t i = 0; i < least; ++i) {
        suns.emplace_back().towards = spiral_direction(i, count);
        suns.back().exponent = coat_exponents[exponent];
      }
    suns = tried(std::move(suns), false);
    for (const auto& other : suns)
      if (other.residual <= 1.01 * suns.front().residual)
        within_rad = std::max(within_rad, angle(other.towards, suns.front().towards));
    suns.resize(8);
    LightCandidate best = tried(std::move(suns), true).front();
    for (const double step : {0.16, 0.08, 0.04, 0.02, 0.01}) best = nearby(best, step);
    best = mean_sun(best);
    all_.fit(best, 10);
    return best;
  }

  [[nodiscard]] static double angle(const geometry::Vector3& a, const geometry::Vector3& b) {
    return std::acos(std::clamp(geometry::dot(a, b), -1.0, 1.0));
  }

  double within_rad = 0;  ///< see EstimatedLight::sun_within_rad

 private:
  /// At most so many points, evenly spread: enough for a search.
  static std::vector<LitPoint> thinned(const std::vector<LitPoint>& points, std::size_t most) {
    const std::size_t stride = std::max<std::size_t>(1, block_count(points.size(), most));
    std::vector<LitPoint> some;
    for (std::size_t p = 0; p < points.size(); p += stride) some.push_back(points[p]);
    return some;
  }

  /// Candidates fitted to some points, the best first.
  [[nodiscard]] std::vector<LightCandidate> tried(std::vector<LightCandidate> suns, bool has_shadow) const {
    parallel_for(suns.size(), [&](std::size_t i) {
      if (has_shadow && !suns[i].shadow)
        suns[i].shadow = std::make_shared<const ParallelView>(mesh_, suns[i].towards, shadow_pixels_);
      if (has_shadow)
        some_.fit(suns[i], 4);
      else
        few_.fit(suns[i], 2);
    });
    std::ranges::stable_sort(suns, {}, &LightCandidate::residual);
    return suns;
  }

  /// The best sun that steps of one size lead to.
  [[nodiscard]] LightCandidate nearby(LightCandidate best, double step) const {
    for (int move = 0; move < 8; ++move) {
      const auto next = tried(around(best, step), true).front();
      if (next.towards == best.towards && next.exponent == best.exponent) break;
      best = next;
    }
    return best;
  }

  /// Mean of the suns around the best one, each counted by e^(−x / 0.0012) with x the excess of its residual
  /// over the best's: where many explain the points as well, a single one is an accident.
  [[nodiscard]] LightCandidate mean_sun(const LightCandidate& best) const {
    constexpr std::size_t count = 512;  // over the whole sphere
    constexpr double farthest = 0.7, excess = 0.0012;
    std::vector<LightCandidate> suns;
    for (std::size_t i = 0; i < count; ++i) {
      LightCandidate sun = best;
      sun.towards = spiral_direction(i, count);
      sun.shadow = nullptr;
      if (sun.towards[2] > lowest_sun && angle(sun.towards, best.towards) < farthest) suns.push_back(sun);
    }
    LightCandidate mean = best;
    for (const auto& sun : tried(std::move(suns), true))
      mean.towards = geometry::add(
          mean.towards, geometry::scale(sun.towards, std::exp((best.residual - sun.residual) / excess)));
    mean.towards = geometry::normalised(mean.towards);
    mean.shadow = std::make_shared<const ParallelView>(mesh_, mean.towards, shadow_pixels_);
    return mean;
  }

  /// A sun, six around it, a step away, and itself under coats of the next exponents.
  [[nodiscard]] static std::vector<LightCandidate> around(const LightCandidate& sun, double step) {
    const geometry::Vector3 axis =
        std::abs(sun.towards[2]) < 0.9 ? geometry::Vector3{0, 0, 1} : geometry::Vector3{1, 0, 0};
    const auto side = geometry::normalised(geometry::cross(sun.towards, axis));
    const auto other = geometry::cross(sun.towards, side);
    std::vector<LightCandidate> suns{sun};
    for (int turn = 0; turn < 6; ++turn) {
      const double angle = turn * std::numbers::pi / 3;
      const auto across =
          geometry::add(geometry::scale(side, std::cos(angle)), geometry::scale(other, std::sin(angle)));
      LightCandidate next = sun;
      next.towards = geometry::normalised(geometry::add(sun.towards, geometry::scale(across, step)));
      next.shadow = nullptr;
      if (next.towards[2] > lowest_sun) suns.push_back(next);
    }
    for (const double exponent : coat_exponents)
      if (exponent != sun.exponent && std::abs(std::log(exponent / sun.exponent)) < 0.6) {
        suns.push_back(sun);
        suns.back().exponent = exponent;
      }
    return suns;
  }

  const geometry::Mesh& mesh_;
  std::size_t shadow_pixels_;
  LightFit all_, some_, few_;
};

/// See EstimatedLight::others: faces whose points have less than half of the paint's colour in them, 1 where
/// they are darker than a quarter of it, else 2.
[[nodiscard]] inline std::vector<std::uint8_t> other_faces(const LightFit& fit,
                                                           const LightCandidate& candidate,
                                                           std::size_t face_count) {
  constexpr double least_share = 0.5, dark = 0.25, least_cosine = 0.35, least_chroma = 0.3;
  const Colour& paint = candidate.product;
  const auto mean_of = [](const Colour& colour) { return (colour[0] + colour[1] + colour[2]) / 3; };
  const auto chroma_of = [&](const Colour& colour) {
    return geometry::subtract(colour, geometry::scale({1, 1, 1}, mean_of(colour)));
  };
  const bool is_colourful = geometry::length(chroma_of(paint)) > least_chroma * mean_of(paint);
  std::vector<std::array<double, 4>> sums(face_count);
  const auto shadings = fit.shadings(candidate);
  for (std::size_t p = 0; p < shadings.size(); ++p) {
    const LitPoint& point = fit.points()[p];
    if (geometry::dot(point.normal, point.to_eye) < least_cosine) continue;
    auto own = geometry::scale(paint, shadings[p][0]);
    auto seen = geometry::subtract(point.colour, geometry::scale(candidate.colour, shadings[p][1]));
    auto& sum = sums[point.face];
    sum[2] += mean_of(seen);
    sum[3] += mean_of(own);
    if (is_colourful) {
      own = chroma_of(own);
      seen = chroma_of(seen);
    }
    sum[0] += geometry::dot(seen, own);
    sum[1] += geometry::dot(own, own);
  }
  std::vector<std::uint8_t> others(face_count);
  for (std::size_t face = 0; face < face_count; ++face) {
    const auto& sum = sums[face];
    if (sum[0] < least_share * sum[1]) others[face] = sum[2] < dark * sum[3] ? 1 : 2;
  }
  return others;
}

/// A light fitted to the faces of the paint, and which faces those are not.
struct FittedLight {
  LightCandidate candidate{};
  std::vector<std::uint8_t> others{};  ///< as EstimatedLight::others
  std::array<Colour, 2> other{};       ///< their colours, as LightCandidate::product
  double within_rad = 0;
};

/// FittedLight::other: medians over points, with the coat taken off, over the light on them.
[[nodiscard]] inline std::array<Colour, 2> colours_of_others(const LightFit& fit, const FittedLight& light) {
  std::array<std::array<std::vector<double>, 3>, 2> ratios;
  const auto shadings = fit.shadings(light.candidate);
  for (std::size_t p = 0; p < shadings.size(); ++p) {
    const std::size_t other = light.others[fit.points()[p].face];
    const auto [body, coat] = shadings[p];
    for (std::size_t c = 0; c < 3 && other > 0 && body > 0; ++c)
      ratios[other - 1][c].push_back((fit.points()[p].colour[c] - light.candidate.colour[c] * coat) / body);
  }
  std::array<Colour, 2> colours{};
  for (std::size_t other = 0; other < 2; ++other)
    for (std::size_t c = 0; c < 3 && !ratios[other][c].empty(); ++c)
      colours[other][c] = std::max(0.0, median_of(ratios[other][c]));
  return colours;
}

/// \param others  faces of another colour, if they are known
[[nodiscard]] inline FittedLight fitted_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                              const std::optional<Colour>& paint, std::size_t shadow_pixels,
                                              const std::vector<std::uint8_t>* others = nullptr) {
  FittedLight fitted;
  const LightFit all(points, paint);
  auto of_paint = points;
  const auto search = [&] {
    LightSearch suns(mesh, of_paint, paint, shadow_pixels);
    fitted.candidate = suns.best();
    fitted.within_rad = suns.within_rad;
  };
  if (others == nullptr) search();
  fitted.others = others == nullptr ? other_faces(all, fitted.candidate, mesh.faces.size()) : *others;
  std::erase_if(of_paint, [&](const LitPoint& p) { return fitted.others[p.face] != 0; });
  if (of_paint.empty()) {
    of_paint = points;
    std::fill(fitted.others.begin(), fitted.others.end(), std::uint8_t{0});
  }
  if (others != nullptr || of_paint.size() < points.size()) search();
  fitted.other = colours_of_others(all, fitted);
  return fitted;
}
}  // namespace detail
}  // namespace tapestry::raster
