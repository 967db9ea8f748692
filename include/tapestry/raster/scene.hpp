#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/raster/mesh_pictures.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/used_texels.hpp>
#include <vector>

namespace tapestry::raster {

/// A body in a scene.
struct PlacedBody {
  PaintedMesh body;
  geometry::Pose pose{};
};

/// Bodies that hide and shade each other, as one mesh: whatever takes a PaintedMesh, from operators and
/// pictures with all their gradients to occlusion and shadows, takes `whole`.
struct Scene {
  PaintedMesh whole;
  std::vector<std::size_t> first_face;      ///< of each body, then the number of all
  std::vector<std::size_t> first_position;  ///< of each body, then the number of all

  /// The body of a face.
  [[nodiscard]] std::size_t body_of(std::size_t face) const {
    const auto after = std::upper_bound(first_face.begin(), first_face.end(), face);
    return static_cast<std::size_t>(after - first_face.begin()) - 1;
  }

  /// Of one entry a position of `whole`, such as an adjoint, those of one body.
  template <class Entry>
  [[nodiscard]] std::span<const Entry> positions_of(std::size_t body, const std::vector<Entry>& all) const {
    return std::span(all).subspan(first_position[body], first_position[body + 1] - first_position[body]);
  }
};

namespace detail {

/// Puts another body's pictures on the faces from `first_face` on.
inline void append_pictures(MeshPictures& pictures, std::size_t first_face, std::size_t face_count,
                            const MeshPictures* other) {
  pictures.of_face.resize(first_face + face_count, -1);
  if (other == nullptr) return;
  const auto first = static_cast<std::int32_t>(pictures.pictures.size());
  pictures.pictures.insert(pictures.pictures.end(), other->pictures.begin(), other->pictures.end());
  for (std::size_t face = 0; face < other->of_face.size(); ++face)
    if (other->of_face[face] >= 0) pictures.of_face[first_face + face] = first + other->of_face[face];
}

/// Whether two textures have the same texels.
[[nodiscard]] inline bool is_same_layout(const TextureLayout& a, const TextureLayout& b) {
  return a.kind == b.kind && a.height == b.height && a.width == b.width && a.u_extent == b.u_extent &&
         a.texels_per_edge == b.texels_per_edge && a.filter == b.filter && a.most_lookups == b.most_lookups;
}

}  // namespace detail

/// Bodies at their poses, as one. A scene of one body at the pose {} has the bits of that body.
///
/// All painted bodies share one texture: of an atlas or a solid colour they read the same texels; texels of a
/// cube or of vertices follow one another in the order of the bodies. A body to be drawn in its own colours
/// is not painted: all its entries of `painted` are 0.
///
/// \throws DomainError without bodies, for bodies in different colour spaces, or for painted bodies with
///         textures of different layouts; as pyramid_of()
[[nodiscard]] inline Scene scene_of(const std::vector<PlacedBody>& bodies) {
  if (bodies.empty()) throw DomainError("scene_of: expected a body");
  Scene scene{{{}, {}, bodies[0].body.layout, bodies[0].body.space}, {0}, {0}};
  PaintedMesh& whole = scene.whole;
  MeshPictures pictures;
  bool is_painted = false;
  for (const auto& [body, pose] : bodies) {
    if (body.space != whole.space) throw DomainError("scene_of: bodies in different colour spaces");
    if (std::ranges::any_of(body.painted, [](std::uint8_t is_shown) { return is_shown != 0; })) {
      if (is_painted && !detail::is_same_layout(body.layout, whole.layout))
        throw DomainError("scene_of: painted bodies with textures of different layouts");
      whole.layout = body.layout;
      is_painted = true;
    }
    const std::size_t first = whole.mesh.faces.size();
    geometry::append(whole.mesh, geometry::placed(body.mesh, pose));
    whole.painted.insert(whole.painted.end(), body.painted.begin(), body.painted.end());
    detail::append_pictures(pictures, first, body.mesh.faces.size(), body.pictures.get());
    scene.first_face.push_back(whole.mesh.faces.size());
    scene.first_position.push_back(whole.mesh.positions.size());
  }
  if (!pictures.pictures.empty()) whole.pictures = std::make_shared<const MeshPictures>(std::move(pictures));
  whole.pyramid = bodies.size() == 1 ? bodies[0].body.pyramid : pyramid_of(whole);
  return scene;
}

}  // namespace tapestry::raster
