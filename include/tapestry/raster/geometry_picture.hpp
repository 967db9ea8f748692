#pragma once
#include <tapestry/raster/detail/vertex_gradient.hpp>

namespace tapestry::raster {
/// Depth of the surface: z of view space, in units of the world; one channel.
struct Depth {
  static constexpr std::size_t channel_count = 1;
};

/// Position of the surface in the world; channels x, y, z.
struct SurfacePosition {
  static constexpr std::size_t channel_count = 3;
};

/// The unit normal of the face, not of its corners, in the world and on the visible side; channels x, y, z.
struct Normal {
  static constexpr std::size_t channel_count = 3;
};

/// Content of a picture of a mesh's geometry: Depth, SurfacePosition or Normal.
template <class Output>
concept GeometryOutput =
    std::same_as<Output, Depth> || std::same_as<Output, SurfacePosition> || std::same_as<Output, Normal>;

/// Axes of a picture of a mesh's geometry: [H, W] of a depth, [H, W, 3] of the others.
template <GeometryOutput Output>
inline constexpr std::size_t geometry_rank = Output::channel_count == 1 ? 2 : 3;

namespace detail {
/// Stands for a surface's colour in pictures of a mesh's geometry.
template <GeometryOutput Output>
struct ShownGeometry {
  using Colour = std::array<double, Output::channel_count>;

  const geometry::Mesh& mesh;
  const std::vector<geometry::Vector3>& positions_view;
  geometry::Vector3 eye;  ///< the camera's centre in the world

  /// The value at barycentric coordinates b of a face.
  [[nodiscard]] Colour at(std::int32_t face, const std::array<double, 3>& b) const {
    if constexpr (std::same_as<Output, Depth>)
      return {blended(positions_view, face, b)[2]};
    else if constexpr (std::same_as<Output, SurfacePosition>)
      return blended(mesh.positions, face, b);
    else
      return seen_normal(mesh, static_cast<std::size_t>(face), eye);
  }

  /// Whether the value is continuous over an edge between two faces: depth and position are, the normal
  /// jumps.
  [[nodiscard]] static constexpr bool is_continuous() { return !std::same_as<Output, Normal>; }

  [[nodiscard]] bool agrees(const HalfEdge& a, const HalfEdge& b) const {
    if constexpr (is_continuous()) {
      return true;
    } else {
      const auto apart = geometry::subtract(at(a.face, {}), at(b.face, {}));
      return geometry::dot(apart, apart) <= 1e-24;  // rounding of faces in one plane
    }
  }

  /// Growth of ⟨adjoint, value⟩ for each relative growth of the distance along the ray.
  [[nodiscard]] double radial_adjoint(std::int32_t face, const std::array<double, 3>& b,
                                      const Colour& adjoint) const {
    const Colour shown = at(face, b);
    if constexpr (std::same_as<Output, Depth>)
      return adjoint[0] * shown[0];
    else
      return geometry::dot(adjoint, geometry::subtract(shown, eye));
  }

 private:
  /// Σ b·point of the corners.
  [[nodiscard]] geometry::Vector3 blended(const std::vector<geometry::Vector3>& points, std::int32_t face,
                                          const std::array<double, 3>& b) const {
    geometry::Vector3 sum{};
    for (std::size_t k = 0; k < 3; ++k)
      sum = geometry::add(
          sum, geometry::scale(
                   points[static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(face)][k])], b[k]));
    return sum;
  }
};

/// Sums of one face in one band: Σ b_k · radial_adjoint() of each corner k, or, of normals, Σ adjoint.
struct GeometryMoments {
  std::int32_t face;
  geometry::Vector3 sum{};
  std::array<double, 3> place{};  ///< Σ coverage·b
};

/// A ray through a fixed point of the picture meets the face's plane at p. A displacement d of the face
/// there moves p along the ray by the share (n·d)/(n·p) of its distance. As d = Σ b_k·dq_k, each corner
/// gets n/(n·p) times its sum.
inline void add_plane_shares(const geometry::Mesh& mesh, const std::array<geometry::Vector3, 3>& corners,
                             const GeometryMoments& moments, std::vector<VertexShare>& shares) {
  const geometry::Vector3 normal =
      geometry::cross(geometry::subtract(corners[1], corners[0]), geometry::subtract(corners[2], corners[0]));
  const geometry::Vector3 slope = geometry::scale(normal, 1 / geometry::dot(normal, corners[0]));
  if (!geometry::is_finite(slope)) return;  // without area, or edge-on
  for (std::int32_t k = 0; k < 3; ++k)
    shares.push_back(
        {corner_of(mesh, moments.face, k), geometry::scale(slope, moments.sum[static_cast<std::size_t>(k)])});
}

