#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/image_file.hpp>
#include <vector>

#include "contact_sheet.hpp"

namespace tapestry::shell {

/// A texture that belongs to a mesh (map_Kd).
struct OwnTexture {
  std::string path;
  Bitmap picture;
  std::vector<std::uint8_t> faces;  ///< one entry a face, 1 where it shows
};

/// The texture of a face's material; empty for none, and where the face has no texture coordinates.
inline std::string texture_of(const geometry::Mesh& mesh, std::size_t face) {
  const std::int32_t material = face < mesh.face_materials.size() ? mesh.face_materials[face] : -1;
  const bool is_known = material >= 0 && static_cast<std::size_t>(material) < mesh.materials.size();
  if (!is_known || face >= mesh.face_uvs.size() || std::ranges::min(mesh.face_uvs[face]) < 0) return {};
  return mesh.materials[static_cast<std::size_t>(material)].texture;
}

/// The texture of a mesh; if there are several, the one on most faces.
/// \returns nothing if there is none or it cannot be read; the latter adds a warning
inline std::optional<OwnTexture> own_texture(const std::string& mesh_path, const geometry::Mesh& mesh,
                                             std::vector<std::string>& warnings) {
  std::map<std::string, std::size_t> face_counts;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    if (const std::string texture = texture_of(mesh, face); !texture.empty()) ++face_counts[texture];
  if (face_counts.empty()) return std::nullopt;
  const std::string path =
      std::ranges::max_element(face_counts, {}, [](const auto& entry) { return entry.second; })->first;
  OwnTexture own;
  try {
    own.path = path;
    own.picture = io::read_image(path, &warnings);
  } catch (const FileError& error) {
    warnings.push_back(std::string(error.what()) + "; colours (Kd) stand in for this texture");
    return std::nullopt;
  }
  if (face_counts.size() > 1)
    warnings.push_back(mesh_path + ": of " + std::to_string(face_counts.size()) + " textures (map_Kd) " +
                       path + " is drawn; colours (Kd) stand in for the others");
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    own.faces.push_back(texture_of(mesh, face) == path ? 1 : 0);
  return own;
}

}  // namespace tapestry::shell
