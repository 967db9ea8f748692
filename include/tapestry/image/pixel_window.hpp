#pragma once
#include <tapestry/core/error.hpp>

namespace tapestry::image {
/// A rectangle of pixels of a picture: rows top … top + height − 1, columns alike.
struct PixelWindow {
  std::size_t top = 0, left = 0, height = 0, width = 0;
  bool operator==(const PixelWindow&) const = default;
};

/// \throws ShapeError unless the window lies within height × width pixels
inline void require_window(const char* operation, const PixelWindow& window, std::size_t height,
                           std::size_t width) {
  const auto fits = [](std::size_t first, std::size_t count, std::size_t all) {
    return first <= all && count <= all - first;
  };
  if (fits(window.top, window.height, height) && fits(window.left, window.width, width)) return;
  throw ShapeError({operation, ": the window of ", window.height, "x", window.width, " pixels at row ",
                    window.top, ", column ", window.left, " leaves the picture, [", height, ", ", width,
                    "]"});
}
}  // namespace tapestry::image
