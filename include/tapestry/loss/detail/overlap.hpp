#pragma once
#include <tapestry/core/compiled.hpp>
#include <tapestry/detect/box_overlap.hpp>  // Box

namespace tapestry::loss {
namespace detail {

void add(detect::Box& sum, const detect::Box& term, double scale);

}  // namespace detail

/// Intersection over union of a predicted box and a target, with its gradient.
struct Overlap {
  double iou = 0;
  detect::Box gradient{0, 0, 0, 0};  ///< ∂iou/∂box; the target is a constant
};

/// IoU and its gradient to the box: with I the area shared and U = wh + w'h' − I,
///
///   ∂IoU/∂x = ((1 + IoU) · ∂I/∂x − IoU · ∂(wh)/∂x) / U
///
/// Boxes that only touch, a box without area, and a box too large to have a finite area: IoU 0, gradient 0.
/// Where two edges coincide the gradient is the mean of its two one-sided values. A NaN box gives NaN.
[[nodiscard]] Overlap iou_with_gradient(const detect::Box& box, const detect::Box& target);

/// Complete IoU and its gradient.
struct CompleteOverlap {
  double iou = 0;
  double distance = 0;  ///< squared distance of the centres over the squared diagonal of the hull
  double aspect = 0;    ///< v = 4/π² · (atan(w'/h') − atan(w/h))²
  double alpha = 0;     ///< weight of v, a constant in the gradient
  detect::Box gradient{0, 0, 0, 0};  ///< ∂(iou − distance − alpha·aspect)/∂box with alpha held fixed

  [[nodiscard]] double value() const { return iou - distance - alpha * aspect; }
};

/// CIoU = IoU − ρ²/c² − αv with α = v / (1 − IoU + v), and 0 where v = 0. Unlike IoU it also differs between
/// boxes that do not meet; it lies in (−1.5, 1].
///
/// A box without area or too large to be measured has CIoU 0 and gradient 0; coinciding edges and NaN as
/// in iou_with_gradient(). Source: Zheng et al., "Distance-IoU loss" (AAAI 2020), eq. 7 to 12; α is not
/// differentiated, as there.
[[nodiscard]] CompleteOverlap complete_iou(const detect::Box& box, const detect::Box& target);

}  // namespace tapestry::loss
