#include <tapestry/raster/detail/face_field.hpp>

#include <algorithm>
#include <array>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
namespace geometry = tapestry::geometry;
using geometry::Vector3;
using tapestry::Random;
using Point = std::array<double, 2>;

namespace {
constexpr std::size_t size = 32;  // pixels

/// Triangles of all sizes in a picture of size × size pixels.
geometry::Mesh some_triangles(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::array<Vector3, 3>> triangles(count);
  for (auto& triangle : triangles) {
    const double reach = random.uniform() < 0.1 ? 1 : 0.2, z = random.uniform(1, 3);
    const Vector3 middle{random.uniform(-1, 1) * z, random.uniform(-1, 1) * z, z};
    for (Vector3& corner : triangle)
      for (std::size_t axis = 0; axis < 3; ++axis)
        corner[axis] = middle[axis] + reach * random.uniform(-1, 1) * (axis == 2 ? 0.3 : 1);
  }
  return tapestry::test::triangle_soup(triangles);
}

/// The faces that a ray meets, found by testing all of them.
std::vector<std::int32_t> met(const raster::FacesInView& faces, const raster::FaceField& field,
                              const Point& point) {
  std::vector<std::int32_t> result;
  for (std::size_t face = 0; face < faces.mesh().faces.size(); ++face) {
    raster::FaceWeights weights;
    if (faces.winding(static_cast<std::int32_t>(face)) != 0 &&
        weights.set(field.rays(), faces.corners(face)) && weights.hit(point[0], point[1], field.limits()) > 0)
      result.push_back(static_cast<std::int32_t>(face));
  }
  return result;
}
}  // namespace

TEST_CASE(
    "faces near a line hold all that rays along it and beside it meet, and no side of it is seen differently",
    "[raster][face_field]") {
  const geometry::Mesh mesh = some_triangles(300, 5);
  const geometry::Camera camera;
  const raster::FacesInView faces(mesh, mesh.positions, camera, size, size);
  const raster::SeenFaces nothing_seen;
  raster::FaceField field(faces, nothing_seen, camera);
  struct Line {
    Point from, to, step;
  };
  Random random(7);
  std::vector<Line> lines;
  for (int i = 0; i < 60; ++i) {
    Line line{{random.uniform(1, size - 1), random.uniform(1, size - 1)}, {}, {}};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      line.to[axis] = line.from[axis] + 0.4 * field.cell_side() * random.uniform(-1, 1);
      line.step[axis] = 1e-5 * random.uniform(-1, 1) / 2;
    }
    lines.push_back(line);
    field.mark(line.from, line.to);
  }
  field.fill();
  std::vector<raster::CellEntry> kept;
  std::size_t left_out = 0, answers = 0;
  for (const Line& line : lines) {
    for (const double share : {0.0, 0.3, 1.0}) {
      const Point point{line.from[0] + share * (line.to[0] - line.from[0]),
                        line.from[1] + share * (line.to[1] - line.from[1])};
      const auto all = field.faces_in(field.cell_of(point));
      field.keep_near(line.from, line.to, line.step, all, kept);
      left_out += all.size() - kept.size();
      const auto expected = met(faces, field, point);
      for (const std::int32_t face : expected) REQUIRE(field.hit(face, point[0], point[1]) > 0);
      const auto nobody = [](std::int32_t) { return false; };
      for (const double inverse_depth : {0.0, 0.4, 2.0}) {
        const auto whole = field.look(all, point, inverse_depth, line.step, {0, 0}, nobody);
        const auto near = field.look(kept, point, inverse_depth, line.step, {0, 0}, nobody);
        REQUIRE(near.hider == whole.hider);
        for (std::size_t side = 0; side < 2; ++side) REQUIRE(near.seen[side].face == whole.seen[side].face);
        const bool is_hidden = std::any_of(expected.begin(), expected.end(), [&](std::int32_t face) {
          return field.hides(face, point[0], point[1], inverse_depth);
        });
        REQUIRE((whole.hider >= 0) == is_hidden);
        answers += is_hidden ? 1 : 0;
      }
    }
  }
  CHECK(left_out > 100);
  CHECK(answers > 50);
}

TEST_CASE("cells are half as many as faces spread evenly, and few of faces in many layers",
          "[raster][face_field][hard_case]") {
  using Extent = raster::FacesInView::Extent;
  const raster::FacesInView::Box box{{0, 0}, {100, 50}};
  const auto spread = static_cast<double>(raster::CellGrid(Extent{box, 10000, 5000}).size());
  CHECK(spread > 4500);
  CHECK(spread < 5500);
  CHECK(raster::CellGrid(Extent{box, 10000, 16 * 5000.0}).size() ==
        raster::CellGrid(Extent{box, 10000, 1}).size());
  // There are as many layers as faces: each face lies in every cell.
  CHECK(raster::CellGrid(Extent{box, 10000, 1e4 * 5000.0}).size() < 20);
  CHECK(raster::CellGrid(Extent{}).size() >= 1);
}

TEST_CASE("seen faces are told pixel by pixel, each once, and none where nothing was added",
          "[raster][face_field]") {
  constexpr std::size_t width = 4;
  raster::SeenFaces seen(width, 2, 2);  // 4 × 4 pixels in bands of 2 rows
  for (const std::int32_t face : {7, 7, 3, 3}) seen.band(0).add(1, face);
  seen.band(0).add(6, 7);
  seen.band(1).add(8, 5);
  const auto at = [&](double column, double row) {
    const auto faces = seen.at(column, row);
    return std::vector<std::int32_t>(faces.begin(), faces.end());
  };
  CHECK(at(1.5, 0.5) == std::vector<std::int32_t>{7, 3});
  CHECK(at(2.99, 1.01) == std::vector<std::int32_t>{7});
  CHECK(at(0, 2) == std::vector<std::int32_t>{5});
  for (const Point& empty : {Point{0.5, 0.5}, Point{3, 1}, Point{1, 2}, Point{0, 3.9}})
    CHECK(at(empty[0], empty[1]).empty());
  for (const Point& beyond : {Point{-0.1, 0}, Point{4, 0}, Point{0, -0.1}, Point{0, 4}, Point{0, 1e9}})
    CHECK(at(beyond[0], beyond[1]).empty());
  CHECK(raster::SeenFaces{}.at(0.5, 0.5).empty());
}
