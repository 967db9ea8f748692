#pragma once
#include <tapestry/image/colour_space.hpp>
#include <tapestry/raster/implementation/estimated_light.hpp>
#include <tapestry/raster/implementation/photographed_light.hpp>

namespace tapestry::raster {
namespace detail {

/// Resolutions of gloss and surroundings, each twice the one before: 4 × 8 to 64 × 128 texels. On six frames
/// of a simulator, a fit to half of the car's painted pixels, in squares of 8, differs from the other half by
/// .076 as encoded colours, .062 from its own; without coat and gloss by .135.
inline constexpr int environment_levels = 5;
inline constexpr double environment_togetherness = 0.001;

/// Greatest radiance of the surroundings: twice the radiance of white paint where it is brightest.
/// Without a bound they took the colour of a car's doors, which are seen head-on and mirror 4 %, and
/// another paint hardly showed there.
inline constexpr double brightest_surroundings = 2;

/// Weight of the square of gloss: if gloss and surroundings explain a photograph
/// equally well, surroundings win.
inline constexpr double gloss_smallness = 10;

/// Surroundings that points of a photograph mirror, fitted from coarse to fine.
class SurroundingsFit {
 public:
  using Colour = std::array<double, 3>;

  /// \param mirrors  of the points
  /// \param shares   share of its mirror image that each point shows
  /// \param most       greatest value of a texel
  /// \param smallness  weight of a texel's own square, in weights of a square of a difference between
  /// neighbours
  SurroundingsFit(const std::vector<CoatedPoint>& mirrors, std::vector<double> shares, double most,
                  double smallness)
      : mirrors_(mirrors), share_(std::move(shares)), most_(most), smallness_(smallness) {}

  [[nodiscard]] const EnvironmentMap& map() const { return map_; }

  /// Radiance that point p shows of the map.
  [[nodiscard]] Colour mirrored(std::size_t p) const {
    return geometry::scale(map_.at(mirrors_[p].mirrored), share_[p]);
  }

  /// Begins with 4 × 8 black texels, then doubles the resolution at each call.
  void refine() {
    EnvironmentMap finer{map_.height == 0 ? 4 : 2 * map_.height, map_.height == 0 ? 8 : 2 * map_.width, {}};
    finer.texels.assign(finer.height * finer.width, {0, 0, 0});
    for (std::size_t texel = 0; map_.height > 0 && texel < finer.texels.size(); ++texel)
      finer.texels[texel] = map_.at(finer.direction(texel));
    map_ = std::move(finer);
    lookups_.assign(map_.texels.size(), {});
    for (std::size_t p = 0; p < share_.size(); ++p)
      for (const Tap& tap : map_.taps(mirrors_[p].mirrored))
        if (tap.weight * share_[p] > 0) lookups_[tap.texel].push_back({p, tap.weight * share_[p]});
  }

  /// Fits the mirrored radiances by least squares, texel by texel in turn, none below 0.
  /// \param counts  weights of the points
  void fit(const std::vector<Colour>& targets, const std::vector<double>& counts) {
    std::vector<Colour> missing(share_.size());
    for (std::size_t p = 0; p < missing.size(); ++p) missing[p] = geometry::subtract(targets[p], mirrored(p));
    const double together = togetherness(counts);
    for (int sweep = 0; sweep < 24; ++sweep)
      for (std::size_t texel = 0; texel < map_.texels.size(); ++texel) {
        const Colour step = step_of(texel, counts, missing, together);
        map_.texels[texel] = geometry::add(map_.texels[texel], step);
        for (const auto& [p, weight] : lookups_[texel])
          missing[p] = geometry::subtract(missing[p], geometry::scale(step, weight));
      }
  }

 private:
  struct Lookup {
    std::size_t point;
    double weight;
  };

  /// Weight of the square of a difference between neighbours: a share of the mean over texels that are
  /// mirrored of Σ count · weight².
  [[nodiscard]] double togetherness(const std::vector<double>& counts) const {
    double sum = 0;
    std::size_t seen = 0;
    for (const auto& lookups : lookups_) {
      for (const auto& [p, weight] : lookups) sum += counts[p] * weight * weight;
      seen += lookups.empty() ? 0U : 1U;
    }
    return seen > 0 ? environment_togetherness * sum / static_cast<double>(seen) : 0;
  }

