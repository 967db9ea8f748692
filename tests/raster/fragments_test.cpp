#include <algorithm>
#include <cmath>
#include <tapestry/raster/fragments.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
using tapestry::geometry::Camera;
using tapestry::geometry::Mesh;
using tapestry::geometry::Vector3;

namespace {

/// Σ b·q over the corners of a face.
Vector3 point_of(const Mesh& mesh, const raster::Fragment& fragment) {
  Vector3 point{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto corner = static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(fragment.face)][k]);
    point = tapestry::geometry::add(
        point, tapestry::geometry::scale(mesh.positions[corner], fragment.barycentric[k]));
  }
  return point;
}

}  // namespace

TEST_CASE("barycentrics are those of the ray's point on the face, near plane or not",
          "[raster][barycentric]") {
  // A floor that passes under the camera and reaches far ahead, and a wall at a steep angle.
  const Mesh mesh =
      tapestry::test::triangle_soup({{Vector3{-40, 1, -10}, Vector3{40, 1, -10}, Vector3{0, 1, 90}},
                                     {Vector3{-3, -3, 1}, Vector3{-2.9, 3, 20}, Vector3{-3, 3, 1}}});
  const Camera camera;
  const auto buffer = raster::visibility(mesh, camera, 64, 48, 1);
  double error = 0;
  std::array<std::size_t, 2> seen{};
  for (const auto& fragment : raster::fragments(buffer, mesh, camera)) {
    const Vector3 point = point_of(mesh, fragment);
    const double rx = (static_cast<double>(fragment.pixel % 48) + 0.5) / 24 - 1;
    const double ry = (static_cast<double>(fragment.pixel / 48) + 0.5) / 32 - 1;
    const bool is_inside =
        std::min({fragment.barycentric[0], fragment.barycentric[1], fragment.barycentric[2]}) > 0;
    if (!is_inside) continue;  // clamped, at an edge
    ++seen[static_cast<std::size_t>(fragment.face)];
    if (fragment.face == 0) error = std::max(error, std::abs(point[2] - 1 / ry) / point[2]);  // y = 1
    error = std::max({error, std::abs(point[0] / point[2] - rx), std::abs(point[1] / point[2] - ry)});
  }
  CHECK(seen[0] > 1000);
  CHECK(seen[1] > 100);
  CHECK(error <= 1e-12);
}

TEST_CASE("an edge-on face gives its centroid", "[raster][barycentric]") {
  const Mesh mesh = tapestry::test::triangle_soup({{Vector3{0, -1, 1}, Vector3{0, 1, 1}, Vector3{0, 0, 3}}});
  raster::Barycentric barycentric(Camera{}, 1, 1);
  barycentric.select(mesh, raster::positions_in_view(mesh, Camera{}), 0);
  for (const double b : barycentric.at(0, 0)) CHECK(b == 1.0 / 3);
}

TEST_CASE("fragments of a pixel account for all its covered samples", "[raster][fragments]") {
  const Mesh mesh = tapestry::test::random_triangles(200, 1, 0.4);
  const Camera camera;
  const auto buffer = raster::visibility(mesh, camera, 17, 23, 4);
  const auto coverage = raster::coverage_of(buffer);
  for (const auto grain : {raster::FragmentGrain::face, raster::FragmentGrain::sample}) {
    std::vector<double> sum(17 * 23, 0);
    double barycentric_error = 0;
    std::size_t last_pixel = 0;
    bool is_ordered = true;
    const auto fragments = raster::fragments(buffer, mesh, camera, grain);
    for (const auto& fragment : fragments) {
      sum[fragment.pixel] += fragment.coverage;
      is_ordered = is_ordered && fragment.pixel >= last_pixel;
      last_pixel = fragment.pixel;
      const auto& b = fragment.barycentric;
      barycentric_error = std::max(barycentric_error, std::abs(b[0] + b[1] + b[2] - 1));
    }
    bool is_complete = true;
    for (std::size_t i = 0; i < sum.size(); ++i)
      is_complete = is_complete && sum[i] == static_cast<double>(coverage.data()[i]);
    CHECK(is_complete);
    CHECK(is_ordered);
    CHECK(barycentric_error <= 1e-12);
    if (grain == raster::FragmentGrain::sample) {
      CHECK(fragments.size() ==
            static_cast<std::size_t>(std::count_if(buffer.face.begin(), buffer.face.end(),
                                                   [](std::int32_t face) { return face >= 0; })));
    }
  }
}
