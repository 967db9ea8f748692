#pragma once
#include <algorithm>
#include <cmath>

namespace tapestry::detect {
/// Axis-aligned box by its centre and extents, all in one unit, usually pixels of the network's input.
struct Box {
  double cx = 0;
  double cy = 0;
  double w = 0;
  double h = 0;

  [[nodiscard]] double left() const { return cx - w / 2; }
  [[nodiscard]] double top() const { return cy - h / 2; }
  [[nodiscard]] double right() const { return cx + w / 2; }
  [[nodiscard]] double bottom() const { return cy + h / 2; }
  [[nodiscard]] double area() const { return w > 0 && h > 0 ? w * h : 0; }
};

/// The box with the given edges.
[[nodiscard]] inline Box box_from_corners(double left, double top, double right, double bottom) {
  return {(left + right) / 2, (top + bottom) / 2, right - left, bottom - top};
}

/// Part of a box inside another; of extents 0 if they do not meet.
[[nodiscard]] inline Box clipped(const Box& box, const Box& frame) {
  const double left = std::max(box.left(), frame.left());
  const double top = std::max(box.top(), frame.top());
  return box_from_corners(left, top, std::max(left, std::min(box.right(), frame.right())),
                          std::max(top, std::min(box.bottom(), frame.bottom())));
}

/// Area that two boxes share; 0 when they only touch, and for boxes without area or with a NaN.
[[nodiscard]] inline double intersection(const Box& a, const Box& b) {
  const bool is_known = !std::isnan(a.cx + a.cy + b.cx + b.cy) && a.area() > 0 && b.area() > 0;
  if (!is_known) return 0;
  const double w = std::min(a.right(), b.right()) - std::max(a.left(), b.left());
  const double h = std::min(a.bottom(), b.bottom()) - std::max(a.top(), b.top());
  return w > 0 && h > 0 ? w * h : 0;
}

/// Intersection over union, in [0, 1]. Boxes without area, or with a NaN, overlap nothing: 0.
[[nodiscard]] inline double iou(const Box& a, const Box& b) {
  const double shared = intersection(a, b);
  const double united = a.area() + b.area() - shared;
  return shared > 0 && united > 0 ? std::min(1.0, shared / united) : 0;
}
}  // namespace tapestry::detect
