#pragma once
#include <tapestry/camouflage/shape_parameter.hpp>

namespace tapestry::camouflage {
ShapeParameter shape_parameter(const raster::PaintedMesh& car) {
  if (raster::is_filtered(car.layout))
    throw DomainError("shape_parameter: expected a bilinear atlas, found a filtered one");
  (void)geometry::mesh_topology(car.mesh);  // throws if edges would be wrong
  auto edges = std::make_shared<const raster::MeshEdges>(raster::mesh_edges(car.mesh));
  geometry::Mesh welded;
  welded.positions = car.mesh.positions;
  welded.faces = car.mesh.faces;
  for (auto& face : welded.faces)
    for (std::int32_t& corner : face) corner = edges->welded[static_cast<std::size_t>(corner)];
  return {car, edges, geometry::mesh_topology(welded)};
}
}  // namespace tapestry::camouflage
