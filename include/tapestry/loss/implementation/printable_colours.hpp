#pragma once
#include <tapestry/loss/printability.hpp>

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
