#pragma once
#include <tapestry/raster/detail/mesh_picture.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/lighting.hpp>

namespace tapestry::raster {
namespace detail {
inline void require_uvs(const char* operation, const geometry::Mesh& mesh,
                        const std::vector<std::uint8_t>& painted) {
  const auto require_face = [&](std::size_t face) {
    const auto complain = [&](const std::string& what) {
      throw Error(ErrorKind::mismatch, {operation, ": face ", face, " is painted from an atlas but ", what});
    };
    if (face >= mesh.face_uvs.size()) complain("has no uv");
    for (const std::int32_t uv : mesh.face_uvs[face]) {
      if (uv < 0) complain("has no uv");
      if (static_cast<std::size_t>(uv) >= mesh.uvs.size())
        complain("refers to uv " + std::to_string(uv) + " of " + std::to_string(mesh.uvs.size()));
      const auto& [u, v] = mesh.uvs[static_cast<std::size_t>(uv)];
      if (!(std::abs(u) <= 1e9) || !(std::abs(v) <= 1e9))
        complain("has a uv that is not finite or beyond 1e9");
    }
  };
  parallel_for_blocks(painted.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t face = begin; face < end; ++face)
      if (painted[face] != 0) require_face(face);
  });
}

inline void require_layout(const char* operation, const PaintedMesh& body) {
  const auto& [mesh, painted, layout, space, pyramid, pictures] = body;
  const std::string name = operation;
  if (pictures && pictures->of_face.size() != mesh.faces.size())
    throw ShapeError(
        {name, ": pictures are of ", pictures->of_face.size(), " faces, expected ", mesh.faces.size()});
  if (painted.size() != mesh.faces.size())
    throw ShapeError(
        {name, ": painted is [", painted.size(), "], expected [", mesh.faces.size(), "], one entry a face"});
  constexpr std::size_t size_limit = 1U << 16U;
  if (layout.traits().is_by_face) {
    if (layout.texels_per_edge == 0 || layout.texels_per_edge > 256)
      throw DomainError({name, ": texels_per_edge must be 1 to 256"});
  } else if (layout.traits().is_picture) {
    if (layout.height == 0 || layout.width == 0 || layout.height > size_limit || layout.width > size_limit)
      throw DomainError({name, ": an atlas must have 1 to 65536 rows and columns"});
    if (!(layout.u_extent > 0 && layout.u_extent <= 1e6))
      throw DomainError({name, ": u_extent must be in (0, 1e6]"});
    if (layout.most_lookups == 0 || layout.most_lookups > 64)
      throw DomainError({name, ": most_lookups must be 1 to 64"});
    require_uvs(operation, mesh, painted);
  }
  if (stored_texel_count(layout, mesh) >= std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::limit, {name, ": the texture has more than 4294967294 texels"});
}

/// Everything needed to turn the fragments of a view into entries. `Lighting` is the result of prepare() for
/// a light.
template <class Lighting>
struct FragmentShader {
  const PaintedMesh& body;
  const Lighting& lighting;
  const std::vector<geometry::Vector3>& positions_view;
  const geometry::Camera& camera;
  std::array<double, 2> picture_size;   ///< height, width
  OwnColours own_colours;               ///< of faces that are not painted
  std::optional<AtlasFilter> filter{};  ///< of a filtered atlas

  /// Appends the taps of a painted fragment, weighted by coverage and light.
  void add_taps(const Fragment& fragment, std::vector<Tap>& taps) const {
    const double scale = fragment.coverage * light_of(fragment);
    visit_taps(fragment, [&](const Tap& tap) { taps.push_back({tap.texel, tap.weight * scale}); });
  }

  /// The light's factor, before its colour.
  [[nodiscard]] double light_of(const Fragment& fragment) const {
    return lighting.at(static_cast<std::size_t>(fragment.face), fragment.barycentric);
  }

  /// The pixel of a photograph that a fragment without paint shows; null: its own colour in the light.
  [[nodiscard]] const float* photographed(const Fragment& fragment) const {
    if constexpr (PhotographedLighting<Lighting>)
      if (body.painted[static_cast<std::size_t>(fragment.face)] == 0)
        return lighting.unpainted(fragment.pixel);
    return nullptr;
  }

  /// Calls visit(Tap) for the taps of a painted fragment, whose weights sum to 1.
  template <class Visit>
  void visit_taps(const Fragment& fragment, Visit visit) const {
    const auto face = static_cast<std::size_t>(fragment.face);
    if (!filter) return raster::visit_taps(body.layout, body.mesh, face, fragment.barycentric, visit);
    const FaceInAtlas map = face_in_atlas(face);
    filter->visit_taps(map.place(fragment.barycentric), steps_of(fragment, map), visit);
  }

  /// Colour of a fragment that is not painted, before the light.
  [[nodiscard]] std::array<double, 3> own_colour(const Fragment& fragment) const {
    const auto face = static_cast<std::size_t>(fragment.face);
    std::array<double, 3> colour{0, 0, 0};
    const MeshPicture* const picture = picture_of_face(body, face);
    if (picture == nullptr) {
      const auto material = own_colours[face];
      std::copy(material.begin(), material.end(), colour.begin());
      return colour;
    }
    const auto add = [&](const Tap& tap) {
      for (std::size_t c = 0; c < 3; ++c)
        colour[c] += tap.weight * static_cast<double>(picture->texels(tap.texel, c));
    };
    if (!picture->filter) {
      visit_atlas_taps(picture->layout, uv_of_point(body.mesh, face, fragment.barycentric), add);
      return colour;
    }
    const FaceInAtlas map = face_in_atlas(face, picture->layout);
    picture->filter->visit_taps(map.place(fragment.barycentric), steps_of(fragment, map), add);
    return colour;
  }

