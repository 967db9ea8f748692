#pragma once
#include <tapestry/io/mesh_writers.hpp>

namespace tapestry::scenes {
/// Makes the faces without paint whose colour no file states as dark as glass and tyres. Meshes have a light
/// grey by default: a car from a file without materials would have white windows, which detectors do not
/// know. A file that states this very grey, as exporters do, counts as stating nothing.
/// \param painted  one entry a face
[[nodiscard]] inline geometry::Mesh with_dark_parts(geometry::Mesh mesh,
                                                    const std::vector<std::uint8_t>& painted) {
  constexpr std::array dark{0.09F, 0.09F, 0.10F};
  mesh.face_materials.resize(mesh.faces.size(), -1);
  std::vector<std::uint8_t> is_on_paint(mesh.materials.size(), 0);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    if (painted[face] != 0 && mesh.face_materials[face] >= 0)
      is_on_paint[static_cast<std::size_t>(mesh.face_materials[face])] = 1;
  std::int32_t part = -1;  // replaces no material, or one that painted faces have
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (painted[face] != 0) continue;
    const std::int32_t at = mesh.face_materials[face];
    geometry::Material* const own = at < 0 ? nullptr : &mesh.materials[static_cast<std::size_t>(at)];
    if (own != nullptr && (own->colour != geometry::Material{}.colour || !own->texture.empty())) continue;
    if (own != nullptr && is_on_paint[static_cast<std::size_t>(at)] == 0) {
      own->colour = dark;
      continue;
    }
    if (part < 0) {
      part = static_cast<std::int32_t>(mesh.materials.size());
      mesh.materials.push_back({io::unused_material_name(mesh, "dark"), dark});
    }
    mesh.face_materials[face] = part;
  }
  return mesh;
}
}  // namespace tapestry::scenes
