#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <vector>

namespace tapestry::camouflage {

/// One picture taken from a known place, before the car is painted into it.
struct Frame {
  std::string name;
  Array<std::uint8_t, 3> image;  ///< [H, W, 3], RGB
  geometry::Camera camera;
  raster::Light light;
  Array<std::uint8_t, 2> mask;  ///< [H, W], non-zero where the car may show; empty: everywhere
};

/// A rectangle of pixels.
struct PixelWindow {
  std::size_t top = 0, left = 0, height = 0, width = 0;
};

/// A frame prepared for one detector: everything that does not change with the texture.
///
/// All arrays have the extents of the network's input; a frame of another aspect ratio lies centred
/// in it with grey (½) above and below or to the sides (Darknet's letterbox).
template <class T>
struct View {
  std::string name;
  Array<T, 3> background;              ///< I, [3, H, W], RGB in [0, 1]
  Array<T, 2> mask;                    ///< m, [H, W], 1 where the car may show and 0 elsewhere
  raster::TextureOperator<T> picture;  ///< texture → O, premultiplied by its coverage
  detect::Box target;                  ///< around what shows of the car, pixels of the network's input
  std::size_t visible_pixels = 0;      ///< pixels in which the car shows
  PixelWindow window;                  ///< around them, with one row below and one column to the right
};

namespace detail {
/// The camera that sees the frame inside its letterbox: the field of view grows by the margins.
inline geometry::Camera letterboxed(geometry::Camera camera, const image::Letterbox& box, std::size_t height,
                                    std::size_t width) {
  camera.tan_half_fov_y *= static_cast<double>(height) / static_cast<double>(box.height);
  camera.tan_half_fov_x *= static_cast<double>(width) / static_cast<double>(box.width);
  return camera;
}

template <class T>
Array<T, 3> background_of(const Frame& frame, std::size_t height, std::size_t width) {
  return image::planes_of(image::letterboxed(image::from_bytes<T>(frame.image), height, width, T(0.5)));
}

/// m = 1 where any pixel of the frame's mask under the bilinear kernel is not zero: the rule of the
/// published data set, whose masks are slightly dilated silhouettes. The margins are 0.
template <class T>
Array<T, 2> mask_of(const Frame& frame, std::size_t height, std::size_t width) {
  Array<T, 3> marked(Extents<3>{frame.image.shape(0), frame.image.shape(1), 1});
  for (std::size_t i = 0; i < marked.size(); ++i)
    marked.data()[i] = frame.mask.size() == 0 || frame.mask.data()[i] != 0 ? T(1) : T(0);
  const Array<T, 3> canvas = image::letterboxed(marked, height, width, T(0));
  Array<T, 2> mask(Extents<2>{height, width});
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = canvas.data()[i] > T(0) ? T(1) : T(0);
  return mask;
}

template <class T>
void measure_target(View<T>& view) {
  const std::size_t height = view.mask.shape(0);
  const std::size_t width = view.mask.shape(1);
  std::array<std::size_t, 4> edges{width, height, 0, 0};  // left, top, right, bottom
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      if (view.mask(y, x) * view.picture.coverage(y, x) <= T(0)) continue;
      edges = {std::min(edges[0], x), std::min(edges[1], y), std::max(edges[2], x + 1),
               std::max(edges[3], y + 1)};
      ++view.visible_pixels;
    }
  if (view.visible_pixels == 0) return;  // the target stays the empty box
  const auto left = static_cast<double>(edges[0]);
  const auto top = static_cast<double>(edges[1]);
  const auto right = static_cast<double>(edges[2]);
  const auto bottom = static_cast<double>(edges[3]);
  view.target = {(left + right) / 2, (top + bottom) / 2, right - left, bottom - top};
  view.window = {edges[1], edges[0], std::min(edges[3] + 1, height) - edges[1],
                 std::min(edges[2] + 1, width) - edges[0]};
}

/// Calls visit(pixel) for every pixel of the window, in order.
template <class T, class Visit>
void for_each_window_pixel(const View<T>& view, Visit visit) {
  const PixelWindow& window = view.window;
  for (std::size_t y = window.top; y < window.top + window.height; ++y) {
    const std::size_t row = y * view.mask.shape(1) + window.left;
    for (std::size_t pixel = row; pixel < row + window.width; ++pixel) visit(pixel);
  }
}
}  // namespace detail