  [[nodiscard]] Colour step_of(std::size_t texel, const std::vector<double>& counts,
                               const std::vector<Colour>& missing, double together) const {
    const Colour own = map_.texels[texel];
    Colour slope = geometry::scale(own, -smallness_ * together);
    double curvature = smallness_ * together;
    for (const auto& [p, weight] : lookups_[texel]) {
      slope = geometry::add(slope, geometry::scale(missing[p], counts[p] * weight));
      curvature += counts[p] * weight * weight;
    }
    const std::size_t row = texel / map_.width, column = texel % map_.width;
    const auto draw_to = [&](std::size_t other_row, std::size_t other_column) {
      const Colour& other = map_.texels[other_row * map_.width + other_column % map_.width];
      slope = geometry::add(slope, geometry::scale(geometry::subtract(other, own), together));
      curvature += together;
    };
    draw_to(row, column + 1);
    draw_to(row, column + map_.width - 1);
    if (row > 0) draw_to(row - 1, column);
    if (row + 1 < map_.height) draw_to(row + 1, column);
    Colour step{0, 0, 0};
    for (std::size_t c = 0; c < 3 && curvature > 0; ++c)
      step[c] = std::clamp(own[c] + slope[c] / curvature, 0.0, most_) - own[c];
    return step;
  }

  const std::vector<CoatedPoint>& mirrors_;
  std::vector<double> share_;
  double most_;
  double smallness_;
  EnvironmentMap map_;
  std::vector<std::vector<Lookup>> lookups_;  ///< of each texel
};

/// Diffuse light, gloss and surroundings, each estimated given the others, in turn.
class CoatedFit {
 public:
  CoatedFit(const std::vector<LitPoint>& points, std::vector<double> sun_shares)
      : points_(points),
        mirrors_(mirrors_of(points)),
        surroundings_(mirrors_, shares(true), brightest_surroundings, 0),
        gloss_(mirrors_, shares(false), std::numeric_limits<double>::infinity(), gloss_smallness),
        sun_(std::move(sun_shares)),
        matt_(dimmed()),
        basis_(matt_),
        counts_(points.size(), 1.0),
        shading_(points.size()),
        targets_(points.size()) {
    for (std::size_t p = 0; p < points.size(); ++p) {
      sun_[p] *= 1 - mirrors_[p].fresnel;
      targets_[p] = points[p].colour;
    }
  }

  void run() {
    for (int level = 0; level < environment_levels; ++level) {
      surroundings_.refine();
      gloss_.refine();
      for (int round = 0; round < 4; ++round) {
        fit_matt();
        fit_gloss();
        fit_surroundings();
        judge();
      }
    }
  }

  [[nodiscard]] const LightWeights& weights() const { return weights_; }
  [[nodiscard]] const std::array<double, 3>& colour() const { return colour_; }
  [[nodiscard]] const EnvironmentMap& surroundings() const { return surroundings_.map(); }
  [[nodiscard]] const EnvironmentMap& gloss() const { return gloss_.map(); }

  /// The light on each point, before its colour.
  [[nodiscard]] std::vector<double> light() const {
    auto light = shading_;
    for (std::size_t p = 0; p < light.size(); ++p) light[p] += gloss_.mirrored(p)[0];
    return light;
  }

  /// Mean absolute difference of points and channels; bounds that hold add 0.
  [[nodiscard]] double error() const {
    double sum = 0;
    for (std::size_t p = 0; p < points_.size(); ++p)
      for (std::size_t c = 0; c < 3; ++c) sum += std::abs(modelled(p)[c] - targets_[p][c]);
    return sum / (3 * static_cast<double>(points_.size()));
  }

 private:
  static std::vector<CoatedPoint> mirrors_of(const std::vector<LitPoint>& points) {
    std::vector<CoatedPoint> mirrors;
    for (const LitPoint& point : points) mirrors.push_back(coated_point(point.normal, point.to_eye));
    return mirrors;
  }

  /// F · A, the share that the coat mirrors, or (1 − F) · A, the share that it lets through.
  [[nodiscard]] std::vector<double> shares(bool is_mirrored) const {
    std::vector<double> shares;
    for (std::size_t p = 0; p < points_.size(); ++p)
      shares.push_back(points_[p].open * (is_mirrored ? mirrors_[p].fresnel : 1 - mirrors_[p].fresnel));
    return shares;
  }

  /// The points, open by (1 − F) · A.
  [[nodiscard]] std::vector<LitPoint> dimmed() const {
    auto points = points_;
    for (std::size_t p = 0; p < points.size(); ++p) points[p].open *= 1 - mirrors_[p].fresnel;
    return points;
  }

