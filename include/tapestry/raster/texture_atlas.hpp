#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {
namespace detail {

/// A coordinate brought into [0, extent] by whole multiples of extent. The closed interval itself is left
/// alone, so that a chart that ends at the right or upper border does not jump to the other side; a
/// billionth beyond it, as rounding may cause, is taken as on it.
inline double wrapped(double coordinate, double extent) {
  const double slack = 1e-9 * extent;
  if (coordinate < -slack || coordinate > extent + slack)
    coordinate -= extent * std::floor(coordinate / extent);
  return std::clamp(coordinate, 0.0, extent);
}

/// Two neighbouring indices along an axis and the weight of the second.
struct AxisTaps {
  std::size_t first;
  std::size_t second;
  double share;

  AxisTaps(double position, std::size_t size) {
    const double clamped = std::clamp(position, 0.0, static_cast<double>(size - 1));
    first = static_cast<std::size_t>(static_cast<std::int64_t>(clamped));  // quicker than at once
    second = std::min(first + 1, size - 1);
    share = clamped - static_cast<double>(first);
  }
};

}  // namespace detail

/// Bilinear lookup in a picture: calls visit(Tap) up to four times, with weights that sum to 1.
/// \param u, v  in [0, 1]; v = 1 is the top
template <class Visit>
void visit_picture_taps(std::size_t height, std::size_t width, double u, double v, Visit visit) {
  const detail::AxisTaps column(u * static_cast<double>(width) - 0.5, width);
  const detail::AxisTaps row((1 - v) * static_cast<double>(height) - 0.5, height);
  const auto tap = [&](std::size_t i, std::size_t j, double weight) {
    if (weight > 0) visit(Tap{i * width + j, weight});
  };
  tap(row.first, column.first, (1 - row.share) * (1 - column.share));
  tap(row.first, column.second, (1 - row.share) * column.share);
  tap(row.second, column.first, row.share * (1 - column.share));
  tap(row.second, column.second, row.share * column.share);
}

/// Bilinear lookup in an atlas: calls visit(Tap) up to four times, with weights that sum to 1.
///
/// Texel (row i, column j) has its centre at u = (j + ½)·u_extent/width, v = 1 − (i + ½)/height. uv
/// outside [0, u_extent] × [0, 1] repeats; within the outer half texel the border texel is used alone
/// (opposite borders do not mix).
template <class Visit>
void visit_atlas_taps(const TextureLayout& layout, const std::array<double, 2>& uv, Visit visit) {
  visit_picture_taps(layout.height, layout.width, detail::wrapped(uv[0], layout.u_extent) / layout.u_extent,
                     detail::wrapped(uv[1], 1), visit);
}

}  // namespace tapestry::raster
