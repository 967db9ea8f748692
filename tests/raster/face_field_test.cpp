#include <tapestry/raster/detail/face_field.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using geometry::Vector3;
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
  return test::triangle_soup(triangles);
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

namespace {
/// The face that is seen at a point, of equals the lowest, found by testing all; −1 for none.
double seen_at(const raster::FacesInView& faces, const raster::FaceField& field, const Point& point) {
  double face = -1, nearest = 0;
  for (const std::int32_t one : met(faces, field, point))
    if (const double inverse_depth = field.hit(one, point[0], point[1]); inverse_depth > nearest) {
      nearest = inverse_depth;
      face = one;
    }
  return face;
}

struct Line {
  Point from, to, step;
};

/// Lines that cross some cells, and steps to points just beside them.
std::vector<Line> some_lines(int count, double length, std::uint64_t seed) {
  Random random(seed);
  std::vector<Line> lines;
  for (int i = 0; i < count; ++i) {
    Line line{{random.uniform(1, size - 1), random.uniform(1, size - 1)}, {}, {}};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      line.to[axis] = std::clamp(line.from[axis] + length * random.uniform(-1, 1), 0.0, double{size});
      line.step[axis] = 1e-5 * random.uniform(-1, 1) / 2;
    }
    lines.push_back(line);
  }
  return lines;
}
}  // namespace

TEST_CASE("points of a line and beside it meet what they meet among all faces", "[raster][face_field]") {
  const geometry::Mesh mesh = some_triangles(300, 5);
  const geometry::Camera camera;
  const raster::FacesInView faces(mesh, mesh.positions, camera, size, size);
  const raster::SeenFaces nothing_seen;
  raster::FaceField field(faces, nothing_seen, camera);
  const std::vector<Line> lines = some_lines(60, 9, 7);
  for (std::size_t i = 0; i < lines.size(); ++i) REQUIRE(field.mark(lines[i].from, lines[i].to) == i);
  field.fill();
  std::vector<raster::LineFace> memory;
  std::size_t segments = 0, hidden = 0, seen = 0;
  for (std::size_t index = 0; index < lines.size(); ++index) {
    const Line& line = lines[index];
    const double length = std::hypot(line.to[0] - line.from[0], line.to[1] - line.from[1]);
    segments += field.first_segment(index + 1) - field.first_segment(index);
    for (const double share : {0.0, 0.3, 0.7, 1.0}) {
      const Point point{line.from[0] + share * (line.to[0] - line.from[0]),
                        line.from[1] + share * (line.to[1] - line.from[1])};
      const std::size_t segment = field.segment_at(index, field.first_segment(index), share * length);
      for (const double inverse_depth : {0.0, 0.4, 2.0}) {
        raster::LinePoints points;
        points.size = 1;
        points.column[0] = point[0];
        points.row[0] = point[1];
        points.hidden_from[0] = raster::FaceField::hidden_from(inverse_depth);
        field.look(segment, line.step, {}, points, memory);
        const auto expected = met(faces, field, point);
        const bool is_hidden = std::any_of(expected.begin(), expected.end(), [&](std::int32_t face) {
          return field.hides(face, point[0], point[1], inverse_depth);
        });
        const auto nobody = [](std::int32_t) { return false; };
        REQUIRE((points.hider[0] >= 0) == is_hidden);
        REQUIRE((field.hider(segment, point[0], point[1], inverse_depth, nobody) >= 0) == is_hidden);
        for (std::size_t side = 0; side < 2; ++side) {
          const double sign = side == 0 ? -1 : 1;
          const Point beside{point[0] + sign * line.step[0], point[1] + sign * line.step[1]};
          REQUIRE(points.face[side][0] == seen_at(faces, field, beside));
          seen += points.face[side][0] >= 0 ? 1 : 0;
        }
        hidden += is_hidden ? 1 : 0;
      }
    }
  }
  CHECK(segments > 2 * lines.size());
  CHECK(hidden > 50);
  CHECK(seen > 100);
}

