#include <tapestry/raster/light.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
using tapestry::geometry::Vector3;

TEST_CASE("face_light follows the side of the face that is seen", "[raster][light]") {
  // A face in the plane z = 0, counter-clockwise seen from above; a face inclined by 60°; one without area.
  const auto mesh =
      tapestry::test::triangle_soup({{Vector3{0, 0, 0}, Vector3{1, 0, 0}, Vector3{0, 1, 0}},
                                     {Vector3{0, 0, 0}, Vector3{0.5, 0, std::sqrt(0.75)}, Vector3{0, 1, 0}},
                                     {Vector3{0, 0, 0}, Vector3{1, 0, 0}, Vector3{2, 0, 0}}});
  const raster::Light light{0.25, 0.5, {0, 0, 7}, {1, 1, 1}};
  const auto above = tapestry::geometry::look_at({-3, 0, 2}, {0, 0, 0}, {0, 0, 1}, 1);
  const auto from_above = raster::face_light(mesh, above, light);
  CHECK(from_above[0] == 0.75);
  CHECK(from_above[1] == Approx(0.5));
  CHECK(from_above[2] == 0.25);
  const auto below = tapestry::geometry::look_at({3, 0, -2}, {0, 0, 0}, {0, 0, 1}, 1);
  const auto from_below = raster::face_light(mesh, below, light);
  CHECK(from_below[0] == 0.25);
  CHECK(from_below[1] == 0.25);
}

TEST_CASE("face_light refuses a light without a direction", "[raster][light]") {
  const tapestry::geometry::Mesh mesh;
  CHECK_THROWS_AS(raster::face_light(mesh, {}, {0.5, 0.5, {0, 0, 0}, {1, 1, 1}}), tapestry::DomainError);
  CHECK_THROWS_AS(raster::face_light(mesh, {}, {std::nan(""), 0.5, {0, 0, 1}, {1, 1, 1}}),
                  tapestry::DomainError);
}
