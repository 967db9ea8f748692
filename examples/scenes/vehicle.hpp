#pragma once
#include <cstdint>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

#include "mesh_builder.hpp"

namespace tapestry::scenes {

/// A mesh of the user's as the main car of scenes: in metres, z up, standing on the ground at the origin.
struct Vehicle {
  geometry::Mesh mesh{};
  std::vector<std::uint8_t> painted{};  ///< 1 for each face that takes the car's colour
  std::vector<Colour> colours{};        ///< of the other faces: their material's, or dark
  double metres_per_unit = 1;
  Point origin{};  ///< where the scene's origin lies in the mesh as it was, its units
};

/// \param mesh     z up, in any units
/// \param painted  one entry a face
/// \param length   of the longest side of the mesh's box, metres; 0 where its units are metres
/// \throws DomainError for a mesh that would be shorter than 1 m or longer than 20 m
[[nodiscard]] Vehicle stand_on_ground(geometry::Mesh mesh, std::vector<std::uint8_t> painted, double length);

/// The camera of a scene, as it sees the vehicle's mesh in the units that it had before.
[[nodiscard]] geometry::Camera camera_of_mesh(const Vehicle& vehicle, geometry::Camera camera);

}  // namespace tapestry::scenes
