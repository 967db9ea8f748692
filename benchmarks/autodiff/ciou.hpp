#pragma once
#include <numbers>
#include "seeded.hpp"

namespace tapestry::benchmarks {
/// Σ of the complete-IoU loss of 10,000 pairs of boxes (cx, cy, w, h):
///
///   1 − IoU + d² / c² + α·v,  v = 4/π² · (atan(wt / ht) − atan(w / h))²,  α = v / (1 − IoU + v),
///
/// where d is the distance of the centres and c the diagonal of the smallest box around both. Source: Zheng
/// et al., Distance-IoU Loss (AAAI 2020), where α is held constant; here it is differentiated, too.
struct Ciou {
  static constexpr const char* name = "ciou";
  static constexpr std::size_t boxes = 10000;
  static constexpr double aspect_scale = 4 / (std::numbers::pi * std::numbers::pi);
  std::vector<double> truth = uniform(4 * boxes, .3, .7, 31);
  [[nodiscard]] static std::vector<double> start() { return uniform(4 * boxes, .3, .7, 32); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t i = 0; i < boxes; ++i) {
      const S* const b = x + 4 * i;
      const double* const g = truth.data() + 4 * i;
      S inside = 1, diagonal = 0;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const S low = b[axis] - b[axis + 2] / 2., high = b[axis] + b[axis + 2] / 2.;
        const double other_low = g[axis] - g[axis + 2] / 2, other_high = g[axis] + g[axis + 2] / 2;
        const S overlap = smaller<S>(high, S(other_high)) - larger<S>(low, S(other_low));
        const S around = larger<S>(high, S(other_high)) - smaller<S>(low, S(other_low));
        inside *= larger<S>(overlap, S(0.));
        diagonal += around * around;
      }
      const S iou = inside / (b[2] * b[3] + g[2] * g[3] - inside);
      const S dx = b[0] - g[0], dy = b[1] - g[1];
      const S angle = std::atan(g[2] / g[3]) - atan(b[2] / b[3]);
      const S v = aspect_scale * angle * angle;
      total += 1. - iou + (dx * dx + dy * dy) / diagonal + v * v / (1. - iou + v);
    }
    return total;
  }
};

template <class T>
T hand_adjoint(const Ciou& ciou, const T* x, T* gradient) {
  T total = 0;
  for (std::size_t i = 0; i < Ciou::boxes; ++i) {
    const T* const b = x + 4 * i;
    T g[4], overlap[2], around[2], overlap_high[2], overlap_low[2], around_high[2], around_low[2];
    for (std::size_t k = 0; k < 4; ++k) g[k] = static_cast<T>(ciou.truth[4 * i + k]);
    for (std::size_t a = 0; a < 2; ++a) {
      const T low = b[a] - b[a + 2] / 2, high = b[a] + b[a + 2] / 2;
      const T other_low = g[a] - g[a + 2] / 2, other_high = g[a] + g[a + 2] / 2;
      const bool is_inner_high = high<other_high, is_inner_low = low> other_low;
      const T shared = (is_inner_high ? high : other_high) - (is_inner_low ? low : other_low);
      overlap[a] = shared > 0 ? shared : 0;
      around[a] = (is_inner_high ? other_high : high) - (is_inner_low ? other_low : low);
      overlap_high[a] = shared > 0 && is_inner_high ? T(1) : T(0);
      overlap_low[a] = shared > 0 && is_inner_low ? T(-1) : T(0);
      around_high[a] = is_inner_high ? T(0) : T(1);
      around_low[a] = is_inner_low ? T(0) : T(-1);
    }
    const T inside = overlap[0] * overlap[1];
    const T both = b[2] * b[3] + g[2] * g[3] - inside;
    const T iou = inside / both;
    const T d[2] = {b[0] - g[0], b[1] - g[1]};
    const T diagonal = around[0] * around[0] + around[1] * around[1];
    const T distance = (d[0] * d[0] + d[1] * d[1]) / diagonal;
    const T angle = std::atan(g[2] / g[3]) - std::atan(b[2] / b[3]);
    const T v = static_cast<T>(Ciou::aspect_scale) * angle * angle;
    const T rest = 1 - iou + v;
    total += 1 - iou + distance + v * v / rest;

    const T share = v / rest;
    const T iou_g = share * share - 1;
    const T angle_g = 2 * static_cast<T>(Ciou::aspect_scale) * angle * share * (2 - share);
    const T inside_g = iou_g * (both + inside) / (both * both), area_g = -iou_g * inside / (both * both);
    const T squared = b[2] * b[2] + b[3] * b[3];
    T* const out = gradient + 4 * i;
    for (std::size_t a = 0; a < 2; ++a) {
      const T overlap_g = inside_g * overlap[1 - a], around_g = -2 * distance * around[a] / diagonal;
      const T high_g = overlap_g * overlap_high[a] + around_g * around_high[a];
      const T low_g = overlap_g * overlap_low[a] + around_g * around_low[a];
      out[a] = high_g + low_g + 2 * d[a] / diagonal;
      out[a + 2] = (high_g - low_g) / 2 + area_g * b[3 - a];
    }
    out[2] -= angle_g * b[3] / squared;
    out[3] += angle_g * b[2] / squared;
  }
  return total;
}
}  // namespace tapestry::benchmarks