  /// The map from a painted face's points to an atlas.
  [[nodiscard]] FaceInAtlas face_in_atlas(std::size_t face) const { return face_in_atlas(face, body.layout); }

  /// The same for an atlas of another layout, with the same uvs.
  [[nodiscard]] FaceInAtlas face_in_atlas(std::size_t face, const TextureLayout& layout) const {
    std::array<geometry::Vector3, 3> corners;
    std::array<std::array<double, 2>, 3> corner_uvs;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = positions_view[static_cast<std::size_t>(body.mesh.faces[face][k])];
      corner_uvs[k] = body.mesh.uvs[static_cast<std::size_t>(body.mesh.face_uvs[face][k])];
    }
    return {corners, corner_uvs, layout, camera, picture_size[0], picture_size[1]};
  }

  /// Footprint of a fragment in an atlas: a fragment that fills a part of its pixel has that part of the
  /// footprint.
  [[nodiscard]] static AtlasSteps steps_of(const Fragment& fragment, const FaceInAtlas& map) {
    return map.steps(fragment.barycentric, fragment.coverage < 1 ? std::sqrt(fragment.coverage) : 1);
  }
};

/// Fragments collected for a lookup together in a filtered atlas.
template <class Lighting>
class FilteredFragments {
 public:
  explicit FilteredFragments(const FragmentShader<Lighting>& shader) : shader_(shader) {}

  /// \pre not full
  void add(const Fragment& fragment) {
    if (fragment.face != face_) {
      face_ = fragment.face;
      map_.emplace(shader_.face_in_atlas(static_cast<std::size_t>(face_)));
    }
    const auto place = map_->place(fragment.barycentric);
    const AtlasSteps steps = shader_.steps_of(fragment, *map_);
    for (std::size_t axis = 0; axis < place.size(); ++axis) batch.place[axis][count] = place[axis];
    for (std::size_t i = 0; i < steps.size(); ++i) batch.steps[i][count] = steps[i];
    ++count;
  }

  [[nodiscard]] bool is_full() const { return count == LookupBatch::size; }

  LookupBatch batch;
  std::size_t count = 0;

 private:
  const FragmentShader<Lighting>& shader_;
  std::int32_t face_ = -1;
  std::optional<FaceInAtlas> map_{};  // of that face
};

/// \param body       must outlive the shader
/// \param fragments  of the same mesh and camera
template <class Lighting>
[[nodiscard]] FragmentShader<Lighting> make_shader(const PaintedMesh& body, const Lighting& lighting,
                                                   const FragmentBands& fragments,
                                                   const geometry::Camera& camera, std::size_t height,
                                                   std::size_t width) {
  FragmentShader<Lighting> shader{body,
                                  lighting,
                                  fragments.positions_view(),
                                  camera,
                                  {static_cast<double>(height), static_cast<double>(width)},
                                  OwnColours(body)};
  if (is_filtered(body.layout)) shader.filter.emplace(body);
  if constexpr (PhotographedLighting<Lighting>) lighting.require_size(height, width);
  return shader;
}

/// The grain for a layout: cubes are looked up at every sample.
[[nodiscard]] inline FragmentGrain grain_of(const TextureLayout& layout) {
  return layout.traits().is_by_face ? FragmentGrain::sample : FragmentGrain::face;
}

/// \throws DomainError unless a view that keeps its fragments belongs to this body as it is now
inline void require_view_of(const char* operation, const PaintedMesh& body, const FragmentBands& view) {
  if (!view.kept_grain()) return;
  const geometry::Mesh& drawn = view.mesh();
  bool fits = *view.kept_grain() == grain_of(body.layout) &&
              drawn.positions.size() == body.mesh.positions.size() &&
              (&drawn == &body.mesh || drawn.faces == body.mesh.faces);
  if (fits) {
    const auto is_near = [&](const geometry::Vector3& position, const geometry::Vector3& then) {
      const geometry::Vector3 now = geometry::view_from_world(view.camera(), position);
      const geometry::Vector3 moved = geometry::subtract(now, then);
      return !(geometry::dot(moved, moved) > 1e-18 * (1 + geometry::dot(now, now)));
    };
    fits = std::equal(body.mesh.positions.begin(), body.mesh.positions.end(), view.positions_view().begin(),
                      is_near);
  }
  if (!fits)
    throw DomainError(
        {operation,
         ": the view was drawn of another mesh, before its positions moved, or for another kind "
         "of texture; draw it anew"});
}
}  // namespace detail

/// Draws a view of a painted mesh and keeps its fragments, once for both its picture, by render_textured(),
/// and its gradient, by vertex_adjoint(). It has the bits of drawing anew. The mesh must outlive the view.
/// \throws as texture_operator()
[[nodiscard]] inline FragmentBands drawn_view(const PaintedMesh& body, const geometry::Camera& camera,
                                              std::size_t height, std::size_t width,
                                              std::size_t samples_per_axis = 4) {
  return {"drawn_view", body.mesh, camera, height, width, samples_per_axis, detail::grain_of(body.layout)};
}
}  // namespace tapestry::raster
