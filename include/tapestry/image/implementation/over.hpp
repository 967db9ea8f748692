#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/image/pixel_window.hpp>

namespace tapestry::image::detail {

/// Adds the part of a picture beside a place, [H, W, C], to another.
template <class T>
void add_beside(const PixelWindow& place, const Array<T, 3>& from, Array<T, 3>& to) {
  const auto is_within = [](std::size_t at, std::size_t first, std::size_t count) {
    return at >= first && at - first < count;
  };
  const std::size_t channels = from.shape(2);
  for (std::size_t y = 0; y < from.shape(0); ++y)
    for (std::size_t x = 0; x < from.shape(1); ++x) {
      if (is_within(y, place.top, place.height) && is_within(x, place.left, place.width)) continue;
      for (std::size_t c = 0; c < channels; ++c) to(y, x, c) += from(y, x, c);
    }
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

template <std::floating_point T>
Array<T, 3> over(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage, const Array<T, 3>& background,
                 std::size_t top, std::size_t left, ColourSpace space) {
  const auto place = detail::place_of("over", coverage, background.shape(), top, left);
  require_shape("over", "premultiplied", premultiplied, {place.height, place.width, background.shape(2)});
  Array<T, 3> picture = background;
  detail::lay_over(premultiplied.data(), coverage.data(), place, background.shape(), space, picture.data());
  return picture;
}

template <std::floating_point T>
void over_adjoint(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage,
                  const Array<T, 3>& background, const Array<T, 3>& picture_adjoint,
                  Array<T, 3>* premultiplied_adjoint, Array<T, 2>* coverage_adjoint,
                  Array<T, 3>* background_adjoint, std::size_t top, std::size_t left, ColourSpace space) {
  const auto place = detail::place_of("over_adjoint", coverage, background.shape(), top, left);
  const std::size_t channels = background.shape(2);
  require_shape("over_adjoint", "premultiplied", premultiplied, {place.height, place.width, channels});
  require_shape("over_adjoint", "picture_adjoint", picture_adjoint, background.shape());
  if (premultiplied_adjoint != nullptr)
    require_shape("over_adjoint", "premultiplied_adjoint", *premultiplied_adjoint, premultiplied.shape());
  if (coverage_adjoint != nullptr)
    require_shape("over_adjoint", "coverage_adjoint", *coverage_adjoint, coverage.shape());
  if (background_adjoint != nullptr) {
    require_shape("over_adjoint", "background_adjoint", *background_adjoint, background.shape());
    detail::add_beside(place, picture_adjoint, *background_adjoint);
  }
  detail::with_overlay(space, [&](auto overlay) {
    detail::for_each_covered_pixel(place, background.shape(1), [&](std::size_t front, std::size_t back) {
      for (std::size_t c = 0; c < channels; ++c) {
        const std::size_t i = front * channels + c, j = back * channels + c;
        const T p = premultiplied.data()[i], covered = coverage.data()[front], behind = background.data()[j];
        const auto slopes = overlay.slopes(p, covered, behind, overlay.value(p, covered, behind));
        const T adjoint = picture_adjoint.data()[j];
        if (premultiplied_adjoint != nullptr)
          premultiplied_adjoint->data()[i] += slopes.by_premultiplied * adjoint;
        if (coverage_adjoint != nullptr) coverage_adjoint->data()[front] += slopes.by_coverage * adjoint;
        if (background_adjoint != nullptr) background_adjoint->data()[j] += slopes.by_background * adjoint;
      }
    });
  });
}

template Array<float, 3> over<float>(const Array<float, 3>& premultiplied, const Array<float, 2>& coverage,
                                     const Array<float, 3>& background, std::size_t top, std::size_t left,
                                     ColourSpace space);
template Array<double, 3> over<double>(const Array<double, 3>& premultiplied,
                                       const Array<double, 2>& coverage, const Array<double, 3>& background,
                                       std::size_t top, std::size_t left, ColourSpace space);
template decltype(over_adjoint<float>) over_adjoint<float>;
template decltype(over_adjoint<double>) over_adjoint<double>;

}  // namespace tapestry::image