TEST_CASE("a line lists the faces near it, those of its own left out where it is looked along",
          "[raster][face_field]") {
  const geometry::Mesh mesh = some_triangles(300, 5);
  const geometry::Camera camera;
  const raster::FacesInView faces(mesh, mesh.positions, camera, size, size);
  const raster::SeenFaces nothing_seen;
  raster::FaceField field(faces, nothing_seen, camera);
  for (const Line& line : some_lines(20, 2, 3)) field.mark(line.from, line.to);
  field.fill();
  const auto lines = some_lines(20, 2, 3);
  std::size_t visits = 0;
  for (std::size_t index = 0; index < lines.size(); ++index) {
    std::vector<std::int32_t> near;
    field.for_each_face_near(index, [&](std::int32_t face, const raster::FaceWeights& weights) {
      REQUIRE(&weights == &field.weights(face));
      near.push_back(face);
    });
    visits += near.size();
    for (const std::int32_t face : met(faces, field, lines[index].to)) {
      REQUIRE(std::find(near.begin(), near.end(), face) != near.end());
      raster::LinePoints points;
      points.size = 1;
      points.column[0] = lines[index].to[0];
      points.row[0] = lines[index].to[1];
      points.hidden_from[0] = field.hit(face, lines[index].to[0], lines[index].to[1]) * (1 - 1e-6);
      std::vector<raster::LineFace> memory;
      const std::size_t last = field.first_segment(index + 1) - 1;
      const std::vector<raster::HalfEdge> own{{face, 0}};
      field.look(last, lines[index].step, own, points, memory);
      REQUIRE(points.hider[0] != static_cast<double>(face));
      REQUIRE(points.face[0][0] != static_cast<double>(face));
    }
  }
  CHECK(visits < 20 * mesh.faces.size() / 3);
}

TEST_CASE("cells hold eight of the faces spread evenly, and there are few of faces in many layers",
          "[raster][face_field][hard_case]") {
  using Extent = raster::FacesInView::Extent;
  const raster::FacesInView::Box box{{0, 0}, {100, 50}};
  const auto spread = static_cast<double>(raster::CellGrid(Extent{box, 10000, 5000}).size());
  CHECK(spread > 1100);
  CHECK(spread < 1400);
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

TEST_CASE("kernels of all instruction sets find the same segments, faces and moments, to the bit",
          "[raster][face_field]") {
  Random random(17);
  const auto number = [&] { return random.uniform(-1, 1); };
  std::array<std::vector<double>, 4> ends;
  for (auto& end : ends)
    for (int i = 0; i < 100 + 8; ++i) end.push_back(number());
  std::vector<raster::LineFace> near(20);
  for (std::size_t i = 0; i < near.size(); ++i) {
    for (auto& weight : near[i].w) weight = {number(), number(), random.uniform(0, 2)};
    near[i].change = {1e-5 * number(), 1e-5 * number(), 1e-5 * number()};
    near[i].face = static_cast<double>(i);
  }
  raster::LinePoints points;
  raster::MomentBatch batch;
  points.size = batch.size = 59;
  for (std::size_t i = 0; i < points.size; ++i) {
    points.column[i] = number();
    points.row[i] = number();
    points.hidden_from[i] = random.uniform(2, 6);
    batch.slot[i] = static_cast<std::uint32_t>(i / 7 % 3);
    batch.value[i] = {number(), number(), number(), number()};
    batch.barycentric[i] = {number(), number()};
  }
  const auto answers = [&](InstructionSet set) {
    const raster::RasterKernels kernels = raster::raster_kernels_of(set);
    std::vector<double> all;
    std::vector<std::uint32_t> places(100 + 8);
    for (const raster::LineFace& face : near) {
      const std::size_t count = kernels.near_segments(
          {face.w, face.change}, {ends[0].data(), ends[1].data(), ends[2].data(), ends[3].data()}, 3, 100,
          places.data());
      all.insert(all.end(), places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count));
    }
    raster::LinePoints own = points;
    kernels.look_along(near.data(), near.size(), {0.1, 10}, own);
    for (std::size_t i = 0; i < own.size; ++i)
      all.insert(all.end(), {own.hider[i], own.face[0][i], own.face[1][i], own.inverse_depth[0][i]});
    std::vector<std::array<std::array<double, 8>, 4>> sums(3);
    kernels.add_moments(batch, sums.data());
    for (const auto& rows : sums)
      for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
    return all;
  };
  const auto expected = answers(InstructionSet::portable);
  CHECK(expected.size() > 4 * points.size + 200);
  for (const auto set : tapestry::instruction_sets()) CHECK(answers(set) == expected);
}
