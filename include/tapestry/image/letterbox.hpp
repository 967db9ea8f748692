#pragma once
#include <tapestry/image/crop.hpp>
#include <tapestry/image/resize.hpp>

namespace tapestry::image {
/// Placement of a picture on a canvas of another aspect ratio, such as a network's input:
///
///   letterbox           scaled as large as fits, and centred, as Darknet's detectors take it
///   letterbox_top_left  scaled as large as fits, in the top left corner, as YOLOX takes it
///   stretch             scaled to the whole canvas, by a factor for each side
enum class FitKind { letterbox, letterbox_top_left, stretch };

/// A fit, and the colour beside the picture.
struct Fit {
  FitKind kind = FitKind::letterbox;
  double fill = 0.5;  ///< value of every channel, in [0, 1]; unused for a stretched picture

  bool operator==(const Fit&) const = default;
};

/// All of them, for messages.
inline constexpr std::array<FitKind, 3> fit_kinds{FitKind::letterbox, FitKind::letterbox_top_left,
                                                  FitKind::stretch};

/// The name that fit_by_name() takes.
[[nodiscard]] constexpr std::string_view name_of(FitKind kind) {
  constexpr std::array<std::string_view, 3> names{"letterbox", "letterbox_top_left", "stretch"};
  return names[static_cast<std::size_t>(kind)];
}

/// The fit of a name with its usual fill: ½ for letterbox, 114 of 255 for letterbox_top_left.
/// \throws DomainError for any other name than letterbox, letterbox_top_left and stretch
[[nodiscard]] Fit fit_by_name(std::string_view name);

/// Place of a picture on a canvas.
struct Placement {
  std::size_t height = 0;  ///< of the scaled picture, pixels of the canvas
  std::size_t width = 0;
  std::size_t top = 0;
  std::size_t left = 0;
};

/// The placement of a picture of from_height × from_width on a canvas of height × width. The side that does
/// not fill the canvas is rounded down. For a centred picture it is rounded down to the parity of the canvas,
/// so that both margins are equal. Source of the idea: Darknet's letterbox_image, which only rounds down.
/// \throws DomainError if an extent is 0
[[nodiscard]] Placement placement(std::size_t from_height, std::size_t from_width, std::size_t height,
                                  std::size_t width, FitKind kind = FitKind::letterbox);

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

/// Inverts placement(), whose arguments it takes. The two scales of a letterboxed picture differ only because
/// the placed extents are rounded to whole pixels.
/// \throws DomainError if an extent is 0
[[nodiscard]] PictureFromCanvas picture_from_canvas(std::size_t picture_height, std::size_t picture_width,
                                                    std::size_t height, std::size_t width,
                                                    FitKind kind = FitKind::letterbox);

/// The picture, [h, w, C], resized bilinearly into its place on a canvas, [height, width, C].
/// \throws DomainError if an extent is 0
template <std::floating_point T>
[[nodiscard]] Array<T, 3> fitted(const Array<T, 3>& picture, std::size_t height, std::size_t width,
                                 const Fit& fit) {
  const Placement place = placement(picture.shape(0), picture.shape(1), height, width, fit.kind);
  const Array<T, 3> resized = resize_bilinear(picture, place.height, place.width);
  const std::size_t channels = picture.shape(2);
  auto canvas = filled<T, 3>({height, width, channels}, static_cast<T>(fit.fill));
  for (std::size_t y = 0; y < place.height; ++y)
    std::copy_n(resized.data() + y * place.width * channels, place.width * channels,
                canvas.data() + ((y + place.top) * width + place.left) * channels);
  return canvas;
}

/// Adds the transpose of fitted() times canvas_adjoint to picture_adjoint; the adjoint beside the picture is
/// dropped.
///
/// \param canvas_adjoint   [height, width, C]
/// \param picture_adjoint  [h, w, C]
/// \throws DomainError if an extent is 0, ShapeError if the channels differ
template <std::floating_point T>
void fitted_adjoint(const Array<T, 3>& canvas_adjoint, FitKind kind, Array<T, 3>& picture_adjoint) {
  const Placement place = placement(picture_adjoint.shape(0), picture_adjoint.shape(1),
                                    canvas_adjoint.shape(0), canvas_adjoint.shape(1), kind);
  resize_bilinear_adjoint(crop(canvas_adjoint, {place.top, place.left, place.height, place.width}),
                          picture_adjoint);
}

/// fitted() as a letterbox with a fill of one's own.
/// \param margin  the fill, in [0, 1]
template <std::floating_point T>
[[nodiscard]] Array<T, 3> letterboxed(const Array<T, 3>& picture, std::size_t height, std::size_t width,
                                      T margin) {
  return fitted(picture, height, width, {FitKind::letterbox, static_cast<double>(margin)});
}

/// fitted() of a picture on the tape; its pullback is fitted_adjoint(). Errors as there.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> fitted(const ArrayVariable<T, 3>& picture, std::size_t height,
                                         std::size_t width, const Fit& fit) {
  const auto pullback = [kind = fit.kind](const Array<T, 3>& canvas_adjoint, Array<T, 3>* picture_adjoint) {
    fitted_adjoint(canvas_adjoint, kind, *picture_adjoint);
  };
  return record_array(fitted(picture.value(), height, width, fit), pullback, picture);
}

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 3> fitted(const ArrayVariable<D, 3>& picture, std::size_t height,
                                         std::size_t width, const Fit& fit) {
  return record_affine([=](const auto& x) { return fitted(x, height, width, fit); }, picture);
}

/// letterboxed() of a picture on the tape; errors as there.
/// \param margin  the value beside the picture, a colour in [0, 1]
template <Scalar T>
[[nodiscard]] ArrayVariable<T, 3> letterboxed(const ArrayVariable<T, 3>& picture, std::size_t height,
                                              std::size_t width, tapestry::detail::Base<T> margin) {
  return fitted(picture, height, width, {FitKind::letterbox, static_cast<double>(margin)});
}
}  // namespace tapestry::image