/// The adjoint of a fragment's pixel, times its coverage.
template <GeometryOutput Output, std::floating_point T, std::size_t Rank>
typename ShownGeometry<Output>::Colour fragment_adjoint(const Array<T, Rank>& picture_adjoint,
                                                        const Fragment& fragment) {
  typename ShownGeometry<Output>::Colour adjoint;
  const T* const pixel = picture_adjoint.data() + adjoint.size() * fragment.pixel;
  for (std::size_t c = 0; c < adjoint.size(); ++c)
    adjoint[c] = fragment.coverage * static_cast<double>(pixel[c]);
  return adjoint;
}

/// Adds the contribution of one fragment.
/// \param adjoint  see fragment_adjoint()
template <GeometryOutput Output>
void add_fragment(const ShownGeometry<Output>& shown, const Fragment& fragment,
                  const typename ShownGeometry<Output>::Colour& adjoint, GeometryMoments& moments) {
  auto& [face, sum, place] = moments;
  place = geometry::add(place, geometry::scale(fragment.barycentric, fragment.coverage));
  if constexpr (std::same_as<Output, Normal>)
    sum = geometry::add(sum, adjoint);
  else
    sum = geometry::add(sum,
                        geometry::scale(fragment.barycentric,
                                        shown.radial_adjoint(fragment.face, fragment.barycentric, adjoint)));
}

/// Adds the derivatives of faces' moments, block by block, in order.
/// \param step  see sliver_factor()
template <GeometryOutput Output>
void add_moments(const ShownGeometry<Output>& shown, const geometry::Camera& camera,
                 std::vector<BandMoments<GeometryMoments>>& blocks, const std::array<double, 2>& step,
                 std::vector<geometry::Vector3>& positions_adjoint) {
  std::vector<std::vector<VertexShare>> shares(blocks.size());
  parallel_for(blocks.size(), [&](std::size_t index) {
    for (GeometryMoments& moments : blocks[index].all()) {
      const auto corners = corners_in_view(shown.mesh, shown.positions_view, moments.face);
      moments.sum = geometry::scale(moments.sum, sliver_factor(corners, moments.place, step));
      if constexpr (!std::same_as<Output, Normal>)
        add_plane_shares(shown.mesh, corners, moments, shares[index]);
    }
  });
  add_shares(shares, camera, positions_adjoint);
  if constexpr (std::same_as<Output, Normal>)
    for (const auto& block : blocks)
      for (const GeometryMoments& moments : block.all()) {
        const TurningNormal turning(shown.mesh, shown.eye, moments.face);
        turning.add_adjoint(moments.sum, 1, positions_adjoint);
      }
}

/// Adds the part of the derivative from inside the faces, with outlines held still: exact for the samples
/// that are drawn, except slivers, see sliver_factor().
/// \param left_out  faces that add nothing, in order
/// \returns the faces that are seen where the adjoint is not 0
template <GeometryOutput Output, std::floating_point T, std::size_t Rank>
SeenFaces add_geometry(const ShownGeometry<Output>& shown, const FragmentBands& fragments,
                       const Array<T, Rank>& picture_adjoint, const std::vector<std::int32_t>& left_out,
                       std::vector<geometry::Vector3>& positions_adjoint) {
  std::vector<BandMoments<GeometryMoments>> bands(fragments.band_count());
  SeenFaces seen(fragments.width(), fragments.band_rows(), bands.size());
  parallel_for(bands.size(), [&](std::size_t index) {
    fragments.visit_band(index, FragmentGrain::face, [&](const Fragment& fragment) {
      const auto adjoint = fragment_adjoint<Output>(picture_adjoint, fragment);
      if (std::all_of(adjoint.begin(), adjoint.end(), [](double value) { return value == 0; })) return;
      seen.band(index).add(fragment.pixel, fragment.face);
      if (!std::binary_search(left_out.begin(), left_out.end(), fragment.face))
        add_fragment(shown, fragment, adjoint, bands[index].of(fragment.face));
    });
  });
  add_moments(shown, fragments.camera(), bands, sample_step(fragments), positions_adjoint);
  return seen;
}

/// The same from inside grazing faces, integrated over their visible parts.
/// \pre the field is filled after GrazingSpans::find()
template <GeometryOutput Output, std::floating_point T, std::size_t Rank>
void add_grazing_geometry(const ShownGeometry<Output>& shown, const geometry::Camera& camera,
                          const Array<T, Rank>& picture_adjoint, const GrazingSpans& spans,
                          const FaceField& field, std::vector<geometry::Vector3>& positions_adjoint) {
  std::vector<BandMoments<GeometryMoments>> blocks(spans.face_count());
  parallel_for(blocks.size(), [&](std::size_t index) {
    spans.visit(field, index, [&](const Fragment& fragment) {
      add_fragment(shown, fragment, fragment_adjoint<Output>(picture_adjoint, fragment),
                   blocks[index].of(fragment.face));
    });
  });
  add_moments(shown, camera, blocks, GrazingSpans::sliver_step(field), positions_adjoint);
}
}  // namespace detail

