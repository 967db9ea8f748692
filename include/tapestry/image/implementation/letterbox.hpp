#pragma once
#include <tapestry/core/array_limit.hpp>
#include <tapestry/image/letterbox.hpp>

namespace tapestry::image {
namespace detail {
void require_size(const char* operation, std::size_t rows, std::size_t columns) {
  constexpr std::size_t limit = 1U << 16U;
  if (rows == 0 || columns == 0 || rows > limit || columns > limit)
    throw DomainError({operation, ": a side of [", rows, ", ", columns, "] is not 1 to 65536"});
  constexpr std::size_t channels = 4;
  if (rows > array_limit / channels / columns)
    throw DomainError({operation, ": a picture [", rows, ", ", columns, "] is too large for this processor"});
}
}  // namespace detail

Fit fit_by_name(std::string_view name) {
  for (const FitKind kind : fit_kinds)
    if (name_of(kind) == name) return {kind, kind == FitKind::letterbox_top_left ? 114.0 / 255 : 0.5};
  throw DomainError(
      {"no fit is called ", in_quotes(name), "; expected letterbox, letterbox_top_left or stretch"});
}

Placement placement(std::size_t from_height, std::size_t from_width, std::size_t height, std::size_t width,
                    FitKind kind) {
  if (from_height == 0 || from_width == 0 || height == 0 || width == 0)
    throw DomainError("placement: a picture without pixels");
  Placement place{height, width, 0, 0};
  if (kind == FitKind::stretch) return place;
  if (from_width * height > from_height * width)
    place.height = std::max<std::size_t>(1, from_height * width / from_width);
  else
    place.width = std::max<std::size_t>(1, from_width * height / from_height);
  if (kind == FitKind::letterbox_top_left) return place;
  if ((height - place.height) % 2 != 0 && place.height > 1) --place.height;
  if ((width - place.width) % 2 != 0 && place.width > 1) --place.width;
  place.top = (height - place.height) / 2;
  place.left = (width - place.width) / 2;
  return place;
}

PictureFromCanvas picture_from_canvas(std::size_t picture_height, std::size_t picture_width,
                                      std::size_t height, std::size_t width, FitKind kind) {
  const Placement place = placement(picture_height, picture_width, height, width, kind);
  return {static_cast<double>(picture_width) / static_cast<double>(place.width),
          static_cast<double>(picture_height) / static_cast<double>(place.height),
          static_cast<double>(place.left), static_cast<double>(place.top)};
}
}  // namespace tapestry::image
