#pragma once
#include "tiny_scene.hpp"

namespace tapestry::test {
/// A car of boxes: the body, whose top is hood and trunk, and the roof on it.
inline raster::PaintedMesh stepped_car() {
  auto car = tiny_car(24);
  auto& mesh = car.mesh;
  for (auto& position : mesh.positions) position[2] = position[2] > 1 ? 0.9 : 0.1;
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const double x : {-1.0, 0.5})
    for (const double y : {-0.8, 0.8}) mesh.positions.push_back({x, y, 1.4});
  for (int k = 0; k < 2; ++k) {
    mesh.faces.push_back(k == 0 ? std::array<std::int32_t, 3>{first, first + 2, first + 3}
                                : std::array<std::int32_t, 3>{first, first + 3, first + 1});
    mesh.face_uvs.push_back(mesh.face_uvs[static_cast<std::size_t>(10 + k)]);  // the floor's, not painted
    mesh.face_normals.push_back({-1, -1, -1});
    mesh.face_groups.push_back(-1);
    mesh.face_materials.push_back(0);
  }
  car.painted = geometry::faces_by_material(mesh, {"body"});
  return car;
}
}  // namespace tapestry::test
