#include <tapestry/geometry/polygon_triangulator.hpp>

#include <numbers>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace geometry = tapestry::geometry;
using geometry::PolygonShape, geometry::Vector2, geometry::Vector3;
using Polygon = std::vector<Vector2>;

namespace {
std::vector<Vector3> in_plane(const Polygon& polygon) {
  std::vector<Vector3> corners;
  for (const Vector2& point : polygon) corners.push_back({point[0], point[1], 0});
  return corners;
}

double twice_area(const Vector2& a, const Vector2& b, const Vector2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Half the sum of cross products of neighbours: the shoelace formula.
double shoelace(const Polygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum / 2;
}

std::vector<std::array<std::size_t, 3>> triangles_of(const Polygon& polygon, PolygonShape expected) {
  geometry::PolygonTriangulator triangulator;
  REQUIRE(triangulator.triangulate(in_plane(polygon)) == expected);
  if (expected == PolygonShape::concave) return triangulator.triangles();
  std::vector<std::array<std::size_t, 3>> fan;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) fan.push_back({0, i, i + 1});
  return fan;
}

/// How often the polygon runs around the point, counter-clockwise; the point is on no edge.
int winding_number(const Polygon& polygon, const Vector2& point) {
  int winding = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a[1] <= point[1]) == (b[1] <= point[1])) continue;  // does not cross the ray to the right
    const double side = twice_area(a, b, point);
    if (a[1] <= point[1] && side > 0) ++winding;
    if (b[1] <= point[1] && side < 0) --winding;
  }
  return winding;
}

/// The triangles have the polygon's winding, their areas add up, and they cover its inside.
void check_covers(const Polygon& polygon, double area, PolygonShape expected = PolygonShape::concave) {
  const auto triangles = triangles_of(polygon, expected);
  REQUIRE(triangles.size() == polygon.size() - 2);
  const double sense = area < 0 ? -1 : 1;
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    CHECK(sense * geometry::orientation(polygon[a], polygon[b], polygon[c]) >= 0);
    sum += twice_area(polygon[a], polygon[b], polygon[c]) / 2;
  }
  CHECK(sum == Approx(area).epsilon(1e-12));
  Vector2 low = polygon[0], high = polygon[0];
  for (const Vector2& point : polygon)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  const auto draws = tapestry::test::random_array<double>({200, 2}, 7);
  for (std::size_t i = 0; i < 200; ++i) {
    const Vector2 point{low[0] + (high[0] - low[0]) * draws(i, 0), low[1] + (high[1] - low[1]) * draws(i, 1)};
    int covered = 0;
    for (const auto& [a, b, c] : triangles)
      covered += winding_number({polygon[a], polygon[b], polygon[c]}, point);
    CHECK(covered == winding_number(polygon, point));
  }
}

const Polygon c_shape{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {3, 2}, {3, 3}, {0, 3}};  // area 7

Polygon star(std::size_t tips, double inner) {
  Polygon polygon;
  for (std::size_t i = 0; i < 2 * tips; ++i) {
    const double angle = std::numbers::pi * static_cast<double>(i) / static_cast<double>(tips);
    const double radius = i % 2 == 0 ? 1 : inner;
    polygon.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return polygon;
}

/// A band of width 0.4 that winds outwards; each turn lies 1 outside the one before.
Polygon spiral(std::size_t turns, std::size_t steps_a_turn) {
  Polygon polygon;
  const std::size_t count = turns * steps_a_turn;
  const auto at = [&](std::size_t step, double offset) {
    const double turn = static_cast<double>(step) / static_cast<double>(steps_a_turn);
    const double radius = 1 + turn + offset;
    polygon.push_back(
        {radius * std::cos(2 * std::numbers::pi * turn), radius * std::sin(2 * std::numbers::pi * turn)});
  };
  for (std::size_t step = 0; step <= count; ++step) at(step, 0.4);
  for (std::size_t step = count + 1; step-- > 0;) at(step, 0);
  return polygon;
}

Polygon changed(Polygon polygon, double scale, double shift) {
  for (Vector2& point : polygon)
    for (double& value : point) value = value * scale + shift;
  return polygon;
}

Polygon turned_to_start_at(const Polygon& polygon, std::size_t first) {
  Polygon turned = polygon;
  std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(first), turned.end());
  return turned;
}
}  // namespace

TEST_CASE("polygons that all of the first corner sees stay a fan", "[geometry][triangulate]") {
  check_covers({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1, PolygonShape::fan);
  check_covers({{0, 0}, {0, 1}, {1, 1}, {1, 0}}, -1, PolygonShape::fan);
  check_covers({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}}, 4, PolygonShape::fan);  // corners in a line
  check_covers(star(50, 1), 50 * std::sin(std::numbers::pi / 50), PolygonShape::fan);
  check_covers({{0, 0}, {2, 1}, {0.5, 0.5}, {1, 2}}, 0.5, PolygonShape::fan);  // concave
}

