#include "car.hpp"

#include "car_body.hpp"

namespace tapestry::scenes {
namespace {
/// A wheel: hub, spokes, rim and tyre turned about its axle.
/// \param outer  centre of the outer face, which looks away from the car's middle
void add_wheel(MeshBuilder& builder, const Point& outer, double radius, const CarMaterials& materials,
               std::size_t sectors) {
  struct Step {
    double radius, depth;  ///< relative to the wheel's radius; metres inwards
  };
  static constexpr Step profile[] = {{0.0, 0.02}, {0.2, 0.02}, {0.62, 0.035}, {0.68, 0.0}, {0.93, 0.0},
                                     {1.0, 0.03}, {1.0, 0.18}, {0.93, 0.21},  {0.0, 0.21}};
  const double sign = outer[1] > 0 ? 1 : -1;
  std::vector<std::int32_t> inner, ring(sectors);
  for (std::size_t step = 0; step < std::size(profile); ++step) {
    for (std::size_t sector = 0; sector < sectors; ++sector) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(sector) / static_cast<double>(sectors);
      const double r = profile[step].radius * radius;
      ring[sector] = builder.vertex({outer[0] + r * std::cos(angle), outer[1] - sign * profile[step].depth,
                                     outer[2] + r * std::sin(angle)});
    }
    for (std::size_t sector = 0; step > 0 && sector < sectors; ++sector) {
      const std::size_t next = (sector + 1) % sectors;
      const bool gap = step == 2 && sector % 4 >= 2;
      const std::int32_t material = step >= 4 ? materials.tyre : gap ? materials.trim : materials.rim;
      if (sign < 0)
        builder.quad({inner[sector], ring[sector], ring[next], inner[next]}, material);
      else
        builder.quad({inner[sector], inner[next], ring[next], ring[sector]}, material);
    }
    inner = ring;
  }
}

void add_mirrors(MeshBuilder& builder, const CarShape& shape, std::int32_t material) {
  const double x = shape.side_windows.back().second - 0.04;
  const double y = shape.half_width(x);
  const double z = shape.belt(x) + 0.04;
  builder.box({x - 0.06, y - 0.05, z}, {x + 0.05, y + 0.13, z + 0.13}, material);
  builder.box({x - 0.06, -y - 0.13, z}, {x + 0.05, -y + 0.05, z + 0.13}, material);
}

/// Rounds to tenths of a millimetre, uv to 10⁻⁴, so that the mesh's file is short and exact.
void round_coordinates(geometry::Mesh& mesh) {
  for (Point& position : mesh.positions)
    for (double& coordinate : position) coordinate = std::round(coordinate * 1e4) / 1e4;
  for (Uv& uv : mesh.uvs)
    for (double& coordinate : uv) coordinate = std::round(coordinate * 1e4) / 1e4;
}

void drop_unused_uvs(geometry::Mesh& mesh) {
  std::vector<std::int32_t> place(mesh.uvs.size(), -1);
  std::vector<Uv> used;
  for (geometry::Corners& corners : mesh.face_uvs)
    for (std::int32_t& uv : corners) {
      if (uv < 0) continue;
      std::int32_t& index = place[static_cast<std::size_t>(uv)];
      if (index < 0) {
        index = static_cast<std::int32_t>(used.size());
        used.push_back(mesh.uvs[static_cast<std::size_t>(uv)]);
      }
      uv = index;
    }
  mesh.uvs = std::move(used);
}
}  // namespace

geometry::Mesh make_car(const CarOptions& options) {
  const CarShape shape = car_shape(options.style);
  MeshBuilder builder;
  CarMaterials materials{};
  materials.body = builder.material("body", options.colour);
  materials.glass = builder.material("glass", {0.11F, 0.14F, 0.17F});
  materials.tyre = builder.material("tyre", {0.07F, 0.07F, 0.075F});
  materials.light = builder.material("light", {0.92F, 0.93F, 0.88F});
  materials.tail_light = builder.material("tail_light", {0.62F, 0.05F, 0.05F});
  materials.trim = builder.material("trim", {0.10F, 0.10F, 0.11F});
  materials.rim = builder.material("rim", {0.62F, 0.63F, 0.65F});
  materials.plate = builder.material("plate", {0.88F, 0.88F, 0.80F});
  CarBody(builder, shape, materials, options.spacing).build();
  const std::size_t sectors = options.spacing > 0.2 ? 12 : 20;
  for (const double axle : {shape.rear_axle, shape.front_axle})
    for (const double side : {1.0, -1.0}) {
      const double y = side_half_width(shape, axle, shape.wheel_radius) - 0.025;
      add_wheel(builder, {axle, side * y, shape.wheel_radius}, shape.wheel_radius, materials, sectors);
    }
  add_mirrors(builder, shape, materials.trim);
  for (Point& position : builder.mesh().positions)
    for (std::size_t axis = 0; axis < 3; ++axis) position[axis] *= options.stretch[axis];
  drop_unused_uvs(builder.mesh());
  round_coordinates(builder.mesh());
  return std::move(builder.mesh());
}
}  // namespace tapestry::scenes
