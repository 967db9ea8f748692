#pragma once
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::raster {
/// Flat shading by an ambient and a distant light: a face's colour is multiplied by
///   colour · (ambient + directional · max(0, n·L)).
/// Source and defaults: Neural Mesh Renderer, lighting.
struct Light {
  double ambient = 0.5;
  double directional = 0.5;
  std::array<double, 3> direction{0, 0, 1};  ///< L, towards the light, in the world; any length but 0
  std::array<double, 3> colour{1, 1, 1};
};

/// Throws DomainError unless the light has finite numbers and a direction.
inline void require_light(const char* operation, const Light& light) {
  if (!(geometry::length(geometry::normalised(light.direction)) > 0.5) ||
      !geometry::is_finite(light.colour) || !std::isfinite(light.ambient) ||
      !std::isfinite(light.directional)) {
    throw DomainError({operation, ": the light needs finite numbers and a direction with a length"});
  }
}

/// A face's unit normal in the world, on the side visible from `eye`; of length 0 for a face without area.
[[nodiscard]] inline geometry::Vector3 seen_normal(const geometry::Mesh& mesh, std::size_t face,
                                                   const geometry::Vector3& eye) {
  const auto corner = [&](std::size_t k) -> const geometry::Vector3& {
    return mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])];
  };
  const geometry::Vector3 normal = geometry::normalised(
      geometry::cross(geometry::subtract(corner(1), corner(0)), geometry::subtract(corner(2), corner(0))));
  const double facing = geometry::dot(normal, geometry::subtract(eye, corner(0)));
  return geometry::scale(normal, facing < 0 ? -1 : 1);
}

/// ambient + directional · max(0, n·L) of every face of a mesh.
///
/// n is the geometric unit normal in the world on the visible side: a face seen from behind is lit from
/// behind, as Neural Mesh Renderer lights the reversed copies that it draws of all faces. A face without area
/// gets the ambient part only.
///
/// \throws DomainError if the direction has no length, or a number is not finite
[[nodiscard]] inline std::vector<double> face_light(const geometry::Mesh& mesh,
                                                    const geometry::Camera& camera, const Light& light) {
  require_light("face_light", light);
  const geometry::Vector3 towards = geometry::normalised(light.direction);
  if (light.directional == 0) return std::vector<double>(mesh.faces.size(), light.ambient);
  const geometry::Vector3 eye = geometry::eye_of(camera);
  std::vector<double> result(mesh.faces.size());
  constexpr std::size_t block = 4096;
  parallel_for_blocks(result.size(), block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t face = begin; face < end; ++face) {
      const double cosine = geometry::dot(seen_normal(mesh, face, eye), towards);
      result[face] = light.ambient + light.directional * std::max(0.0, cosine);
    }
  });
  return result;
}
}  // namespace tapestry::raster
