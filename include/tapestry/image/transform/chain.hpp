#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/detail/transform/camera_effects.hpp>
#include <tapestry/image/detail/transform/own_transformation.hpp>
#include <tapestry/image/detail/transform/warp.hpp>
#include <variant>

namespace tapestry::image {
/// A change of a picture between the scene and the detector, with its settings: one of ours, or any type of a
/// user's that TransformsPictures.
using Transformation =
    std::variant<Warp, LightChange, ColourChange, Blur, SensorNoise, JpegCompression, OwnTransformation>;

/// The transformations of one picture, in this order; none if empty.
using TransformationChain = std::vector<Transformation>;

/// The pictures of a chain: the first one, [H, W, 3], and the result of each transformation.
/// \throws as the transformations
template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 3>> transformation_stages(Array<T, 3> picture,
                                                             const TransformationChain& chain);

/// The picture after all of a chain, [H, W, 3]. \throws as the transformations
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(Array<T, 3> picture, const TransformationChain& chain);

/// Adds the derivatives of a chain to `picture_adjoint`.
///
/// \param stages       of transformation_stages()
/// \param out_adjoint  and \param picture_adjoint [H, W, 3]
/// \throws ShapeError if extents differ, or there are not as many stages
template <std::floating_point T>
void transformed_adjoint(const std::vector<Array<T, 3>>& stages, const TransformationChain& chain,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);

/// Recoloured texels or pictures on the tape, [..., 3].
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> transformed(const ArrayVariable<T, Rank>& colours,
                                                 const ColourChange& change) {
  const auto pullback = [before = colours.shared_value(), change](const Array<T, Rank>& out_adjoint,
                                                                  Array<T, Rank>* colours_adjoint) {
    transformed_adjoint(*before, change, out_adjoint, *colours_adjoint);
  };
  return record_array(transformed(colours.value(), change), pullback, colours);
}

/// Transforms the pictures of a batch, each by its own chain, in one operation on the tape, which keeps the
/// input of every transformation.
///
/// \param pictures  [N, H, W, 3]
/// \param chains    one a picture
/// \returns         [N, H, W, 3]
/// \throws ShapeError if there are not as many chains; or as the transformations
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> transformed(const ArrayVariable<T, 4>& pictures,
                                              const std::vector<TransformationChain>& chains);

/// Ranges of a photograph's conditions around the frames' own: the camera's pose, the light, its lens, its
/// sensor and its file. Each condition is drawn uniformly from its range; 0 leaves it unchanged. Angles are
/// for a view of 90°. With a longer lens the picture moves as far, and the camera turns less.
struct Conditions {
  double turn_degrees = 0;    ///< largest pan and tilt of the camera, either way
  double roll_degrees = 0;    ///< largest roll, either way
  double zoom = 0;            ///< largest change of the focal length, as a share, either way
  double exposure_stops = 0;  ///< largest change of exposure, either way
  double colour_cast = 0;     ///< largest change of the gain of red and of blue, as a share, either way
  double shadow = 0;          ///< largest share of light that a shadow takes; in half of the pictures
  double contrast = 0;        ///< largest change of contrast and of saturation, as a share, either way
  double blur_px = 0;         ///< largest standard deviation of blur, pixels of the detector's input
  double noise = 0;           ///< largest standard deviation of the sensor's noise at mid grey
  int worst_quality = 0;      ///< lowest JPEG quality, 1 to 95: drawn between it and 95; 0: no JPEG

  /// A printer: distances of its blackest black and its whitest white from ideal ones, and the largest error
  /// of the matrix that mixes its colours.
  double printed_range = 0, printed_error = 0;

  /// Whether prints differ from the paint.
  [[nodiscard]] bool has_print() const { return printed_range > 0 || printed_error > 0; }

  [[nodiscard]] bool operator==(const Conditions&) const = default;
};

/// Conditions of a printed paint photographed outdoors: evaluate measures with them and camouflage can train
/// for them. Values are ours; RAUCA-E2E trains with turns of ±5°, scales of 0.7 to 1 and jittered colours.
inline constexpr Conditions physical_conditions{5, 5, 0.15, 1, 0.1, 0.5, 0.2, 1.5, 0.04, 50, 0.1, 0.05};

/// Names of conditions, for help and errors.
inline constexpr const char* condition_names =
    "camera, light, blur, noise, contrast, jpeg, print, or physical for all";

/// Physical conditions restricted to some of condition_names.
/// \throws DomainError naming one that is none of these
[[nodiscard]] Conditions conditions_by_names(const std::vector<std::string>& names);

/// Draws the transformations of one picture: the camera's motion, the light, blur, noise, contrast and JPEG,
/// in the order of a camera. The same for the same random numbers.
///
/// \param is_smooth  whether JPEG's rounding has slopes, to train; else it is as in files, to measure
[[nodiscard]] TransformationChain draw_chain(const Conditions& conditions, Random random, bool is_smooth);

/// Draws a printer's change of a paint's colours.
[[nodiscard]] ColourChange draw_print(const Conditions& conditions, Random random);
}  // namespace tapestry::image
