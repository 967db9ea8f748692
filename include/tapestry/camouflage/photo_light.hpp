#pragma once
#include <tapestry/io/frame.hpp>
#include <tapestry/raster/estimated_light.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {
/// Settings for estimating the light of a place from the car in its photographs.
struct PhotoLight {
  std::shared_ptr<const raster::AmbientOcclusion> occlusion{};  ///< the car's; null: no part is shaded
  std::size_t most_points = 16384;                              ///< most points of the photographs to use
  std::size_t shadow_pixels = 512;               ///< pixels of the car in the view from the sun
  std::optional<std::array<double, 3>> paint{};  ///< the photographed car's, if known, see estimated_light()
  bool is_one_place = false;  ///< whether frames without pose and light are of one place and hour
  std::shared_ptr<const raster::EstimatedLight> known{};  ///< light of the frame's place, if estimated before
  /// Whether a photograph without a mask shows the car: called as shows_car(picture, name of the frame, box
  /// of the mesh), the picture as the detector takes it, [H, W, 3], by several threads at once. Null: not
  /// known.
  std::function<bool(const Array<float, 3>&, const std::string&, const detect::Box&)> shows_car{};
};

/// The place and hour of a frame, equal for frames under one light: the vehicle's pose, to a quarter of a
/// metre and a degree. Of frames without a pose none, or with is_one_place the same for those that state no
/// light.
[[nodiscard]] std::optional<std::array<std::int64_t, 6>> place_of(const io::Frame& frame,
                                                                  const PhotoLight& settings);

/// Points of the car's painted faces in a photograph: at most most_points, spread evenly over the pixels that
/// show a single face and lie in the frame's mask. Channels at their limit are 1.
///
/// \returns points with colours in the car's space, in the order of the pixels
/// \throws DomainError as io::camera_of(), and for an occlusion of another mesh
[[nodiscard]] std::vector<raster::LitPoint> lit_points(const io::Frame& frame, const raster::PaintedMesh& car,
                                                       const PhotoLight& settings);

/// The light of photographs of one place, with the shadow of its sun and the car's occlusion, for pictures in
/// the car's space; none if no point of the car can be made out in them. \throws DomainError as lit_points()
/// and raster::estimated_light()
[[nodiscard]] std::optional<raster::EstimatedLight> photo_light(std::span<const io::Frame> frames,
                                                                const raster::PaintedMesh& car,
                                                                const PhotoLight& settings);
}  // namespace tapestry::camouflage
