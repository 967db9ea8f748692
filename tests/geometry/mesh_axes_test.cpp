#include <tapestry/geometry/mesh.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Mesh, geometry::MeshAxes, geometry::Vector3;

namespace {
/// A point 4 to the front, 2 to the left and 1 up of a car whose file has these axes, with that as its
/// normal.
Mesh one_point(const Vector3& forward, const Vector3& left, const Vector3& up) {
  Mesh mesh;
  for (auto* const vectors : {&mesh.positions, &mesh.normals})
    vectors->push_back(
        geometry::add(geometry::add(geometry::scale(forward, 4), geometry::scale(left, 2)), up));
  return mesh;
}
}  // namespace

TEST_CASE("front, left and up of a mesh with any axes become x, y and z", "[geometry][mesh_axes]") {
  // left = up × forward, worked out by hand
  struct Case {
    MeshAxes axes;
    Vector3 forward, left, up;
  };
  const std::vector<Case> cases{
      {{"z", "x"}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},    {{"y", "z"}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
      {{"y", "-z"}, {0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}, {{"y", "x"}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
      {{"z", "-y"}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},  {{"-x", "y"}, {0, 1, 0}, {0, 0, -1}, {-1, 0, 0}}};
  for (const auto& [axes, forward, left, up] : cases) {
    CAPTURE(axes.up, axes.forward);
    const Mesh turned = geometry::turned_upright(one_point(forward, left, up), axes);
    CHECK(turned.positions == std::vector<std::array<double, 3>>{{4, 2, 1}});
    CHECK(turned.normals == std::vector<std::array<double, 3>>{{4, 2, 1}});
  }
}

TEST_CASE("every pair of axes at a right angle is a rotation, never a mirror", "[geometry][mesh_axes]") {
  std::size_t pairs = 0;
  for (const std::string up : {"x", "y", "z", "-x", "-y", "-z"})
    for (const std::string forward : {"x", "y", "z", "-x", "-y", "-z"}) {
      if (up.back() == forward.back()) {
        CHECK_THROWS_WITH(geometry::world_from_mesh({up, forward}),
                          "world_from_mesh: up is " + up + " and forward " + forward +
                              ", expected two axes at a right angle");
        continue;
      }
      const auto rotation = geometry::world_from_mesh({up, forward});
      CHECK(geometry::dot(rotation[0], geometry::cross(rotation[1], rotation[2])) == 1);
      ++pairs;
    }
  CHECK(pairs == 24);
}

TEST_CASE("an axis of another name is refused", "[geometry][mesh_axes][bad_input]") {
  for (const std::string name : {"", "-", "w", "xy", "+x", "--x", "X"})
    CHECK_THROWS_WITH(geometry::axis_by_name(name),
                      "axis_by_name: found '" + name + "', expected x, y, z, -x, -y or -z");
}
