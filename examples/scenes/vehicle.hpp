#pragma once
#include <tapestry/raster/mesh_pictures.hpp>
#include "mesh_builder.hpp"

namespace tapestry::scenes {
struct CarTexture {
  std::vector<std::uint8_t> faces;  ///< one entry a face, 1 where it shows
  raster::TextureLayout layout{};
  Array<float, 2> texels;  ///< [texel, 3], of all levels where the layout is filtered
};

/// A mesh of the user's as the main car of scenes: in metres, z up, standing on the ground at the origin.
struct Vehicle {
  geometry::Mesh mesh{};
  std::vector<std::uint8_t> painted{};               ///< 1 for each face that takes the car's colour
  std::shared_ptr<raster::MeshPictures> pictures{};  ///< its own, on painted and other faces; or null
  double metres_per_unit = 1;
  Point origin{};  ///< the scene's origin in the unchanged mesh, its units
};

/// Its parts without paint are dark, see with_dark_parts().
/// \param mesh     z up, in any units
/// \param painted  one entry a face
/// \param length   of the longest side of the mesh's box, metres; 0 where its units are metres
/// \param least_m  least length
/// \throws DomainError for a mesh that would be shorter than that or longer than 20 m
[[nodiscard]] Vehicle stand_on_ground(geometry::Mesh mesh, std::vector<std::uint8_t> painted, double length,
                                      double least_m = 1);

/// Puts a texture of the mesh's own on some of its faces.
/// \param picture  [H, W, 3], RGB
/// \param faces    one entry a face, 1 for those that it shows on; they have texture coordinates
void add_texture(Vehicle& vehicle, const Array<std::uint8_t, 3>& picture,
                 const std::vector<std::uint8_t>& faces);

/// The camera of a scene, as it sees the vehicle's mesh in the units that it had before.
[[nodiscard]] geometry::Camera camera_of_mesh(const Vehicle& vehicle, geometry::Camera camera);
}  // namespace tapestry::scenes
