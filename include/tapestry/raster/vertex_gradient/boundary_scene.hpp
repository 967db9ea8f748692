#pragma once
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/face_field.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// What the integrals over boundaries of a picture, outlines and intersections, are about.
template <class Colour, class Adjoint>
struct BoundaryScene {
  const geometry::Mesh& mesh;
  const MeshEdges& edges;
  const std::vector<geometry::Vector3>& positions_view;
  const FaceField& field;
  const geometry::Camera& camera;
  const Colour& colour;
  Adjoint adjoint_of;  ///< (column, row) → the derivatives by the pixel's channels there, as Colour::Colour
  double longest_piece;  ///< px
};
template <class Colour, class Adjoint>
BoundaryScene(const geometry::Mesh&, const MeshEdges&, const std::vector<geometry::Vector3>&,
              const FaceField&, const geometry::Camera&, const Colour&, Adjoint, double)
    -> BoundaryScene<Colour, Adjoint>;

}  // namespace tapestry::raster::detail
