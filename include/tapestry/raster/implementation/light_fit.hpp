#pragma once
#include <numeric>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/raster/estimated_light.hpp>

namespace tapestry::raster::detail {
/// Terms of a light: below a coat, sun and sky (9); in it, surroundings (9), their bands and a glint.
inline constexpr std::size_t body_terms = 10, light_terms = body_terms + 9 + height_band_count + 1;
using LightTerms = std::array<double, light_terms>;
using Colour = std::array<double, 3>;

/// A sun and an exponent, and all that follows from them for some points.
struct LightCandidate {
  geometry::Vector3 towards{0, 0, 1};
  std::shared_ptr<const ParallelView> shadow{};  ///< null: nothing shadows the sun
  double exponent = 1;
  LightTerms weights{};
  Colour product{0, 0, 0};                                    ///< light colour times paint
  Colour colour{1, 1, 1};                                     ///< of the light
  double residual = std::numeric_limits<double>::infinity();  ///< see EstimatedLight::error
  double median = 1;                                          ///< of the same differences
};

[[nodiscard]] inline double median_of(std::vector<double>& numbers) {
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

/// Normal equations of the terms' weights and of steps of two channels of a colour; the third makes the
/// opposite step of both.
struct LightEquations {
  static constexpr std::size_t unknowns = light_terms + 2;
  /// First unknown of each group that a point's channels share factors of, and the end.
  static constexpr std::array<std::size_t, 5> groups{0, body_terms, light_terms, light_terms + 1, unknowns};
  using Unknowns = std::array<double, unknowns>;
  std::array<Unknowns, unknowns> product{};  ///< below and on the diagonal
  Unknowns right{};

  /// Adds Σ_c counts[c] · (Σ_g factors[g][c] · row_g·x_g − target[c])².
  void add(const LightTerms& terms, const std::array<Colour, 4>& factors, const Colour& target,
           const Colour& counts) {
    Unknowns row;
    std::copy(terms.begin(), terms.end(), row.begin());
    row[light_terms] = row[light_terms + 1] = 1;
    for (std::size_t g = 0; g < 4; ++g)
      for (std::size_t h = 0; h <= g; ++h) {
        double square = 0, mixed = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          square += counts[c] * factors[g][c] * factors[h][c];
          mixed += counts[c] * factors[g][c] * target[c];
        }
        for (std::size_t i = groups[g]; i < groups[g + 1]; ++i) {
          if (h == 0) right[i] += mixed * row[i];
          const double counted = square * row[i];
          for (std::size_t j = groups[h]; j < groups[h + 1]; ++j) product[i][j] += counted * row[j];
        }
      }
  }

  /// Draws what no point decides to 0: the sky's shape, the surroundings' around z and, weakly, by height.
  /// The less the better the points are explained. \param residual  mean difference of the points
  void regularise(double residual) {
    const double pull = std::min(1.0, residual / 0.07), least = 1e-6;
    const double shape = 0.05 * pull, around = 0.1 * pull, weak = 1e-3 * pull, band = 0.01 * pull;
    double trace = 0;
    for (std::size_t i = 0; i < unknowns; ++i) trace += product[i][i];
    const double sky = product[1][1], mirrored = product[body_terms][body_terms];
    for (std::size_t i = 0; i < unknowns; ++i) product[i][i] += least * trace / unknowns;
    for (std::size_t k = 1; k < 9; ++k) {
      product[1 + k][1 + k] += shape * sky;
      product[body_terms + k][body_terms + k] += (k == 2 || k == 6 ? weak : around) * mirrored;
    }
    for (std::size_t k = body_terms + 9; k + 1 < light_terms; ++k) product[k][k] += band * mirrored;
  }

  /// The solution, with a sun and a glint of at least 0.
  [[nodiscard]] Unknowns solution() {
    auto x = solved();
    for (const std::size_t term : {std::size_t{0}, light_terms - 1}) {
      if (!(x[term] < 0)) continue;
      right[term] = 0;
      for (std::size_t i = 0; i < unknowns; ++i) product[std::max(i, term)][std::min(i, term)] = i == term;
      x = solved();
    }
    return x;
  }

 private:
  /// By Cholesky's factors, L·Lᵀ, and both triangles in turn.
  [[nodiscard]] Unknowns solved() const {
    auto factor = product;
    Unknowns x = right;
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        for (std::size_t k = 0; k < j; ++k) factor[i][j] -= factor[i][k] * factor[j][k];
        factor[i][j] = i == j ? std::sqrt(std::max(factor[i][i], 1e-30)) : factor[i][j] / factor[j][j];
        if (j < i) x[i] -= factor[i][j] * x[j];
      }
      x[i] /= factor[i][i];
    }
    for (std::size_t i = unknowns; i-- > 0; x[i] /= factor[i][i])
      for (std::size_t k = i + 1; k < unknowns; ++k) x[i] -= factor[k][i] * x[k];
    return x;
  }
};

