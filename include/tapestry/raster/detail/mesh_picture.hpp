#pragma once
#include <tapestry/raster/detail/atlas_filter.hpp>

namespace tapestry::raster {
/// A picture that belongs to a mesh, as its faces look it up.
struct MeshPicture {
  TextureLayout layout;                 ///< an atlas of u_extent 1
  Array<float, 2> texels;               ///< [texel, 3], in the body's colour space, of all levels if filtered
  std::optional<AtlasFilter> filter{};  ///< of a filtered layout
};

/// Pictures of a mesh's faces. They show where a body is not painted, in place of the materials' colours.
/// Made by add_picture().
struct MeshPictures {
  std::vector<MeshPicture> pictures;
  std::vector<std::int32_t> of_face;  ///< index into pictures, −1 for none; one entry a face

  /// The picture of a face; null for none.
  [[nodiscard]] const MeshPicture* at(std::size_t face) const {
    const std::int32_t index = face < of_face.size() ? of_face[face] : -1;
    return index < 0 ? nullptr : &pictures[static_cast<std::size_t>(index)];
  }
};

/// The picture that a body's face shows where it is not painted; null for none.
[[nodiscard]] inline const MeshPicture* picture_of_face(const PaintedMesh& body, std::size_t face) {
  return body.pictures ? body.pictures->at(face) : nullptr;
}
}  // namespace tapestry::raster