TEST_CASE("concave polygons are covered whichever corner comes first", "[geometry][triangulate]") {
  const double star_area = 5 * 0.3 * std::sin(std::numbers::pi / 5);
  for (std::size_t first = 0; first < 8; ++first) {
    CAPTURE(first);
    check_covers(turned_to_start_at(c_shape, first), 7);
    Polygon backwards = turned_to_start_at(c_shape, first);
    std::reverse(backwards.begin(), backwards.end());
    check_covers(backwards, -7);
    check_covers(turned_to_start_at(star(5, 0.3), first), star_area);
  }
  check_covers({{2, 1}, {0.5, 0.5}, {1, 2}, {0, 0}}, 0.5);  // an arrowhead, its notch second
  check_covers(spiral(6, 40), shoelace(spiral(6, 40)));
  check_covers(star(500, 0.01), 500 * 0.01 * std::sin(std::numbers::pi / 500));
  // Twice its area is 64,120,397,646,443, and in double the sum over the fan is -140,737,488,355,328.
  const Vector2 notch{210642624042246, 380290420227459};
  triangles_of({{0, 0}, notch, {3278110275445017, 6492100153243591}, {notch[0] + 1, notch[1] + 2}},
               PolygonShape::concave);
}

TEST_CASE("size and place of a polygon do not change its triangles", "[geometry][triangulate]") {
  const auto triangles = triangles_of(c_shape, PolygonShape::concave);
  for (const double scale : {0x1p-100, 0x1p-20, 0x1p20, 0x1p100})
    CHECK(triangles_of(changed(c_shape, scale, 0), PolygonShape::concave) == triangles);
  CHECK(triangles_of(changed(c_shape, 1, 0x1p50), PolygonShape::concave) == triangles);
  CHECK(triangles_of(changed(c_shape, 0x1p-20, 0x1p30), PolygonShape::concave) == triangles);
}

TEST_CASE("a tilted polygon has the triangles of the flat one", "[geometry][triangulate]") {
  const auto triangles = triangles_of(c_shape, PolygonShape::concave);
  const std::vector<std::array<Vector3, 2>> planes{{{{0, 1, 0}, {0, 0, 1}}},
                                                   {{{0, 0, 1}, {1, 0, 0}}},
                                                   {{{1, 2, 2}, {2, 1, -2}}},
                                                   {{{-1, 0.5, 8}, {3, -7, 0}}}};
  for (const auto& [right, up] : planes) {
    std::vector<Vector3> corners;
    for (const Vector2& point : c_shape)
      corners.push_back(geometry::add(geometry::scale(right, point[0]), geometry::scale(up, point[1])));
    geometry::PolygonTriangulator triangulator;
    REQUIRE(triangulator.triangulate(corners) == PolygonShape::concave);
    CHECK(triangulator.triangles() == triangles);
  }
}

TEST_CASE("bridges to holes, repeated corners and corners in a line are no obstacle",
          "[geometry][triangulate]") {
  // A square of 4 × 4 with a square hole of 2 × 2, joined to it by a bridge that is passed twice.
  const Polygon one_hole{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
  for (std::size_t first = 0; first < one_hole.size(); ++first)
    check_covers(turned_to_start_at(one_hole, first), 12);
  const Polygon two_holes{{0, 0}, {7, 0}, {7, 3}, {4, 3}, {4, 2}, {6, 2}, {6, 1}, {4, 1}, {4, 2},
                          {4, 3}, {0, 3}, {1, 2}, {3, 2}, {3, 1}, {1, 1}, {1, 2}, {0, 3}};
  for (std::size_t first = 0; first < two_holes.size(); ++first)
    check_covers(turned_to_start_at(two_holes, first), 17);
  Polygon doubled, halved;
  for (std::size_t i = 0; i < c_shape.size(); ++i) {
    doubled.insert(doubled.end(), 2, c_shape[i]);
    const Vector2& next = c_shape[(i + 1) % c_shape.size()];
    halved.push_back(c_shape[i]);
    halved.push_back({(c_shape[i][0] + next[0]) / 2, (c_shape[i][1] + next[1]) / 2});
  }
  check_covers(doubled, 7);
  check_covers(halved, 7);
  Polygon spiked = c_shape;
  spiked.insert(spiked.begin() + 1, {{5, 0}, {2, 0}});  // out and back on one line
  check_covers(spiked, 7);
  check_covers({{0, 0}, {4, 0}, {4, 2}, {2, 0}, {0, 2}}, 4);  // pinched: a corner touches an edge
}

TEST_CASE("polygons of random corners around a point are covered", "[geometry][triangulate]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::size_t count = 4 + seed;
    const auto radii = tapestry::test::random_array<double>({count, 1}, seed);
    Polygon polygon;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
      const double radius = std::round(1 + 8 * radii(i, 0));
      polygon.push_back({std::round(radius * 4 * std::cos(angle)), std::round(radius * 4 * std::sin(angle))});
    }
    geometry::PolygonTriangulator triangulator;
    const auto shape = triangulator.triangulate(in_plane(polygon));
    CAPTURE(seed);
    if (shape != PolygonShape::crossing) check_covers(polygon, shoelace(polygon), shape);
    if (count < 40) CHECK(shape != PolygonShape::crossing);  // beyond, rounded corners may change their order
  }
}

