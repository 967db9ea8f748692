#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <numeric>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/neighbour_steps.hpp>
#include <tapestry/loss/printability.hpp>
#include <tapestry/loss/total_variation.hpp>
#include <utility>
#include <vector>

namespace tapestry::loss {

Array<double, 2> printable_colours() {
  constexpr std::array<double, 4> levels{0.05, 0.35, 0.65, 0.95};
  Array<double, 2> palette(Extents<2>{64, 3});
  for (std::size_t k = 0; k < 64; ++k) {
    palette(k, 0) = levels[k / 16];
    palette(k, 1) = levels[k / 4 % 4];
    palette(k, 2) = levels[k % 4];
  }
  return palette;
}

}  // namespace tapestry::loss

namespace tapestry::loss::detail {

double score_of(const std::array<double, 3>& colour, const Array<double, 2>& palette, double spread,
                std::array<double, 3>* slope) {
  const double two_variances = 2 * spread * spread;
  const auto squared_distance = [&](std::size_t k) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += (colour[c] - palette(k, c)) * (colour[c] - palette(k, c));
    return sum;
  };
  double nearest = squared_distance(0);
  for (std::size_t k = 1; k < palette.shape(0); ++k) nearest = std::min(nearest, squared_distance(k));
  double shares = 0;
  std::array<double, 3> mean{};  // mean of the palette, weighted by how near each colour is
  for (std::size_t k = 0; k < palette.shape(0); ++k) {
    const double share = std::exp((nearest - squared_distance(k)) / two_variances);  // 1 for the nearest
    shares += share;
    for (std::size_t c = 0; c < 3; ++c) mean[c] += share * palette(k, c);
  }
  if (slope != nullptr)
    for (std::size_t c = 0; c < 3; ++c) (*slope)[c] = 2 * (colour[c] - mean[c] / shares);
  return nearest - two_variances * std::log(shares / static_cast<double>(palette.shape(0)));
}

}  // namespace tapestry::loss::detail

namespace tapestry::loss {

template <std::floating_point T>
Variable<T> non_printability(const ArrayVariable<T, 2>& texels, std::shared_ptr<const Array<T, 2>> used,
                             std::shared_ptr<const Array<double, 2>> palette, double spread) {
  const T value = non_printability(texels.value(), *used, *palette, spread);
  const auto pullback = [at = texels.shared_value(), of_texels = std::move(used),
                         printable = std::move(palette), spread](T adjoint, Array<T, 2>* texels_adjoint) {
    non_printability_adjoint(*at, *of_texels, *printable, spread, adjoint, *texels_adjoint);
  };
  return record_scalar(value, pullback, texels);
}

template Variable<float> non_printability<float>(const ArrayVariable<float, 2>& texels,
                                                 std::shared_ptr<const Array<float, 2>> used,
                                                 std::shared_ptr<const Array<double, 2>> palette,
                                                 double spread);
template Variable<double> non_printability<double>(const ArrayVariable<double, 2>& texels,
                                                   std::shared_ptr<const Array<double, 2>> used,
                                                   std::shared_ptr<const Array<double, 2>> palette,
                                                   double spread);

template <std::floating_point T>
Variable<T> total_variation(const ArrayVariable<T, 3>& picture, Array<T, 2> mask, double epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, picture, std::move(mask));
}

template <std::floating_point T>
Variable<T> total_variation(const std::vector<ArrayVariable<T, 3>>& pictures, SharedMasks<T> masks,
                            double epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, pictures, std::move(masks));
}

template <std::floating_point T>
Variable<T> atlas_total_variation(const ArrayVariable<T, 2>& texels, std::shared_ptr<const Array<T, 2>> used,
                                  double epsilon) {
  const auto penalty = detail::absolute_step("atlas_total_variation", epsilon);
  return detail::record_atlas_steps("atlas_total_variation", penalty, texels, std::move(used));
}

template Variable<float> total_variation<float>(const ArrayVariable<float, 3>& picture, Array<float, 2> mask,
                                                double epsilon);
template Variable<double> total_variation<double>(const ArrayVariable<double, 3>& picture,
                                                  Array<double, 2> mask, double epsilon);
template Variable<float> total_variation<float>(const std::vector<ArrayVariable<float, 3>>& pictures,
                                                SharedMasks<float> masks, double epsilon);
template Variable<double> total_variation<double>(const std::vector<ArrayVariable<double, 3>>& pictures,
                                                  SharedMasks<double> masks, double epsilon);
template Variable<float> atlas_total_variation<float>(const ArrayVariable<float, 2>& texels,
                                                      std::shared_ptr<const Array<float, 2>> used,
                                                      double epsilon);
template Variable<double> atlas_total_variation<double>(const ArrayVariable<double, 2>& texels,
                                                        std::shared_ptr<const Array<double, 2>> used,
                                                        double epsilon);

}  // namespace tapestry::loss
