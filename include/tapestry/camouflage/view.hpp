#pragma once
#include <tapestry/camouflage/photo_light.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::camouflage {
/// Inputs of a view's drawing, needed again when its car changes its shape.
template <std::floating_point T>
struct Sight {
  geometry::Camera camera;           ///< camera of the frame, in the network's input
  raster::Light light;               ///< see io::frame_light()
  Array<T, 2> mask;                  ///< m, [H, W], 1 where the car may show
  std::size_t samples_per_axis = 2;  ///< of a pixel
};

/// A frame prepared for one detector: everything that does not change with the texture.
///
/// H and W are the network input's; image::Fit defines where a frame of another aspect ratio lies in it. The
/// car is drawn in the window around its visible part, h × w pixels.
template <std::floating_point T>
struct View {
  std::string name;
  Array<T, 3> background;                      ///< I, [H, W, 3], RGB in [0, 1]
  std::array<std::size_t, 2> frame_extents{};  ///< rows and columns of the frame's picture
  /// Texture → m·O, [h, w, 3], multiplied by its coverage m·c; of the texels that the view reads.
  std::shared_ptr<const raster::CompactOperator<T>> paint_to_picture;
  image::PixelWindow window;  ///< its place in the frame; empty if nothing shows
  /// [h, w], 1 where a pixel and its right and lower neighbours are all car.
  std::shared_ptr<const Array<T, 2>> interior;
  detect::Box target{0, 0, 0, 0};  ///< around the car's visible part, pixels of the input
  std::size_t visible_pixels = 0;  ///< pixels that show the car
  double hidden_share = 0;         ///< share of the car's silhouette hidden by the frame's mask
  /// Position of the camera around the middle of the car, in units of half the car's longest side; all 0 for
  /// a camera right there.
  geometry::Orbit orbit{};
  image::ColourSpace space =
      image::ColourSpace::encoded;  ///< space for lighting the car and laying it over the frame
  std::shared_ptr<const raster::MipPyramid> pyramid{};  ///< for a filtered atlas, else null
  /// Light estimated from the photograph, without the maps that it was drawn with; null
  /// where the frame's own light was used.
  std::shared_ptr<const raster::EstimatedLight> photo_light{};
  /// IoU of the car's silhouette and the frame's mask; none without a mask, or if the
  /// photograph need not be kept.
  std::optional<double> registration{};
  std::optional<bool> shows_car{};          ///< see PhotoLight::shows_car; none where that was not called
  bool keeps_photograph = false;            ///< whether faces without paint show the frame's own pixels
  std::shared_ptr<const Sight<T>> sight{};  ///< null where the car's shape stays
};

/// Least registration for a photograph to count as showing the car where the mesh is.
inline constexpr double least_registration = 0.9;

template <std::floating_point T>
using ViewSpan = std::span<const std::shared_ptr<const View<T>>>;

namespace detail {
/// Pixels that are covered wholly, with their right and lower neighbours: colour steps between them belong to
/// the paint, not to its outline.
template <std::floating_point T>
Array<T, 2> interior_of(const Array<T, 2>& coverage);
}  // namespace detail

/// Inputs of a frame's drawing; parameters as for make_view().
/// \throws DomainError as io::camera_of()
template <std::floating_point T>
[[nodiscard]] Sight<T> sight_of(const io::Frame& frame, image::ColourSpace space, std::size_t height,
                                std::size_t width, std::size_t samples_per_axis, image::FitKind fit);

/// Prepares one frame for a network input of height × width pixels; `fit` places it there.
///
/// The car is hidden in the view when it lies outside the picture or wholly behind the mask: then
/// visible_pixels is 0 and the target an empty box.
/// \param car    with the pyramid of its atlas if that is filtered
/// \param photo  settings for estimating light from the frame's picture; without them, if no point of the
///               car can be made out in it, or if shows_car() of a frame without a mask is false, the light
///               is io::frame_light()
/// \param keeps_photograph  whether faces without paint show the frame's own pixels if the frame holds the
///               car: if its mask and the car's silhouette have an IoU of at least least_registration or,
///               without a mask, if shows_car() of `photo` is true. Else they show their materials
/// \throws ShapeError if the frame's mask has other extents than its image; DomainError for a filtered atlas
///         without a pyramid, and as io::camera_of()
template <std::floating_point T>
[[nodiscard]] View<T> make_view(const io::Frame& frame, const raster::PaintedMesh& car, std::size_t height,
                                std::size_t width, std::size_t samples_per_axis = 2,
                                const image::Fit& fit = {}, const std::optional<PhotoLight>& photo = {},
                                bool keeps_photograph = true);

/// The picture that the detector sees: I_adv = m·O + (1 − m·c)·I, with O the render multiplied by its
/// coverage c. So along the silhouette, where a pixel is partly covered, the frame shows through instead of a
/// fixed background colour. Source: FCA (AAAI 2022), eq. 6; O's background is ours (the published program
/// uses white).
///
/// \param colours  [texel, 3], encoded in either space
/// \returns        [H, W, 3]
template <std::floating_point T>
[[nodiscard]] Array<T, 3> picture_of(const View<T>& view, const Array<T, 2>& colours);

/// Texels that views are drawn from, see raster::stored_texels(): the same in all views of a car. For a fine
/// texture they take longer than a picture. Parameter as for picture_of().
template <std::floating_point T>
[[nodiscard]] Array<T, 2> texels_of(const View<T>& view, const Array<T, 2>& colours);

/// picture_of() from the view's texels_of().
template <std::floating_point T>
[[nodiscard]] Array<T, 3> picture_of_texels(const View<T>& view, const Array<T, 2>& texels);
}  // namespace tapestry::camouflage
