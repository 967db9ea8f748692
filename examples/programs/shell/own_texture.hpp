#pragma once
#include <map>
#include <tapestry/io/image_file.hpp>
#include <tapestry/raster/mesh_pictures.hpp>
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

/// The textures of a mesh, that on most faces first. One that is much larger than pictures of cars is halved;
/// one that cannot be read is left out, with a warning. Materials no longer name a texture that is left out.
inline std::vector<OwnTexture> own_textures(geometry::Mesh& mesh, std::vector<std::string>& warnings) {
  std::map<std::string, std::size_t> face_counts;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    if (const std::string texture = texture_of(mesh, face); !texture.empty()) ++face_counts[texture];
  std::vector<OwnTexture> textures;
  for (const auto& [path, count] : face_counts) {
    try {
      OwnTexture own{path, io::read_texture(path, &warnings), {}};
      while (std::min(own.picture.shape(0), own.picture.shape(1)) > 2048) own.picture = halved(own.picture);
      for (std::size_t face = 0; face < mesh.faces.size(); ++face)
        own.faces.push_back(texture_of(mesh, face) == path ? 1 : 0);
      textures.push_back(std::move(own));
    } catch (const FileError& error) {
      warnings.push_back(std::string(error.what()) + "; colours (Kd) stand in for this texture");
    }
  }
  std::ranges::stable_sort(textures, std::ranges::greater{},
                           [&](const OwnTexture& own) { return face_counts[own.path]; });
  for (auto& material : mesh.materials)
    if (std::ranges::count(textures, material.texture, &OwnTexture::path) == 0) material.texture.clear();
  return textures;
}

/// Textures as pictures of the mesh; null for none.
/// \param first  the first that counts
inline std::shared_ptr<const raster::MeshPictures> pictures_of(const std::vector<OwnTexture>& textures,
                                                               const geometry::Mesh& mesh,
                                                               raster::TextureFilter filter,
                                                               image::ColourSpace space,
                                                               std::size_t first = 0) {
  if (first >= textures.size()) return nullptr;
  auto pictures = std::make_shared<raster::MeshPictures>();
  for (std::size_t i = first; i < textures.size(); ++i)
    raster::add_picture(*pictures, mesh, textures[i].picture, textures[i].faces, filter, space);
  return pictures;
}
}  // namespace tapestry::shell
