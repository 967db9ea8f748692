#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/detail/transform/matrix3.hpp>

namespace tapestry::image {
/// colour ↦ matrix · colour + offset, then clipped to 0 … 1: contrast, saturation and hue of a camera; or the
/// blacks, whites and colour error of a printer, for the texels of a paint.
struct ColourChange {
  Matrix3<double> matrix = identity3;
  std::array<double, 3> offset{};
};

/// Contrast about mid grey, and saturation about the luma of ITU-R BT.601; 1 leaves either unchanged.
[[nodiscard]] ColourChange contrast_and_saturation(double contrast, double saturation);

namespace detail {
/// Calls body(y) for every row of a picture, from several threads.
template <class Body>
void for_each_row(std::size_t rows, Body body) {
  constexpr std::size_t rows_a_block = 16;
  parallel_for_blocks(rows, rows_a_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) body(y);
  });
}

template <std::floating_point T, std::size_t Rank>
void require_colours(const char* operation, const Array<T, Rank>& colours) {
  if (colours.shape(Rank - 1) != 3)
    throw ShapeError({operation, ": ", colours.shape(Rank - 1), " channels, expected 3"});
}

/// Calls visit(i) for the first number of each colour, from several threads.
template <class Visit>
void for_each_colour(std::size_t numbers, Visit visit) {
  constexpr std::size_t size = 3 * 4096;
  parallel_for_blocks(numbers, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += 3) visit(i);
  });
}

template <std::floating_point T>
[[nodiscard]] std::array<T, 3> changed_before_cut(const Matrix3<T>& matrix, const std::array<T, 3>& offset,
                                                  const T* colour) {
  auto value = product(matrix, {colour[0], colour[1], colour[2]});
  for (std::size_t c = 0; c < 3; ++c) value[c] += offset[c];
  return value;
}

template <std::floating_point T>
[[nodiscard]] std::array<T, 3> offset_of(const ColourChange& change) {
  return {static_cast<T>(change.offset[0]), static_cast<T>(change.offset[1]),
          static_cast<T>(change.offset[2])};
}
}  // namespace detail

/// \param colours  [..., 3]: a picture or texels
/// \returns        of the same extents, in [0, 1]
/// \throws ShapeError if there are not three channels
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> transformed(const Array<T, Rank>& colours, const ColourChange& change) {
  detail::require_colours("transformed", colours);
  const auto matrix = scaled<T>(change.matrix);
  const auto offset = detail::offset_of<T>(change);
  Array<T, Rank> out(colours.shape());
  detail::for_each_colour(colours.size(), [&](std::size_t i) {
    const auto value = detail::changed_before_cut<T>(matrix, offset, colours.data() + i);
    for (std::size_t c = 0; c < 3; ++c) out.data()[i + c] = std::clamp(value[c], T(0), T(1));
  });
  return out;
}

/// Adds the derivatives of transformed() to `colours_adjoint`; clipped channels have none.
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T, std::size_t Rank>
void transformed_adjoint(const Array<T, Rank>& colours, const ColourChange& change,
                         const Array<T, Rank>& out_adjoint, Array<T, Rank>& colours_adjoint) {
  detail::require_colours("transformed_adjoint", colours);
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, colours.shape());
  require_shape("transformed_adjoint", "colours_adjoint", colours_adjoint, colours.shape());
  const auto matrix = scaled<T>(change.matrix), back = transposed(matrix);
  const auto offset = detail::offset_of<T>(change);
  detail::for_each_colour(colours.size(), [&](std::size_t i) {
    auto adjoint = detail::changed_before_cut<T>(matrix, offset, colours.data() + i);
    for (std::size_t c = 0; c < 3; ++c)
      adjoint[c] = adjoint[c] >= 0 && adjoint[c] <= 1 ? out_adjoint.data()[i + c] : T(0);
    const auto pulled_back = product(back, adjoint);
    for (std::size_t c = 0; c < 3; ++c) colours_adjoint.data()[i + c] += pulled_back[c];
  });
}

/// Another exposure, another colour of the light, and the soft edge of a shadow across the picture.
///
/// Light is multiplied, not its code in the picture: a gain g of light is a gain g^(1/2.2) of encoded values.
/// The power 2.2 approximates the sRGB curve; for a stop of exposure, up or down, it differs by at most
/// 0.018.
struct LightChange {
  std::array<double, 3> gain{1, 1, 1};  ///< of red, green and blue light, above 0
  double shadow = 0;                    ///< share of light that the shadow takes, 0 to below 1
  double shadow_rad = 0;                ///< direction into the shadow: 0 to the right, π/2 down
  double shadow_at = 0;                 ///< the edge's place from the middle, in half widths
  double shadow_softness = 0.1;         ///< half width of the edge, in half widths of the picture, above 0
};

/// The picture in the changed light; values brighter than white become white.
///
/// \param picture  [H, W, 3]
/// \returns        [H, W, 3]
/// \throws ShapeError if there are not three channels; DomainError for a change beyond its ranges
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const LightChange& change);

/// Adds the derivatives of transformed() to `picture_adjoint`; those of white pixels are 0. All are [H, W,
/// 3].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const LightChange& change,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);
}  // namespace tapestry::image
