#pragma once
#include <tapestry/raster/detail/vertex_gradient/intersections.hpp>
#include <tapestry/raster/detail/vertex_gradient/outlines.hpp>
#include <tapestry/raster/detail/vertex_gradient/pixel_map.hpp>

namespace tapestry::raster {
/// The derivative of the box-filtered picture: the motion inside faces, sampled as the picture is, or along
/// lines that cross them where large planes are seen nearly edge-on, see grazing_faces(); plus the integral
/// over all visible outlines, creases between colours and lines of intersection. A line of intersection
/// shorter than the distance of samples is left out, see crossing_faces().
struct BoundaryIntegral {
  /// For the interior and the search for intersecting faces; pieces of outlines are at most 1 / this long.
  std::size_t samples_per_axis = 4;
  bool intersections = true;  ///< whether sampled faces are searched for intersections
  /// mesh_edges() of the mesh, when they are kept from view to view; null: they are found by every call.
  std::shared_ptr<const MeshEdges> edges{};
};

/// The motion inside faces only, with constant outlines: the gradient of rasterisers that treat visibility as
/// constant. Keeps a fifth to a third of the derivative.
struct InteriorOnly {
  std::size_t samples_per_axis = 4;
};

/// The hand-made gradient of Neural Mesh Renderer, for comparison: its sign is usable, but it is 4 to 54
/// times too large. The source moves outlines only; with `interior` the motion inside faces is added.
struct NeuralMeshRenderer {
  std::size_t samples_per_axis = 1;  ///< 2 is its anti-aliasing
  bool interior = false;
};

namespace detail {
void require_positions_adjoint(const char* operation, const geometry::Mesh& mesh,
                               const std::vector<geometry::Vector3>& positions_adjoint);

/// Maps (column, row) to the adjoints of the pixel's channels there; a picture [H, W] has one channel.
template <std::floating_point T, std::size_t Rank>
auto pixel_adjoint(const Array<T, Rank>& adjoint) {
  return [&adjoint, height = adjoint.shape(0), width = adjoint.shape(1)](double column, double row) {
    const std::size_t i = std::min(static_cast<std::size_t>(std::max(row, 0.0)), height - 1);
    const std::size_t j = std::min(static_cast<std::size_t>(std::max(column, 0.0)), width - 1);
    std::array<double, Rank == 3 ? 3 : 1> values;
    const T* const pixel = adjoint.data() + values.size() * (i * width + j);
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = static_cast<double>(pixel[c]);
    return values;
  };
}

/// The edges that the caller has kept, or newly found ones.
/// \throws ShapeError if they are of another mesh
[[nodiscard]] std::shared_ptr<const MeshEdges> edges_of(const char* operation, const geometry::Mesh& mesh,
                                                        std::shared_ptr<const MeshEdges> kept);

/// Leaves out the faces of one closed surface that turn their inner side to the camera, if the picture's
/// samples show no inner side: these faces and the edges between them lie behind others. Not done where near
/// may cut the surface open. It assumes that the surface does not pass through itself.
void leave_out_inner_sides(const MeshEdges& edges, const SeenFaces& seen,
                           const std::vector<geometry::Vector3>& positions_view,
                           const geometry::Camera& camera, FacesInView& faces);

/// The integral over all boundaries between colours.
/// \param edges    of the mesh
/// \param seen     the faces that samples see where the adjoint is not 0; none: not known
/// \param has_intersections  whether these are searched for intersections
/// \param adjoint  of the picture, [H, W, 3], or [H, W] for a Colour of one channel
/// \param faces    of the view
/// \param spans    of grazing faces, to find
/// \returns the field of all lines; `faces` and `seen` must outlive it
template <std::floating_point T, std::size_t Rank, class Colour>
FaceField add_boundaries(const geometry::Camera& camera, const Colour& colour, const Array<T, Rank>& adjoint,
                         std::size_t samples_per_axis, const MeshEdges& edges, const SeenFaces& seen,
                         bool has_intersections, FacesInView& faces, GrazingSpans& spans,
                         std::vector<geometry::Vector3>& positions_adjoint) {
  leave_out_inner_sides(edges, seen, faces.positions_view(), camera, faces);
  FaceField field(faces, seen, camera);
  const double longest_piece = 1 / static_cast<double>(samples_per_axis);
  const BoundaryScene scene{faces.mesh(), edges,  faces.positions_view(), field,
                            camera,       colour, pixel_adjoint(adjoint), longest_piece};
  Outlines outlines(scene);
  Intersections intersections(
      scene, has_intersections ? crossing_faces(faces.mesh(), edges, seen) : std::vector<FacePair>{});
  outlines.find(field);
  intersections.find(field);
  spans.find(field);
  field.fill();
  outlines.add_to(positions_adjoint);
  intersections.add_to(positions_adjoint);
  return field;
}

template <std::floating_point T, class Model, class Colour>
void add_sampled_motion(const Surface<T, Model>& surface, const Colour& colour,
                        const FragmentBands& fragments, const Array<T, 3>& render_adjoint,
                        const MotionAdjoint& positions_adjoint, const InteriorOnly&) {
  add_interior(surface, colour, fragments, render_adjoint, positions_adjoint, {});
}

template <std::floating_point T, class Model, class Colour>
void add_sampled_motion(const Surface<T, Model>& surface, const Colour& colour,
                        const FragmentBands& fragments, const Array<T, 3>& render_adjoint,
                        const MotionAdjoint& positions_adjoint, const BoundaryIntegral& model) {
  const auto edges = edges_of("vertex_adjoint", surface.body.mesh, model.edges);
  FacesInView faces(surface.body.mesh, fragments.positions_view(), fragments.camera(), fragments.height(),
                    fragments.width());
  const auto grazing = grazing_faces(faces, 1 / static_cast<double>(model.samples_per_axis));
  GrazingSpans spans(grazing);
  const auto seen = add_interior(surface, colour, fragments, render_adjoint, positions_adjoint, grazing);
  const FaceField field =
      add_boundaries(fragments.camera(), colour, render_adjoint, model.samples_per_axis, *edges, seen,
                     model.intersections, faces, spans, *positions_adjoint.moving);
  add_grazing_interior(surface, colour, fragments, render_adjoint, positions_adjoint, spans, field);
}

/// Adds the gradient of a view that is already drawn.
template <std::floating_point T, class Model, class Gradient>
void add_motion(const Surface<T, Model>& surface, const FragmentBands& fragments,
                const Array<T, 3>& render_adjoint, const MotionAdjoint& positions_adjoint,
                const Gradient& model) {
  const auto colour = surface_colour("vertex_adjoint", surface, fragments.camera());
  add_sampled_motion(surface, colour, fragments, render_adjoint, positions_adjoint, model);
}

template <std::floating_point T, class Model, class Gradient>
void add_motion(const Surface<T, Model>& surface, const geometry::Camera& camera,
                const Array<T, 3>& render_adjoint, const MotionAdjoint& positions_adjoint,
                const Gradient& model) {
  const auto colour = surface_colour("vertex_adjoint", surface, camera);
  const FragmentBands fragments("vertex_adjoint", surface.body.mesh, camera, render_adjoint.shape(0),
                                render_adjoint.shape(1), model.samples_per_axis);
  add_sampled_motion(surface, colour, fragments, render_adjoint, positions_adjoint, model);
}

template <std::floating_point T, class Model>
void add_motion(const Surface<T, Model>& surface, const geometry::Camera& camera,
                const Array<T, 3>& render_adjoint, const MotionAdjoint& positions_adjoint,
                const NeuralMeshRenderer& model) {
  const geometry::Mesh& mesh = surface.body.mesh;
  const auto colour = surface_colour("vertex_adjoint", surface, camera);
  const auto positions_view = positions_in_view(mesh, camera);
  const std::size_t axis = model.samples_per_axis;
  const auto buffer = visibility(mesh, camera, render_adjoint.shape(0), render_adjoint.shape(1), axis);
  const auto colours = sample_colours(mesh, positions_view, camera, buffer, colour);
  std::vector<std::array<double, 3>> adjoints(colours.size());
  const std::size_t columns = buffer.width * axis;
  for (std::size_t i = 0; i < adjoints.size(); ++i) {
    const std::size_t pixel = i / columns / axis * buffer.width + i % columns / axis;
    for (std::size_t c = 0; c < 3; ++c)
      adjoints[i][c] =
          static_cast<double>(render_adjoint.data()[3 * pixel + c]) / static_cast<double>(axis * axis);
  }
  PixelMap(mesh, positions_view, camera, buffer, colours, adjoints).add_to(*positions_adjoint.moving);
  if (model.interior) add_motion(surface, camera, render_adjoint, positions_adjoint, InteriorOnly{axis});
}
}  // namespace detail

/// Adds ∂L/∂positions, L being a function of the picture of a surface by render(), to positions_adjoint, in
/// units of L per unit of the world. Sums are in double and the same for any number of threads.
///
/// The picture is premultiplied by its coverage: beside the mesh it is 0. Flat light turns with its faces;
/// the normals of smooth light are constant. At a seam of duplicated vertices each side receives half.
/// Where the mesh is cut by near or far, the cut's own motion is left out. A face thinner in the picture
/// than a tenth of the distance of samples counts less than its samples would, since it would outweigh all
/// others: see sliver_factor().
///
/// \param render_adjoint     ∂L/∂picture, [H, W, 3]
/// \param positions_adjoint  one entry a position of the mesh
/// \param model              BoundaryIntegral, InteriorOnly or NeuralMeshRenderer
/// \throws ShapeError, DomainError, Error as visibility() and texture_operator() do; DomainError for a
///         filtered atlas; ShapeError if the model's edges are of another mesh
template <std::floating_point T, class Model, class Gradient = BoundaryIntegral>
void vertex_adjoint(const Surface<T, Model>& surface, const geometry::Camera& camera,
                    const Array<T, 3>& render_adjoint, std::vector<geometry::Vector3>& positions_adjoint,
                    const Gradient& model = {}) {
  require_shape("vertex_adjoint", "render_adjoint", render_adjoint,
                {render_adjoint.shape(0), render_adjoint.shape(1), 3});
  detail::require_positions_adjoint("vertex_adjoint", surface.body.mesh, positions_adjoint);
  detail::add_motion(surface, camera, render_adjoint, {&positions_adjoint, &positions_adjoint}, model);
}

/// The same for a drawn view, see drawn_view(): it is not drawn again.
/// \param view  of the surface's mesh, with the adjoint's size and the model's samples
/// \throws ShapeError also if the view is of another size or other samples; DomainError if positions have
///         moved since it was drawn, or the kind of texture is another
template <std::floating_point T, class Model, class Gradient = BoundaryIntegral>
requires(!std::same_as<Gradient, NeuralMeshRenderer>) void vertex_adjoint(
    const Surface<T, Model>& surface, const FragmentBands& view, const Array<T, 3>& render_adjoint,
    std::vector<geometry::Vector3>& positions_adjoint, const Gradient& model = {}) {
  require_shape("vertex_adjoint", "render_adjoint", render_adjoint, {view.height(), view.width(), 3});
  detail::require_positions_adjoint("vertex_adjoint", surface.body.mesh, positions_adjoint);
  if (view.samples_per_axis() != model.samples_per_axis || &view.mesh() != &surface.body.mesh)
    throw ShapeError({"vertex_adjoint: expected a view of the surface's mesh with ", model.samples_per_axis,
                      " samples an axis, found ", view.samples_per_axis(), " or another mesh"});
  detail::require_view_of("vertex_adjoint", surface.body, view);
  detail::add_motion(surface, view, render_adjoint, {&positions_adjoint, &positions_adjoint}, model);
}
}  // namespace tapestry::raster
