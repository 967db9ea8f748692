#pragma once
#include <tapestry/loss/detail/responsible.hpp>

namespace tapestry::loss {
namespace detail {
ClassCost::ClassCost(double class_logit, std::optional<double> objectness_logit) {
  constexpr double most = 100;
  if_present = softplus(-class_logit);
  if (objectness_logit) if_present = (if_present + softplus(-*objectness_logit)) / 2;
  if_absent = std::min(most, -std::log(-std::expm1(-if_present)));
  if_present = std::min(most, if_present);
}

void require_free_heads(const char* operation, const std::vector<detect::Head>& heads) {
  for (const auto& head : heads)
    if (detect::has_anchors(head.decode) || head.decode == detect::DecodeFamily::decoded)
      throw DomainError({operation, ": heads of the decode family ", detect::name_of(head.decode),
                         ", whose candidates are no cells without anchors; expected yolox or distance"});
}

void add(detect::Box& sum, const detect::Box& term, double scale) {
  sum.cx += scale * term.cx;
  sum.cy += scale * term.cy;
  sum.w += scale * term.w;
  sum.h += scale * term.h;
}
}  // namespace detail

Overlap iou_with_gradient(const detect::Box& box, const detect::Box& target) {
  if (detail::has_nan(box)) return {std::nan(""), {std::nan(""), std::nan(""), std::nan(""), std::nan("")}};
  if (!detail::is_measurable(box, target)) return {};
  const detail::AxisOverlap x(box.cx, box.w, target.cx, target.w);
  const detail::AxisOverlap y(box.cy, box.h, target.cy, target.h);
  if (!(x.shared > 0 && y.shared > 0)) return {};
  const double shared = x.shared * y.shared;
  const double united = box.w * box.h + target.w * target.h - shared;
  const double iou = shared / united;
  const auto slope = [&](double shared_slope, double area_slope) {
    return ((1 + iou) * shared_slope - iou * area_slope) / united;
  };
  return {iou,
          {slope(x.shared_by_centre * y.shared, 0), slope(y.shared_by_centre * x.shared, 0),
           slope(x.shared_by_extent * y.shared, box.h), slope(y.shared_by_extent * x.shared, box.w)}};
}

CompleteOverlap complete_iou(const detect::Box& box, const detect::Box& target) {
  const Overlap overlap = iou_with_gradient(box, target);
  if (!detail::has_nan(box) && !detail::is_measurable(box, target)) return {};
  const detail::AxisOverlap x(box.cx, box.w, target.cx, target.w);
  const detail::AxisOverlap y(box.cy, box.h, target.cy, target.h);
  const double diagonal = x.hull * x.hull + y.hull * y.hull;
  const double dx = box.cx - target.cx, dy = box.cy - target.cy;
  CompleteOverlap result{overlap.iou, (dx * dx + dy * dy) / diagonal, 0, 0, overlap.gradient};

  constexpr double scale = 4 / (3.14159265358979323846 * 3.14159265358979323846);
  const double turn = std::atan(target.w / target.h) - std::atan(box.w / box.h);
  result.aspect = scale * turn * turn;
  result.alpha = result.aspect == 0 ? 0 : result.aspect / (1 - result.iou + result.aspect);

  const auto hull_slope = [&](double by_centre_or_extent, double hull) {
    return result.distance * 2 * hull * by_centre_or_extent / diagonal;
  };
  const double squared = box.w * box.w + box.h * box.h;
  const double turn_slope =
      result.alpha * scale * 2 * turn / squared;  // d atan(w/h) = (h dw − w dh) / (w² + h²)
  detail::add(result.gradient,
              {2 * dx / diagonal - hull_slope(x.hull_by_centre, x.hull),
               2 * dy / diagonal - hull_slope(y.hull_by_centre, y.hull),
               -hull_slope(x.hull_by_extent, x.hull) - turn_slope * box.h,
               -hull_slope(y.hull_by_extent, y.hull) + turn_slope * box.w},
              -1);
  return result;
}
}  // namespace tapestry::loss