TEST_CASE("polygons that cross themselves are told, or covered as often as they wind",
          "[geometry][triangulate]") {
  geometry::PolygonTriangulator triangulator;
  const auto shape_of = [&](const Polygon& polygon) { return triangulator.triangulate(in_plane(polygon)); };
  CHECK(shape_of({{0, 0}, {2, 2}, {2, 0}, {0, 2}}) == PolygonShape::crossing);  // a bow tie, area 0
  CHECK(shape_of({{0, 0}, {3, 3}, {3, 0}, {0, 2}}) == PolygonShape::crossing);  // and a lopsided one
  CHECK(shape_of({{0, 0}, {1, 1}, {2, 2}, {3, 3}}) == PolygonShape::fan);       // no area at all
  CHECK(shape_of({{1, 1}, {1, 1}, {1, 1}, {1, 1}}) == PolygonShape::fan);       // nor extent
  CHECK(shape_of({{0, 0}, {4, 0}, {4, 2}, {1, 2}, {1, -1}, {0, -1}}) == PolygonShape::crossing);
  Polygon twice = c_shape;  // all around twice
  twice.insert(twice.end(), c_shape.begin(), c_shape.end());
  if (const auto shape = shape_of(twice); shape != PolygonShape::crossing) check_covers(twice, 14, shape);
}

TEST_CASE("the work for a polygon is bounded", "[geometry][triangulate]") {
  geometry::PolygonTriangulator triangulator(100'000);
  CHECK(triangulator.triangulate(in_plane(star(100, 0.1))) == PolygonShape::concave);
  CHECK(triangulator.triangulate(in_plane(star(5000, 0.1))) == PolygonShape::intricate);
  CHECK(triangulator.triangulate(in_plane(c_shape)) == PolygonShape::intricate);  // all of it is spent
  CHECK(triangulator.triangulate(in_plane(star(100, 1))) == PolygonShape::fan);   // which needs none
}

TEST_CASE("PointColumns asks of every point in a triangle", "[geometry][triangulate]") {
  tapestry::Random random(1);
  const auto spread = [&] { return random.uniform(-1, 1); };
  for (const std::size_t count : {0U, 1U, 2U, 3U, 10U, 100U, 500U}) {
    std::vector<geometry::Vector2> points(count);
    for (std::size_t i = 0; i < count; ++i) points[i] = {spread(), spread()};
    for (std::size_t i = 0; i < count; i += 7) points[i][0] = 0.25;           // above each other
    for (std::size_t i = 0; i < count; i += 11) points[i] = points[i / 2];    // one on the other
    for (std::size_t i = 3; i < count; i += 13) points[i] = {1e30, -1e-100};  // far off
    geometry::PointColumns columns;
    columns.build(points);
    for (int round = 0; round < 200; ++round) {
      std::array<geometry::Vector2, 3> triangle;
      for (auto& corner : triangle)
        corner = count > 0 && round % 3 == 0 ? points[random.index(count)]
                                             : geometry::Vector2{spread(), round % 5 == 0 ? 0.0 : spread()};
      if (geometry::orientation(triangle[0], triangle[1], triangle[2]) < 0)
        std::swap(triangle[0], triangle[1]);
      std::vector<bool> is_asked(count);
      std::uint64_t steps = 0;
      CHECK_FALSE(columns.any_in(triangle, steps, [&](std::size_t i) {
        is_asked[i] = true;
        return false;
      }));
      CHECK(steps <= 2 * count + 1);
      for (std::size_t i = 0; i < count; ++i) {
        bool is_inside = true;
        for (std::size_t edge = 0; edge < 3; ++edge)
          is_inside =
              is_inside && geometry::orientation(triangle[edge], triangle[(edge + 1) % 3], points[i]) >= 0;
        const bool is_flat = geometry::orientation(triangle[0], triangle[1], triangle[2]) == 0;
        if (is_inside && !is_flat) CHECK(is_asked[i]);
      }
    }
  }
}
