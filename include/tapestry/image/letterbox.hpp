#pragma once
#include <algorithm>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/crop.hpp>
#include <tapestry/image/resize.hpp>

namespace tapestry::image {

/// Where a picture lies inside a canvas of another aspect ratio: scaled as large as fits, and centred.
struct Letterbox {
  std::size_t height = 0;  ///< of the scaled picture, pixels of the canvas
  std::size_t width = 0;
  std::size_t top = 0;
  std::size_t left = 0;
};

/// The placement of a picture of from_height × from_width on a canvas of height × width. The side that does
/// not fill the canvas is rounded down to the parity of the canvas, so that the margins are equal and the
/// centre stays the centre. Source of the idea: Darknet's letterbox_image, which rounds down only.
/// \throws DomainError if an extent is 0
[[nodiscard]] inline Letterbox letterbox(std::size_t from_height, std::size_t from_width, std::size_t height,
                                         std::size_t width) {
  if (from_height == 0 || from_width == 0 || height == 0 || width == 0)
    throw DomainError("letterbox: a picture without pixels");
  Letterbox box{height, width, 0, 0};
  if (from_width * height > from_height * width)
    box.height = std::max<std::size_t>(1, from_height * width / from_width);
  else
    box.width = std::max<std::size_t>(1, from_width * height / from_height);
  if ((height - box.height) % 2 != 0 && box.height > 1) --box.height;
  if ((width - box.width) % 2 != 0 && box.width > 1) --box.width;
  box.top = (height - box.height) / 2;
  box.left = (width - box.width) / 2;
  return box;
}

/// Pixels of a picture from pixels of the canvas that it lies on: x = x_scale · (x_canvas − left), y alike;
/// extents are only scaled.
struct PictureFromCanvas {
  double x_scale = 1, y_scale = 1;
  double left = 0, top = 0;  ///< of the picture, pixels of the canvas

  /// A column of the canvas as a column of the picture, pixels.
  [[nodiscard]] double x(double x_canvas) const { return (x_canvas - left) * x_scale; }
  /// A row of the canvas as a row of the picture, pixels.
  [[nodiscard]] double y(double y_canvas) const { return (y_canvas - top) * y_scale; }
  [[nodiscard]] double width(double width_canvas) const { return width_canvas * x_scale; }
  [[nodiscard]] double height(double height_canvas) const { return height_canvas * y_scale; }
};

/// Inverts the placement of letterbox(), whose arguments it takes. The two scales differ by what rounding the
/// placed extents to whole pixels makes them differ.
/// \throws DomainError if an extent is 0
[[nodiscard]] inline PictureFromCanvas picture_from_canvas(std::size_t picture_height,
                                                           std::size_t picture_width, std::size_t height,
                                                           std::size_t width) {
  const Letterbox box = letterbox(picture_height, picture_width, height, width);
  return {static_cast<double>(picture_width) / static_cast<double>(box.width),
          static_cast<double>(picture_height) / static_cast<double>(box.height),
          static_cast<double>(box.left), static_cast<double>(box.top)};
}

/// The picture, [h, w, C], resized bilinearly into its place on a canvas [height, width, C] of one value.
/// \param margin  that value, a colour in [0, 1]
/// \throws DomainError if an extent is 0
template <class T>
[[nodiscard]] Array<T, 3> letterboxed(const Array<T, 3>& picture, std::size_t height, std::size_t width,
                                      T margin) {
  const Letterbox box = letterbox(picture.shape(0), picture.shape(1), height, width);
  const Array<T, 3> resized = resize_bilinear(picture, box.height, box.width);
  const std::size_t channels = picture.shape(2);
  auto canvas = filled<T, 3>({height, width, channels}, margin);
  for (std::size_t y = 0; y < box.height; ++y)
    std::copy_n(resized.data() + y * box.width * channels, box.width * channels,
                canvas.data() + ((y + box.top) * width + box.left) * channels);
  return canvas;
}

/// Adds the transpose of letterboxed() times canvas_adjoint to picture_adjoint: the margins go nowhere.
///
/// \param canvas_adjoint   [height, width, C]
/// \param picture_adjoint  [h, w, C]
/// \throws DomainError if an extent is 0, ShapeError if the channels differ
template <class T>
void letterboxed_adjoint(const Array<T, 3>& canvas_adjoint, Array<T, 3>& picture_adjoint) {
  const Letterbox box = letterbox(picture_adjoint.shape(0), picture_adjoint.shape(1), canvas_adjoint.shape(0),
                                  canvas_adjoint.shape(1));
  resize_bilinear_adjoint(crop(canvas_adjoint, {box.top, box.left, box.height, box.width}), picture_adjoint);
}

}  // namespace tapestry::image
