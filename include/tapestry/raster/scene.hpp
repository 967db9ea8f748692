#pragma once
#include <tapestry/geometry/pose.hpp>
#include <tapestry/raster/mesh_pictures.hpp>
#include <tapestry/raster/outdoor_light.hpp>

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
  std::vector<std::size_t> first_face;      ///< first face of each body, then the number of all
  std::vector<std::size_t> first_position;  ///< first position of each body, then the number of all

  /// The body of a face.
  [[nodiscard]] std::size_t body_of(std::size_t face) const {
    const auto after = std::upper_bound(first_face.begin(), first_face.end(), face);
    return static_cast<std::size_t>(after - first_face.begin()) - 1;
  }

  /// Entries of one body's positions, out of one entry a position of `whole`, such as an adjoint.
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
}  // namespace detail

/// Bodies at their poses, as one. A scene of one body at the pose {} has the bits of that body.
///
/// All painted bodies share one texture: of an atlas or a solid colour they read the same texels; texels of a
/// cube or of vertices follow one another in the order of the bodies. A body to be drawn in its own colours
/// is not painted: all its entries of `painted` are 0.
///
/// \throws DomainError without bodies, for bodies in different colour spaces, or for painted bodies with
///         textures of different layouts; ShapeError unless each has an entry of `painted` a face; as
///         pyramid_of()
[[nodiscard]] inline Scene scene_of(const std::vector<PlacedBody>& bodies) {
  if (bodies.empty()) throw DomainError("scene_of: expected a body");
  Scene scene{{{}, {}, bodies[0].body.layout, bodies[0].body.space}, {0}, {0}};
  PaintedMesh& whole = scene.whole;
  MeshPictures pictures;
  bool is_painted = false;
  for (const auto& [body, pose] : bodies) {
    if (body.painted.size() != body.mesh.faces.size())
      throw ShapeError({"scene_of: painted is [", body.painted.size(), "], expected [",
                        body.mesh.faces.size(), "], one entry a face"});
    if (body.space != whole.space) throw DomainError("scene_of: bodies in different colour spaces");
    if (std::ranges::any_of(body.painted, [](std::uint8_t is_shown) { return is_shown != 0; })) {
      if (is_painted && !body.layout.fits(whole.layout))
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

/// Level ground below bodies.
struct Ground {
  double height = 0;                 ///< z
  double reach = 3;                  ///< half the side of the computed square, in longest sides of the bodies
  std::size_t cells = 96;            ///< of that square along a side, 2 to 1024
  std::size_t directions = 256;      ///< see ambient_occlusion()
  std::size_t shadow_pixels = 1024;  ///< of the square in the view from the sun
};

/// Shade of bodies on the ground: the contact shadow below them, where they hide the sky, and the sun's
/// shadow.
class GroundShade {
 public:
  /// Bakes the part of the sky that bodies hide from the ground.
  /// \throws DomainError for bodies without extent, a reach that is not above 0, or numbers out of range
  explicit GroundShade(const geometry::Mesh& bodies, const Ground& ground = {});

  /// Share of its light that the ground keeps in a view,
  ///
  ///   (sun · L_z · V + A · E/π) / (sun · L_z + E/π),
  ///
  /// V and A being the visible shares of sun and sky, E the sky's irradiance from above; 1 where the ground
  /// is not seen, or beyond its reach. Multiplying a photograph of empty ground by it, in proportion to
  /// light, gives the ground below the bodies.
  ///
  /// \param light  its occlusion and shadow are not read
  /// \returns      [height, width]
  /// \throws DomainError as prepare() of the light, and as visibility()
  [[nodiscard]] Array<float, 2> operator()(const OutdoorLight& light, const geometry::Camera& camera,
                                           std::size_t height, std::size_t width,
                                           std::size_t samples_per_axis = 2) const;

 private:
  geometry::Mesh ground_;
  geometry::Mesh whole_;  ///< ground_, then the bodies
  std::shared_ptr<const AmbientOcclusion> occlusion_;
  std::size_t shadow_pixels_;
};
}  // namespace tapestry::raster
