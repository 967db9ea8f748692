#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/raster/face_field.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <tapestry/raster/surface.hpp>
#include <tapestry/raster/vertex_gradient/boundary_scene.hpp>
#include <tapestry/raster/vertex_gradient/interior.hpp>
#include <tapestry/raster/vertex_gradient/intersections.hpp>
#include <tapestry/raster/vertex_gradient/outlines.hpp>
#include <tapestry/raster/vertex_gradient/pixel_map.hpp>
#include <tapestry/raster/visibility.hpp>
#include <vector>

namespace tapestry::raster {

/// The derivative of the box-filtered picture: what moves inside faces, sampled as the picture is, plus the
/// integral over all visible outlines, creases between colours and lines of intersection, whatever their
/// width.
struct BoundaryIntegral {
  std::size_t samples_per_axis = 4;  ///< of the interior; pieces of outlines are at most its inverse long
  bool intersections = true;         ///< whether faces that cut through each other are looked for
};

/// Only what moves inside faces, outlines held still: the gradient of rasterisers that treat visibility as
/// constant. Keeps a fifth to a third of the derivative.
struct InteriorOnly {
  std::size_t samples_per_axis = 4;
};

/// The hand-made gradient of Neural Mesh Renderer, for comparison: of usable sign but 4 to 54 times too
/// large. The source moves outlines only; with `interior` what moves inside faces is added.
struct NeuralMeshRenderer {
  std::size_t samples_per_axis = 1;  ///< 2 is its anti-aliasing
  bool interior = false;
};

namespace detail {

template <std::floating_point T, class Model>
void require_vertex_adjoint(const Surface<T, Model>& surface, const Array<T, 3>& render_adjoint,
                            const std::vector<geometry::Vector3>& positions_adjoint) {
  require_shape("vertex_adjoint", "render_adjoint", render_adjoint,
                {render_adjoint.shape(0), render_adjoint.shape(1), 3});
  if (positions_adjoint.size() != surface.body.mesh.positions.size())
    throw ShapeError("vertex_adjoint: positions_adjoint is [" + std::to_string(positions_adjoint.size()) +
                     "], expected [" + std::to_string(surface.body.mesh.positions.size()) +
                     "], one entry a position");
}

template <std::floating_point T>
auto pixel_adjoint(const Array<T, 3>& render_adjoint) {
  return [&render_adjoint, height = render_adjoint.shape(0), width = render_adjoint.shape(1)](double column,
                                                                                              double row) {
    const std::size_t i = std::min(static_cast<std::size_t>(std::max(row, 0.0)), height - 1);
    const std::size_t j = std::min(static_cast<std::size_t>(std::max(column, 0.0)), width - 1);
    const T* const values = render_adjoint.data() + 3 * (i * width + j);
    return std::array<double, 3>{static_cast<double>(values[0]), static_cast<double>(values[1]),
                                 static_cast<double>(values[2])};
  };
}

}  // namespace detail

/// Adds ∂L/∂positions, L being a function of the picture that render() makes of a surface, to
/// positions_adjoint, in units of L per unit of the world. Sums are in double and the same for any number of
/// threads.
///
/// The picture is premultiplied by its coverage: beside the mesh it is 0. Flat light turns with its faces;
/// the normals of smooth light are taken as they are. Of a seam of duplicated vertices each side receives
/// half. Where the mesh is cut by near or far, the cut's own motion is left out.
///
/// \param render_adjoint     ∂L/∂picture, [H, W, 3]
/// \param positions_adjoint  one entry a position of the mesh
/// \param model              BoundaryIntegral, InteriorOnly or NeuralMeshRenderer
/// \throws ShapeError, DomainError, Error as visibility() and texture_operator() do; DomainError for a
///         trilinear atlas
template <std::floating_point T, class Model>
void vertex_adjoint(const Surface<T, Model>& surface, const geometry::Camera& camera,
                    const Array<T, 3>& render_adjoint, std::vector<geometry::Vector3>& positions_adjoint,
                    const InteriorOnly& model) {
  detail::require_vertex_adjoint(surface, render_adjoint, positions_adjoint);
  detail::add_interior(surface, surface_colour(surface, camera, "vertex_adjoint"), camera,
                       positions_in_view(surface.body.mesh, camera), render_adjoint, model.samples_per_axis,
                       positions_adjoint);
}

template <std::floating_point T, class Model>
void vertex_adjoint(const Surface<T, Model>& surface, const geometry::Camera& camera,
                    const Array<T, 3>& render_adjoint, std::vector<geometry::Vector3>& positions_adjoint,
                    const BoundaryIntegral& model = {}) {
  detail::require_vertex_adjoint(surface, render_adjoint, positions_adjoint);
  const auto colour = surface_colour(surface, camera, "vertex_adjoint");
  const auto positions_view = positions_in_view(surface.body.mesh, camera);
  detail::add_interior(surface, colour, camera, positions_view, render_adjoint, model.samples_per_axis,
                       positions_adjoint);
  const MeshEdges edges = mesh_edges(surface.body.mesh);
  const FaceField field(surface.body.mesh, positions_view, camera, render_adjoint.shape(0),
                        render_adjoint.shape(1));
  const auto adjoint_of = detail::pixel_adjoint(render_adjoint);
  const double longest_piece = 1 / static_cast<double>(model.samples_per_axis);
  const detail::BoundaryScene scene{surface.body.mesh, edges,        positions_view, field, camera, colour,
                                    adjoint_of,        longest_piece};
  detail::Outlines(scene).add_to(positions_adjoint);
  if (model.intersections) detail::Intersections(scene).add_to(positions_adjoint);
}

template <std::floating_point T, class Model>
void vertex_adjoint(const Surface<T, Model>& surface, const geometry::Camera& camera,
                    const Array<T, 3>& render_adjoint, std::vector<geometry::Vector3>& positions_adjoint,
                    const NeuralMeshRenderer& model) {
  detail::require_vertex_adjoint(surface, render_adjoint, positions_adjoint);
  const auto colour = surface_colour(surface, camera, "vertex_adjoint");
  const auto positions_view = positions_in_view(surface.body.mesh, camera);
  const std::size_t axis = model.samples_per_axis;
  const auto buffer =
      visibility(surface.body.mesh, camera, render_adjoint.shape(0), render_adjoint.shape(1), axis);
  const auto colours = detail::sample_colours(surface.body.mesh, positions_view, camera, buffer, colour);
  std::vector<std::array<double, 3>> adjoints(colours.size());
  const std::size_t columns = buffer.width * axis;
  for (std::size_t i = 0; i < adjoints.size(); ++i) {
    const std::size_t pixel = i / columns / axis * buffer.width + i % columns / axis;
    for (std::size_t c = 0; c < 3; ++c)
      adjoints[i][c] =
          static_cast<double>(render_adjoint.data()[3 * pixel + c]) / static_cast<double>(axis * axis);
  }
  detail::PixelMap(surface.body.mesh, positions_view, camera, buffer, colours, adjoints)
      .add_to(positions_adjoint);
  if (model.interior)
    detail::add_interior(surface, colour, camera, positions_view, render_adjoint, axis, positions_adjoint);
}

}  // namespace tapestry::raster
