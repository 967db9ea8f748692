#include <tapestry/geometry/point_columns.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;

TEST_CASE("positions become an array and come back", "[geometry][position_array]") {
  geometry::Mesh mesh;
  mesh.positions = {{1, 2, 3}, {4, 5, 6.5}};
  const auto array = geometry::position_array<float>(mesh);
  CHECK((array == tapestry::Array<float, 2>{{1, 2, 3}, {4, 5, 6.5F}}));
  geometry::Mesh other;
  other.positions.resize(2);
  geometry::set_positions("set_positions", other, array);
  CHECK(other.positions == mesh.positions);
  other.positions.resize(3);
  CHECK_THROWS_WITH(geometry::set_positions("set_positions", other, array),
                    "set_positions: positions is [2, 3], expected [3, 3]");
}
