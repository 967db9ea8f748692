#include <tapestry/loss/prediction.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using detect::Box;

namespace {
Box box_of(const Array<double, 1>& values) { return {values(0), values(1), values(2), values(3)}; }

double along(const Box& gradient, const Array<double, 1>& direction) {
  return gradient.cx * direction(0) + gradient.cy * direction(1) + gradient.w * direction(2) +
         gradient.h * direction(3);
}

bool is_zero(const Box& box) { return box.cx == 0 && box.cy == 0 && box.w == 0 && box.h == 0; }

const Box target{3.0, 2.0, 2.0, 1.0};
}  // namespace

TEST_CASE("iou_with_gradient equals the area shared worked out by hand", "[loss][overlap]") {
  // Two boxes 2 × 1 shifted by 1 to the right share 1 of 3; a shift to the right by d shares (1 − d) of (3 +
  // d).
  const auto overlap = loss::iou_with_gradient({4.0, 2.0, 2.0, 1.0}, target);
  CHECK(overlap.iou == Approx(1.0 / 3));
  CHECK(overlap.gradient.cx == Approx(-4.0 / 9));
  CHECK(overlap.iou == Approx(detect::iou({4.0, 2.0, 2.0, 1.0}, target)));
}

TEST_CASE("complete_iou equals the terms worked out by hand", "[loss][overlap]") {
  // A square 1 × 1 around a point 1 to the right of the target's centre: hull [2, 4] × [1.5, 2.5].
  const auto overlap = loss::complete_iou({4.0, 2.0, 1.0, 1.0}, target);
  CHECK(overlap.iou == Approx(0.5 / 2.5));
  CHECK(overlap.distance == Approx(1.0 / (2.5 * 2.5 + 1.0)));
  const double turn = std::atan(2.0) - std::atan(1.0);
  CHECK(overlap.aspect == Approx(4 / (M_PI * M_PI) * turn * turn));
  CHECK(overlap.alpha == Approx(overlap.aspect / (0.8 + overlap.aspect)));
  CHECK(loss::complete_iou(target, target).value() == 1.0);
}

TEST_CASE("overlap gradients agree with central differences", "[loss][overlap][gradient]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    auto values = test::random_array<double>({4}, seed, 0.4, 2.4);
    values(0) += 1.6;
    const auto direction = test::random_direction<double>({4}, seed + 1000);
    const auto overlap = loss::iou_with_gradient(box_of(values), target);
    const auto iou = [&](const auto& v) { return loss::iou_with_gradient(box_of(v), target).iou; };
    const double tolerance = 25 * test::central_difference_tolerance(1.0);  // third derivatives up to 6/w³
    CAPTURE(seed, overlap.iou);
    CHECK(std::abs(along(overlap.gradient, direction) - test::central_difference(iou, values, direction)) <=
          tolerance);

    const auto complete = loss::complete_iou(box_of(values), target);
    const auto with_alpha_fixed = [&](const auto& v) {
      const auto moved = loss::complete_iou(box_of(v), target);
      return moved.iou - moved.distance - complete.alpha * moved.aspect;
    };
    CHECK(std::abs(along(complete.gradient, direction) -
                   test::central_difference(with_alpha_fixed, values, direction)) <= tolerance);
  }
}

TEST_CASE("overlap is symmetric under a shift and a change of units", "[loss][overlap]") {
  const Box box{2.5, 2.25, 1.5, 2.0};
  const auto overlap = loss::complete_iou(box, target);
  const auto scaled = loss::complete_iou({4 * box.cx + 8, 4 * box.cy - 16, 4 * box.w, 4 * box.h},
                                         {4 * target.cx + 8, 4 * target.cy - 16, 4 * target.w, 4 * target.h});
  CHECK(scaled.value() == Approx(overlap.value()).epsilon(1e-14));
  CHECK(scaled.gradient.w == Approx(overlap.gradient.w / 4).epsilon(1e-13));
}

TEST_CASE("a box equal to the target has IoU 1 and no gradient", "[loss][overlap]") {
  const auto overlap = loss::iou_with_gradient(target, target);
  CHECK(overlap.iou == 1.0);
  CHECK(is_zero(overlap.gradient));
}

TEST_CASE("boxes that touch, miss, are degenerate or immense have IoU 0 and no gradient", "[loss][overlap]") {
  const double huge = std::exp(700.0);
  for (const Box& box :
       {Box{5.0, 2.0, 2.0, 1.0}, Box{9.0, 9.0, 1.0, 1.0}, Box{3.0, 2.0, 0.0, 1.0}, Box{3.0, 2.0, 1.0, -1.0},
        Box{3.0, 2.0, huge, huge}, Box{3.0, 2.0, std::numeric_limits<double>::infinity(), 1.0}}) {
    const auto overlap = loss::iou_with_gradient(box, target);
    CHECK(overlap.iou == 0.0);
    CHECK(is_zero(overlap.gradient));
    CHECK(std::isfinite(loss::complete_iou(box, target).value()));
  }
  const auto large = loss::iou_with_gradient({3.0, 2.0, 2.7e43, 2.7e43}, target);  // e^100: measurable
  CHECK(large.iou > 0);
  CHECK(std::isfinite(large.gradient.w));
  CHECK(is_zero(loss::complete_iou({3.0, 2.0, huge, huge}, target).gradient));
  CHECK(loss::iou_with_gradient(target, {3.0, 2.0, 0.0, 0.0}).iou == 0.0);
}

TEST_CASE("overlap passes NaN on", "[loss][overlap]") {
  const Box box{3.0, std::nan(""), 2.0, 1.0};
  CHECK(std::isnan(loss::iou_with_gradient(box, target).iou));
  CHECK(std::isnan(loss::complete_iou(box, target).value()));
  CHECK(std::isnan(loss::complete_iou(box, target).gradient.w));
}