/// Prepares one frame for a network input of height × width pixels.
///
/// The car is hidden in the view when it lies outside the picture or wholly behind the mask: then
/// visible_pixels is 0 and the target an empty box.
/// \throws ShapeError if the frame's mask has other extents than its image
template <class T>
[[nodiscard]] View<T> make_view(const Frame& frame, const raster::PaintedMesh& car, std::size_t height,
                                std::size_t width, std::size_t samples_per_axis = 2) {
  if (frame.mask.size() != 0)
    require_shape("make_view", "mask", frame.mask, {frame.image.shape(0), frame.image.shape(1)});
  const auto box = image::letterbox(frame.image.shape(0), frame.image.shape(1), height, width);
  View<T> view;
  view.name = frame.name;
  view.background = detail::background_of<T>(frame, height, width);
  view.mask = detail::mask_of<T>(frame, height, width);
  view.target = {0, 0, 0, 0};
  const auto camera = detail::letterboxed(frame.camera, box, height, width);
  view.picture = raster::texture_operator<T>(car, camera, height, width, frame.light, samples_per_axis);
  detail::measure_target(view);
  return view;
}

/// The picture that the detector sees: I_adv = m·O + (1 − m)·I with O = P + (1 − c)·I, where P is the
/// render premultiplied by its coverage c. So along the silhouette, where a pixel is partly covered,
/// the frame shows through instead of a fixed background colour.
/// Source: FCA (AAAI 2022), eq. 6; O's background is ours (the published program uses white).
///
/// \param premultiplied  P, [H, W, 3]
/// \param picture        [3, H, W]
template <class T>
void compose(const View<T>& view, const Array<T, 3>& premultiplied, T* picture) {
  std::copy_n(view.background.data(), view.background.size(), picture);
  const std::size_t plane = view.mask.size();
  detail::for_each_window_pixel(view, [&](std::size_t pixel) {
    const T m = view.mask.data()[pixel];
    const T kept = T(1) - m * view.picture.coverage.data()[pixel];
    for (std::size_t c = 0; c < 3; ++c) {
      T& value = picture[c * plane + pixel];
      value = m * premultiplied.data()[3 * pixel + c] + kept * value;
    }
  });
}

/// The pullback of compose(): m · picture_adjoint.
/// \param picture_adjoint  [3, H, W]
/// \returns  [H, W, 3], the adjoint of `premultiplied`
template <class T>
[[nodiscard]] Array<T, 3> compose_adjoint(const View<T>& view, const T* picture_adjoint) {
  auto premultiplied_adjoint = zeros<T, 3>({view.mask.shape(0), view.mask.shape(1), 3});
  const std::size_t plane = view.mask.size();
  detail::for_each_window_pixel(view, [&](std::size_t pixel) {
    const T m = view.mask.data()[pixel];
    for (std::size_t c = 0; c < 3; ++c)
      premultiplied_adjoint.data()[3 * pixel + c] = m * picture_adjoint[c * plane + pixel];
  });
  return premultiplied_adjoint;
}

/// Which pixels of the window belong to the car, [h, w]: m·c > 0. Smoothness counts steps inside it.
template <class T>
[[nodiscard]] Array<T, 2> car_pixels(const View<T>& view) {
  Array<T, 2> pixels(Extents<2>{view.window.height, view.window.width});
  T* to = pixels.data();
  detail::for_each_window_pixel(view, [&](std::size_t pixel) {
    *to++ = view.mask.data()[pixel] * view.picture.coverage.data()[pixel] > T(0) ? T(1) : T(0);
  });
  return pixels;
}

/// The window of a picture, [h, w, 3].
/// \param picture  [3, H, W]
template <class T>
[[nodiscard]] Array<T, 3> window_of(const View<T>& view, const T* picture) {
  Array<T, 3> part(Extents<3>{view.window.height, view.window.width, 3});
  T* to = part.data();
  const std::size_t plane = view.mask.size();
  detail::for_each_window_pixel(view, [&](std::size_t pixel) {
    for (std::size_t c = 0; c < 3; ++c) *to++ = picture[c * plane + pixel];
  });
  return part;
}

/// The pullback of window_of(): adds `part_adjoint` to the window of picture_adjoint, [3, H, W].
template <class T>
void add_to_window(const View<T>& view, const Array<T, 3>& part_adjoint, T* picture_adjoint) {
  const T* from = part_adjoint.data();
  const std::size_t plane = view.mask.size();
  detail::for_each_window_pixel(view, [&](std::size_t pixel) {
    for (std::size_t c = 0; c < 3; ++c) picture_adjoint[c * plane + pixel] += *from++;
  });
}

}  // namespace tapestry::camouflage
