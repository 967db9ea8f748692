#pragma once
#include <array>
#include <tapestry/core/compiled.hpp>

namespace tapestry::geometry {

/// A point of a plane.
using Vector2 = std::array<double, 2>;

/// Whether a, b, c turn to the left (1), to the right (−1) or lie on one line (0): the sign of
///
///   (b − a) × (c − a) = aₓb_y − a_ybₓ + bₓc_y − b_ycₓ + cₓa_y − c_yaₓ
///
/// without rounding, as long as no product leaves the range of normal doubles (coordinates that are 0 or from
/// 1e-130 to 1e130 are safe). Where rounding cannot change the sign, it costs two products.
/// Source of the bound: Shewchuk (1997), figure 21.
///
/// \param a,b,c  points of a plane, any unit
[[nodiscard]] int orientation(const Vector2& a, const Vector2& b, const Vector2& c);

}  // namespace tapestry::geometry