/// Points of photographs, with all that does not depend on the sun.
class LightFit {
 public:
  LightFit(std::vector<LitPoint> points, const std::optional<Colour>& paint)
      : points_(std::move(points)), paint_(paint) {
    Colour sum = paint.value_or(Colour{0, 0, 0});
    for (const LitPoint& point : points_) {
      Terms& terms = terms_.emplace_back(Terms{coated_point(point.normal, point.to_eye), {}, {}});
      const Harmonics sky = sky_transfer(point.normal), mirrored = spherical_harmonics(terms.coat.mirrored);
      const HeightBands bands = height_bands(terms.coat.mirrored[2]);
      std::copy(sky.begin(), sky.end(), terms.row.begin() + 1);
      std::copy(mirrored.begin(), mirrored.end(), terms.row.begin() + body_terms);
      std::copy(bands.begin(), bands.end(), terms.row.begin() + body_terms + 9);
      for (double& term : terms.row) term *= point.open;
      for (std::size_t c = 0; c < 3; ++c) terms.encoded[c] = image::encoded(point.colour[c]);
      if (!paint) sum = geometry::add(sum, point.colour);
    }
    const double mean = (sum[0] + sum[1] + sum[2]) / 3;
    if (mean > 0) start_ = geometry::scale(sum, paint ? 1 : 1 / mean);
  }

  [[nodiscard]] const std::vector<LitPoint>& points() const { return points_; }

  /// Fits everything else to a candidate's sun and exponent, in rounds of least squares.
  void fit(LightCandidate& candidate, int rounds) const {
    const auto rows = rows_of(candidate);
    candidate.colour = {1, 1, 1};
    candidate.product = start_;
    std::vector<Colour> counts(points_.size());
    for (std::size_t p = 0; p < points_.size(); ++p)
      for (std::size_t c = 0; c < 3; ++c) counts[p][c] = points_[p].colour[c] < 1 ? 1 : 0;
    candidate.weights = {};
    candidate.median = 1;
    for (int round = 0; round < rounds; ++round) {
      for (int turn = 0; turn < 2; ++turn) improve(rows, counts, candidate);
      judge(rows, candidate, counts);
    }
  }

  /// Light on the paint and light in the coat of each point, before their colours.
  [[nodiscard]] std::vector<std::array<double, 2>> shadings(const LightCandidate& candidate) const {
    std::vector<std::array<double, 2>> both;
    for (const LightTerms& row : rows_of(candidate)) both.push_back(shading(row, candidate.weights));
    return both;
  }

  /// Colour of a point of these shadings.
  [[nodiscard]] static Colour modelled(const Colour& product, const Colour& light,
                                       const std::array<double, 2>& shading) {
    return geometry::add(geometry::scale(product, shading[0]), geometry::scale(light, shading[1]));
  }

