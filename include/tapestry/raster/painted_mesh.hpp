#pragma once
#include <tapestry/raster/mip_pyramid.hpp>

/// \file
/// The first header of raster/: pictures of meshes, and their derivatives.
///
/// A fragment is the part of one face in one pixel. The colour of a pixel, premultiplied with coverage, is
///
///   p = Σ over its fragments of  coverage · light · Σ over texels of  weight · texel
///
/// For one view this is linear in the texels, p = A·t, so the gradient by the texels is exactly Aᵀ·p̄. With
/// positions, pose or camera the outlines move as well, see vertex_gradient.hpp.
///
///   PaintedMesh, camera --> visibility --> fragments --+--> texture_operator   keeps A for many paints
///                                                      +--> render_textured    draws once, keeps nothing
///                                                      +--> render_variable    on the tape, all derivatives
///
/// Read next: texture_layout.hpp, visibility.hpp, fragments.hpp, light.hpp, texture_operator.hpp.

namespace tapestry::raster {
struct MeshPictures;

/// A mesh and the faces of it that a texture covers; the others keep their material's colour or picture.
struct PaintedMesh {
  geometry::Mesh mesh;
  std::vector<std::uint8_t> painted;  ///< one entry a face, 1 where the texture shows
  TextureLayout layout;               ///< of the texture, whose texels are an array of their own
  /// Space for drawing pictures. Texels that go to a rasteriser are in it already, see image::in_space(); the
  /// materials' colours are encoded, and the rasteriser converts them.
  image::ColourSpace space = image::ColourSpace::encoded;
  /// Pyramid of a filtered atlas, for stored_texels(), which computes the texels that operators take.
  std::shared_ptr<const MipPyramid> pyramid{};
  std::shared_ptr<const MeshPictures> pictures{};  ///< the mesh's own, by face, see add_picture(); or null
};

/// The colours of a mesh's faces that are not painted, in its colour space.
class OwnColours {
 public:
  explicit OwnColours(const PaintedMesh& body) : mesh_(body.mesh), is_linear_(body.space == linear) {
    if (!is_linear_) return;
    for (const auto& material : body.mesh.materials) of_material_.push_back(light_of(material.colour));
  }

  [[nodiscard]] std::array<float, 3> operator[](std::size_t face) const {
    if (!is_linear_) return geometry::material_colour(mesh_, face);
    const std::int32_t material = face < mesh_.face_materials.size() ? mesh_.face_materials[face] : -1;
    const bool known = material >= 0 && static_cast<std::size_t>(material) < of_material_.size();
    return known ? of_material_[static_cast<std::size_t>(material)] : of_none_;
  }

 private:
  static constexpr auto linear = image::ColourSpace::linear;

  static std::array<float, 3> light_of(std::array<float, 3> colour) {
    for (float& channel : colour) channel = image::linearised(channel);
    return colour;
  }

  const geometry::Mesh& mesh_;
  bool is_linear_;
  std::vector<std::array<float, 3>> of_material_;
  std::array<float, 3> of_none_ = light_of(geometry::Material{}.colour);
};
}  // namespace tapestry::raster
