#pragma once
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::segment {
/// A rectangle of a picture, pixels: columns left ≤ x < right, rows alike; parts outside
/// the picture are left out.
struct Region {
  double left = 0, top = 0, right = 0, bottom = 0;
};

/// Finds the car in a mask of salient objects: one connected piece of the pixels that reach the threshold.
///
/// Pixels of at least `threshold` are joined with the four beside them. The car is the piece with most pixels
/// (their centres) in its region, and of equal ones the larger; without a region it is the largest piece. Of
/// pieces equal in both, the one whose first pixel comes first, row by row. A piece that does not reach into
/// the region is not the car. Pixels that are NaN belong to none. The choice has no derivative.
///
/// The rule and the threshold of 0.5 are ours: the paper states neither.
///
/// \param mask    [H, W], in [0, 1]
/// \param region  around the car, from a label; none if it is not known
/// \returns       [H, W], 1 on the car and 0 elsewhere; all 0 if there is none
[[nodiscard]] Array<std::uint8_t, 2> car_component(const Array<float, 2>& mask,
                                                   const std::optional<Region>& region = {},
                                                   double threshold = 0.5);

/// Intersection over union of two masks, each counted where it is not 0; 1 if both are empty.
/// \throws ShapeError unless they have the same extents
[[nodiscard]] double mask_iou(const Array<std::uint8_t, 2>& a, const Array<std::uint8_t, 2>& b);
}  // namespace tapestry::segment