  /// Mean absolute difference of encoded channels; what lies beyond a bound adds nothing.
  [[nodiscard]] static double difference(const Colour& model, const Colour& photo) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::abs(image::encoded(std::clamp(model[c], 0.0, 1.0)) - image::encoded(photo[c])) / 3;
    return sum;
  }

 private:
  struct Terms {
    CoatedPoint coat;
    LightTerms row;  ///< without sun, glint and the coat's share
    Colour encoded;  ///< the photograph's
  };

  [[nodiscard]] std::vector<LightTerms> rows_of(const LightCandidate& candidate) const {
    std::vector<LightTerms> rows(points_.size());
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const LitPoint& point = points_[p];
      const CoatedPoint& coat = terms_[p].coat;
      const double fresnel =
          clear_coat_f0 + (1 - clear_coat_f0) * std::pow(1 - coat.n_dot_v, candidate.exponent);
      const double cosine = geometry::dot(point.normal, candidate.towards);
      double lit = cosine > 0 ? 1 : 0;
      if (lit > 0 && candidate.shadow) lit = candidate.shadow->visible_share(point.face, point.point);
      LightTerms& row = rows[p] = terms_[p].row;
      row[0] = lit * std::max(0.0, cosine);
      for (std::size_t i = 0; i < light_terms; ++i) row[i] *= i < body_terms ? 1 - fresnel : fresnel;
      if (lit > 0)
        row[light_terms - 1] = lit * ggx_reflection(point.normal, point.to_eye, candidate.towards,
                                                    coat.n_dot_v, glint_alpha, clear_coat_f0)
                                         .value;
    }
    return rows;
  }

  [[nodiscard]] static std::array<double, 2> shading(const LightTerms& row, const LightTerms& weights) {
    double sun = row[0] * weights[0], sky = 0, mirrored = 0;
    for (std::size_t k = 1; k < body_terms; ++k) sky += row[k] * weights[k];
    for (std::size_t k = body_terms; k + 1 < light_terms; ++k) mirrored += row[k] * weights[k];
    return {sun + std::max(0.0, sky),
            std::max(0.0, mirrored) + row[light_terms - 1] * weights[light_terms - 1]};
  }

  /// One step of Gauss and Newton: the terms' weights, and the colour of the paint or, if that is known, of
  /// the light, of mean 1.
  void improve(const std::vector<LightTerms>& rows, const std::vector<Colour>& counts,
               LightCandidate& candidate) const {
    LightEquations equations;
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const auto [body, coat] = shading(rows[p], candidate.weights);
      Colour by;  // derivative by the colour
      for (std::size_t c = 0; c < 3; ++c) by[c] = paint_ ? (*paint_)[c] * body + coat : body;
      equations.add(rows[p], {candidate.product, candidate.colour, {by[0], 0, -by[2]}, {0, by[1], -by[2]}},
                    points_[p].colour, counts[p]);
    }
    equations.regularise(candidate.median);
    const auto x = equations.solution();
    const Colour step{x[light_terms], x[light_terms + 1], -x[light_terms] - x[light_terms + 1]};
    Colour& colour = paint_ ? candidate.colour : candidate.product;
    colour = geometry::add(colour, step);
    for (double& channel : colour) channel = std::max(0.0, channel);
    const double mean = (colour[0] + colour[1] + colour[2]) / 3;
    colour = geometry::scale(colour, 1 / mean);
    for (std::size_t i = 0; i < light_terms; ++i)
      candidate.weights[i] = x[i] * (paint_ || i < body_terms ? mean : 1);
    for (std::size_t c = 0; c < 3 && paint_; ++c) candidate.product[c] = colour[c] * (*paint_)[c];
  }

  /// Weighs the points by their differences: least squares with weights slope² / difference are least
  /// absolute differences of encoded colours. A bound that the model keeps counts nothing.
  void judge(const std::vector<LightTerms>& rows, LightCandidate& candidate,
             std::vector<Colour>& counts) const {
    constexpr double least = 1.0 / 255, darkest = 0.003;
    std::vector<double> differences;
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const Colour model = modelled(candidate.product, candidate.colour, shading(rows[p], candidate.weights));
      const Colour& photo = points_[p].colour;
      Colour encoded;
      double off = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        encoded[c] = image::encoded(std::clamp(model[c], 0.0, 1.0));
        off += std::abs(encoded[c] - terms_[p].encoded[c]) / 3;
      }
      differences.push_back(off);
      for (std::size_t c = 0; c < 3; ++c) {
        const double slope = image::encoded_slope(std::clamp(std::max(model[c], photo[c]), darkest, 1.0),
                                                  std::max(encoded[c], terms_[p].encoded[c]));
        counts[p][c] = photo[c] >= 1 && model[c] >= 1 ? 0 : slope * slope / std::max(least, off);
      }
    }
    candidate.residual = std::accumulate(differences.begin(), differences.end(), 0.0) /
                         static_cast<double>(differences.size());
    candidate.median = median_of(differences);
  }

  std::vector<LitPoint> points_;
  std::optional<Colour> paint_;
  std::vector<Terms> terms_;
  Colour start_{1, 1,
                1};  ///< light times paint before the first round: of the points' sum, or of white light
};
}  // namespace tapestry::raster::detail