  [[nodiscard]] std::array<double, 3> modelled(std::size_t p) const {
    return geometry::add(geometry::scale(colour_, shading_[p] + gloss_.mirrored(p)[0]),
                         surroundings_.mirrored(p));
  }

  void fit_matt() {
    for (std::size_t p = 0; p < points_.size(); ++p)
      matt_[p].colour = geometry::subtract(geometry::subtract(targets_[p], surroundings_.mirrored(p)),
                                           geometry::scale(colour_, gloss_.mirrored(p)[0]));
    basis_.weigh(counts_);
    weights_ = non_negative_least_squares(basis_.with_sun(sun_));
    const double brightness = geometry::dot(colour_, {1, 1, 1}) / 3;  // the fit gave colour_ · shading_
    if (brightness > 0)
      for (double& weight : weights_) weight /= brightness;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      shading_[p] = basis_.shading(p, weights_, sun_[p]);
      matt_[p].colour = geometry::subtract(targets_[p], surroundings_.mirrored(p));
    }
    colour_ = fit_colour(matt_, light(), counts_).colour;
    for (double& channel : colour_) channel = std::max(0.0, channel);
  }

  void fit_gloss() {
    const double square = geometry::dot(colour_, colour_);
    if (!(square > 0)) return;
    std::vector<std::array<double, 3>> targets(points_.size());
    for (std::size_t p = 0; p < targets.size(); ++p)
      targets[p].fill(geometry::dot(colour_, geometry::subtract(targets_[p], surroundings_.mirrored(p))) /
                          square -
                      shading_[p]);
    gloss_.fit(targets, counts_);
  }

  void fit_surroundings() {
    auto mirrored = targets_;
    for (std::size_t p = 0; p < mirrored.size(); ++p)
      mirrored[p] =
          geometry::subtract(mirrored[p], geometry::scale(colour_, shading_[p] + gloss_.mirrored(p)[0]));
    surroundings_.fit(mirrored, counts_);
  }

  /// Moves targets that are bounds to the model where it lies beyond them, and weighs the points: least
  /// squares with weights slope² / difference are least absolute differences of encoded colours.
  void judge() {
    constexpr double least = 0.01;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const auto model = modelled(p);
      double difference = 0, slope = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double photo = points_[p].colour[c];
        targets_[p][c] = photo >= 1 ? std::max(photo, model[c]) : photo;
        const double a = image::encoded(std::clamp(model[c], 0.0, 1.0));
        const double b = image::encoded(std::clamp(photo, 0.0, 1.0));
        difference += std::abs(a - b) / 3;
        const double brighter = std::max(0.003, std::max(photo, model[c]));
        slope += image::encoded_slope(brighter, image::encoded(brighter)) / 3;
      }
      counts_[p] = slope * slope / std::max(least, difference);
    }
  }

  const std::vector<LitPoint>& points_;
  std::vector<CoatedPoint> mirrors_;
  SurroundingsFit surroundings_, gloss_;
  std::vector<double> sun_;     ///< (1 − F) · max(0, n·L) · V
  std::vector<LitPoint> matt_;  ///< the rest for sun and sky, below the coat
  SkyBasis basis_;              ///< of matt_
  std::vector<double> counts_, shading_;
  std::vector<std::array<double, 3>> targets_;
  LightWeights weights_{};
  std::array<double, 3> colour_{0, 0, 0};
};

}  // namespace detail

EstimatedLight coated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                            const EstimatedLight& matt, const std::optional<std::array<double, 3>>& paint) {
  detail::require_lit_points(mesh, points);
  detail::require_paint(paint);
  for (const LitPoint& point : points)
    if (!(geometry::length(point.to_eye) > 0.5)) throw DomainError("coated_light: a point without an eye");
  const auto towards = geometry::normalised(matt.light.direction);
  detail::CoatedFit fit(points, detail::sun_shares(points, towards, matt.light.shadow.get()));
  fit.run();
  EstimatedLight estimate{matt.light, fit.colour(), fit.error()};
  const double strength = detail::set_light(estimate, fit.weights(), fit.light(), paint);
  auto gloss = fit.gloss();
  for (auto& texel : gloss.texels) texel = geometry::scale(texel, strength);
  estimate.light.surroundings = std::make_shared<const EnvironmentMap>(fit.surroundings());
  estimate.light.gloss = std::make_shared<const EnvironmentMap>(std::move(gloss));
  return estimate;
}

}  // namespace tapestry::raster