/// Draws the geometry of a mesh: each pixel has the mean over its samples, premultiplied by coverage like
/// pictures of colours. Beside the mesh it is 0; divided by silhouette() it is the mean over the visible
/// mesh. A fragment's value is taken at the mean place of its samples, see texture_operator(). The result is
/// the same for any number of threads.
///
/// \tparam Output  Depth, SurfacePosition or Normal
/// \returns        [H, W] of a depth, else [H, W, 3]; row 0 on top
/// \throws as visibility()
template <GeometryOutput Output, std::floating_point T>
[[nodiscard]] Array<T, geometry_rank<Output>> geometry_picture(const geometry::Mesh& mesh,
                                                               const geometry::Camera& camera,
                                                               std::size_t height, std::size_t width,
                                                               std::size_t samples_per_axis = 4) {
  constexpr std::size_t rank = geometry_rank<Output>;
  const FragmentBands fragments("geometry_picture", mesh, camera, height, width, samples_per_axis);
  const detail::ShownGeometry<Output> shown{mesh, fragments.positions_view(), geometry::eye_of(camera)};
  Extents<rank> extents{};
  extents.fill(Output::channel_count);
  extents[0] = height;
  extents[1] = width;
  auto picture = zeros<T, rank>(extents);
  parallel_for(fragments.band_count(), [&](std::size_t band) {
    fragments.visit_band(band, FragmentGrain::face, [&](const Fragment& fragment) {
      const auto values = shown.at(fragment.face, fragment.barycentric);
      T* const pixel = picture.data() + values.size() * fragment.pixel;
      for (std::size_t c = 0; c < values.size(); ++c)
        pixel[c] += static_cast<T>(fragment.coverage * values[c]);
    });
  });
  return picture;
}

/// Adds ∂L/∂positions, L being a function of geometry_picture(), to positions_adjoint, in units of L per unit
/// of the world. It is the sum of the motion within faces, exact for the samples that are drawn, or along
/// lines that cross them where large planes are seen nearly edge-on, and the integral along outlines; for
/// normals also along every edge where they jump, and where faces cut through each other. Faces edge-on and
/// without area add nothing; those thinner than a tenth of the distance of samples add less than their
/// samples would. Where the mesh is cut by near or far, the cut's own motion is left out. Sums are in double
/// and the same for any number of threads.
///
/// \param picture_adjoint    ∂L/∂picture, [H, W] of a depth, else [H, W, 3]
/// \param positions_adjoint  one entry a position of the mesh
/// \param samples_per_axis   as in the picture; pieces of outlines are at most 1/samples_per_axis pixels long
/// \param edges              mesh_edges() of the mesh, when they are kept from view to view; null: found now
/// \throws ShapeError unless there are so many channels, an entry a position, and edges are the mesh's;
///         otherwise as geometry_picture()
template <GeometryOutput Output, std::floating_point T>
void geometry_picture_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera,
                              const Array<T, geometry_rank<Output>>& picture_adjoint,
                              std::vector<geometry::Vector3>& positions_adjoint,
                              std::size_t samples_per_axis = 4,
                              const std::shared_ptr<const MeshEdges>& edges = nullptr) {
  const char* const operation = "geometry_picture_adjoint";
  const std::size_t height = picture_adjoint.shape(0), width = picture_adjoint.shape(1);
  if constexpr (geometry_rank<Output> == 3)
    require_shape(operation, "picture_adjoint", picture_adjoint, {height, width, Output::channel_count});
  detail::require_positions_adjoint(operation, mesh, positions_adjoint);
  const FragmentBands fragments(operation, mesh, camera, height, width, samples_per_axis);
  const detail::ShownGeometry<Output> shown{mesh, fragments.positions_view(), geometry::eye_of(camera)};
  const auto own_edges = detail::edges_of(operation, mesh, edges);
  FacesInView faces(mesh, fragments.positions_view(), camera, height, width);
  const auto grazing = detail::grazing_faces(faces, 1 / static_cast<double>(samples_per_axis));
  detail::GrazingSpans spans(grazing);
  const auto seen = detail::add_geometry(shown, fragments, picture_adjoint, grazing, positions_adjoint);
  // Where faces cut through each other, they are equally far.
  const FaceField field =
      detail::add_boundaries(camera, shown, picture_adjoint, samples_per_axis, *own_edges, seen,
                             std::same_as<Output, Normal>, faces, spans, positions_adjoint);
  detail::add_grazing_geometry(shown, camera, picture_adjoint, spans, field, positions_adjoint);
}
}  // namespace tapestry::raster
