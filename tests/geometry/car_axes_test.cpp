#include <tapestry/geometry/mesh.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Mesh, geometry::MeshAxes, geometry::Vector3;

namespace {
void add_box(Mesh& mesh, const Vector3& low, const Vector3& high) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (std::size_t i = 0; i < 8; ++i)
    mesh.positions.push_back({(i & 1U) != 0 ? high[0] : low[0], (i & 2U) != 0 ? high[1] : low[1],
                              (i & 4U) != 0 ? high[2] : low[2]});
  for (const std::array<std::int32_t, 4> side :
       {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4}, std::array{2, 6, 7, 3},
        std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
    mesh.faces.push_back({first + side[0], first + side[1], first + side[2]});
    mesh.faces.push_back({first + side[0], first + side[2], first + side[3]});
  }
}

/// A truck with z up and its front at +x, higher than wide: a cab, a load and four wheels.
Mesh truck() {
  Mesh mesh;
  add_box(mesh, {-4, -1.2, 0.6}, {2, 1.2, 3.6});
  add_box(mesh, {2.2, -1.1, 0.6}, {4, 1.1, 2.8});
  for (const double x : {-2.5, 2.6})
    for (const double y : {-1.1, 0.8}) add_box(mesh, {x - 0.4, y, 0}, {x + 0.4, y + 0.3, 0.8});
  return mesh;
}

/// The truck as a file with other axes stores it.
Mesh stored(const MeshAxes& axes) {
  const auto rotation = geometry::world_from_mesh(axes);
  Mesh mesh = truck();
  for (Vector3& position : mesh.positions) position = geometry::multiply_transposed(rotation, position);
  return mesh;
}

const std::array<std::string, 6> names{"x", "y", "z", "-x", "-y", "-z"};
}  // namespace

TEST_CASE("a truck with any axes is right by them, and righted where it is taken for one with z up",
          "[geometry][car_axes]") {
  std::size_t pairs = 0;
  for (const std::string& up : names)
    for (const std::string& forward : names) {
      if (up.back() == forward.back()) continue;
      CAPTURE(up, forward);
      const Mesh mesh = stored({up, forward});
      CHECK_FALSE(geometry::better_car_axes(mesh, {up, forward}));
      const auto better = geometry::better_car_axes(mesh, {"z", "x"});
      CHECK(better.has_value() ==
            !(up == "z" && forward.back() == 'x'));  // its tail is not told from its front
      if (better) {
        CHECK(better->up == up);
        CHECK(better->forward == std::string(1, forward.back()));
      }
      ++pairs;
    }
  CHECK(pairs == 24);
}

TEST_CASE("a mesh without wheels is judged by its extents alone", "[geometry][car_axes]") {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {4, 1.8, 1.4});
  CHECK_FALSE(geometry::better_car_axes(mesh, {"z", "x"}));
  CHECK_FALSE(geometry::better_car_axes(mesh, {"-y", "-x"}));
  CHECK(geometry::better_car_axes(mesh, {"z", "y"})->forward == "x");
  CHECK(geometry::better_car_axes(mesh, {"x", "y"})->up == "y");
  add_box(mesh, {1, 1, 1}, {1, 1, 1});
  CHECK_FALSE(geometry::better_car_axes(mesh, {"z", "x"}));  // faces without area add nothing
  Mesh flat;
  flat.positions = {{0, 0, 0}, {0, 3, 0}, {0, 0, 3}};
  flat.faces = {{0, 1, 2}};
  CHECK_FALSE(geometry::better_car_axes(flat, {"z", "x"}));  // no car is flat
  CHECK_FALSE(geometry::better_car_axes({}, {"z", "x"}));
}

TEST_CASE("wheel_share of a flat side is that of its corners", "[geometry][car_axes]") {
  Mesh slab;
  add_box(slab, {0, 0, 0}, {400, 200, 0.01});
  // 4 · (.5 − .15) · (.5 − .2); 10,000 points, a corner's standard deviation is below .003 of them
  CHECK(std::abs(geometry::wheel_share(slab, "-z", 0) - 0.42) < 0.02);
  CHECK(geometry::wheel_share(truck(), "-z", 0) > 0.9);
  CHECK(geometry::wheel_share(truck(), "z", 0) < 0.5);
  CHECK_THROWS_AS(geometry::wheel_share(slab, "w", 0), tapestry::DomainError);
}
