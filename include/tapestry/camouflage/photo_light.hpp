#pragma once
#include <functional>
#include <tapestry/io/frame.hpp>
#include <tapestry/raster/estimated_light.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

/// Settings for estimating the light of a frame from the car in its photograph.
struct PhotoLight {
  std::shared_ptr<const raster::AmbientOcclusion> occlusion{};  ///< the car's; null: no part is shaded
  std::size_t most_points = 16384;                              ///< most points of the photograph to use
  std::size_t shadow_pixels = 512;               ///< pixels of the car in the view from the sun
  std::optional<std::array<double, 3>> paint{};  ///< the photographed car's, if known, see estimated_light()
  bool coat = true;  ///< whether the paint is taken to be lacquered, see raster::coated_light()
  /// Whether a photograph without a mask shows the car: called as shows_car(picture, name of the frame, box
  /// of the mesh), the picture as the detector takes it, [H, W, 3], by several threads at once. Null: not
  /// known.
  std::function<bool(const Array<float, 3>&, const std::string&, const detect::Box&)> shows_car{};
};

/// Points of the car's painted faces in a photograph: at most most_points, spread evenly over the pixels that
/// show a single face and lie in the frame's mask. Channels at their limit are 1.
///
/// \returns points with colours in the car's space, in the order of the pixels
/// \throws DomainError as io::camera_of(), and for an occlusion of another mesh
[[nodiscard]] std::vector<raster::LitPoint> lit_points(const io::Frame& frame, const raster::PaintedMesh& car,
                                                       const PhotoLight& settings);

/// The light of a frame's photograph, with the shadow of its sun and the car's occlusion, for pictures in the
/// car's space; none if no point of the car can be made out in it.
/// \throws DomainError as lit_points() and raster::estimated_light()
[[nodiscard]] std::optional<raster::EstimatedLight> photo_light(const io::Frame& frame,
                                                                const raster::PaintedMesh& car,
                                                                const PhotoLight& settings);

}  // namespace tapestry::camouflage
