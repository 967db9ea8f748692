#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/visibility.hpp>

#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::cross, geometry::dot, geometry::Mesh, geometry::Vector3;

namespace {
using Point = std::array<std::int64_t, 2>;  // column and row in 1/256 px

std::int64_t turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

constexpr std::size_t side = 16;  // pixels; a power of two, so that grid points are exact in view space

/// A point of the picture's grid on the plane z = 1 before the default camera.
Vector3 on_screen(const Point& point) {
  const auto view = [](std::int64_t v) { return static_cast<double>(v) / (256.0 * side) * 2 - 1; };
  return {view(point[0]), view(point[1]), 1};
}

/// A rectangle cut at random into triangles that share all their edges: a fan around an inner point to
/// points along the border, then some of its triangles cut in three.
std::vector<std::array<Point, 3>> tessellated(const Point& low, const Point& high, bool centre_on_sample,
                                              Random& random) {
  const auto between = [&](std::int64_t a, std::int64_t b) {
    return a + 1 + static_cast<std::int64_t>(random.index(static_cast<std::size_t>(b - a - 1)));
  };
  Point centre{between(low[0], high[0]), between(low[1], high[1])};
  if (centre_on_sample) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      centre[axis] = std::clamp(centre[axis] / 256 * 256 + 128, low[axis] + 256, high[axis] - 256);
    }
  }
  const std::vector<Point> border{
      low,  {between(low[0], high[0]), low[1]},  {high[0], low[1]}, {high[0], between(low[1], high[1])},
      high, {between(low[0], high[0]), high[1]}, {low[0], high[1]}, {low[0], between(low[1], high[1])}};
  std::vector<std::array<Point, 3>> triangles;
  for (std::size_t i = 0; i < border.size(); ++i) {
    triangles.push_back({centre, border[i], border[(i + 1) % border.size()]});
  }
  for (std::size_t cut = 0; cut < 8; ++cut) {
    const std::size_t index = random.index(triangles.size());
    const auto [a, b, c] = triangles[index];
    const Point inner{(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3};
    if (turn(a, b, inner) <= 0 || turn(b, c, inner) <= 0 || turn(c, a, inner) <= 0) continue;
    triangles[index] = {a, b, inner};
    triangles.push_back({b, c, inner});
    triangles.push_back({c, a, inner});
  }
  return triangles;
}

/// Whether the ray through a sample meets a triangle of view space, by exact homogeneous barycentrics: 1 or
/// 0, or −1 where the hit is too close to an edge, to near or to far to decide.
int hits(const std::array<Vector3, 3>& corner, const Vector3& ray, const Camera& camera, double& depth) {
  std::array<double, 3> b{};
  double sum = 0, largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    b[k] = dot(ray, cross(corner[(k + 1) % 3], corner[(k + 2) % 3]));
    sum += b[k];
    largest = std::max(largest, std::abs(b[k]));
  }
  depth = dot(corner[0], cross(corner[1], corner[2])) / sum;
  double smallest = 1;
  for (const double weight : b) smallest = std::min(smallest, (sum < 0 ? -weight : weight) / largest);
  if (std::abs(smallest) < 0.02) return -1;
  if (smallest < 0 || depth < 0) return 0;
  if (std::abs(depth - camera.near) < 1e-3 || std::abs(depth - camera.far) < 1e-3) return -1;
  return depth > camera.near && depth < camera.far ? 1 : 0;
}
}  // namespace

TEST_CASE("every sample of a tessellated quad is owned exactly once", "[raster][visibility]") {
  Random random(1);
  std::size_t wrong = 0;
  for (std::size_t round = 0; round < 1000; ++round) {
    // Borders on sample centres: the top-left rule keeps the upper and left border, drops the others.
    const Point low{128 + 256 * static_cast<std::int64_t>(random.index(4)),
                    128 + 256 * static_cast<std::int64_t>(random.index(4))};
    const Point high{low[0] + 256 * static_cast<std::int64_t>(4 + random.index(8)),
                     low[1] + 256 * static_cast<std::int64_t>(4 + random.index(8))};
    std::array<int, side * side> owners{};
    for (auto triangle : tessellated(low, high, round % 2 == 0, random)) {
      if (random.chance(0.5)) std::swap(triangle[0], triangle[1]);
      const Mesh mesh =
          triangle_soup({{on_screen(triangle[0]), on_screen(triangle[1]), on_screen(triangle[2])}});
      const auto buffer = raster::visibility(mesh, Camera{}, side, side, 1);
      for (std::size_t i = 0; i < owners.size(); ++i) owners[i] += buffer.face[i] == 0 ? 1 : 0;
    }
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const auto x = static_cast<std::int64_t>(i % side) * 256 + 128,
                 y = static_cast<std::int64_t>(i / side) * 256 + 128;
      const bool inside = x >= low[0] && x < high[0] && y >= low[1] && y < high[1];
      wrong += owners[i] == (inside ? 1 : 0) ? 0 : 1;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("a sample where many corners meet on its centre is owned once", "[raster][visibility]") {
  const Point centre{8 * 256 + 128, 8 * 256 + 128};
  std::vector<Point> rim;
  for (int i = 0; i < 12; ++i) {
    rim.push_back({centre[0] + std::lround(1500 * std::cos(i * 0.5236)),
                   centre[1] + std::lround(1500 * std::sin(i * 0.5236))});
  }
  int owners = 0;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Mesh mesh =
        triangle_soup({{on_screen(centre), on_screen(rim[i]), on_screen(rim[(i + 1) % rim.size()])}});
    owners += raster::visibility(mesh, Camera{}, side, side, 1).face[8 * side + 8] == 0 ? 1 : 0;
  }
  CHECK(owners == 1);
}

TEST_CASE("T08: triangles of all sizes own exactly the samples that integers say", "[raster][visibility]") {
  constexpr std::int64_t extent = 128;  // pixels of the picture along an axis
  const auto in_view = [](const Point& point) {
    const auto view = [](std::int64_t v) { return static_cast<double>(v) / (128.0 * extent) - 1; };
    return Vector3{view(point[0]), view(point[1]), 1};
  };
  // Inside to the right of a side that runs clockwise, rows downwards; on it if it is a left or a top one.
  const auto is_inside = [](const Point& a, const Point& b, const Point& p) {
    const std::int64_t area = turn(a, b, p);
    return area > 0 || (area == 0 && (b[1] < a[1] || (b[1] == a[1] && b[0] > a[0])));
  };
  Random random(10);
  std::size_t wrong = 0, owned = 0;
  for (const std::int64_t reach : {2, 20, 200, 5000, 120000}) {  // pixels; the guard band ends at 131072
    for (std::size_t round = 0; round < 40; ++round) {
      std::array<Point, 3> corner;
      const Point centre{static_cast<std::int64_t>(random.index(256 * extent)),
                         static_cast<std::int64_t>(random.index(256 * extent))};
      for (Point& point : corner) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
          const auto span = static_cast<std::size_t>(2 * reach * 256);
          point[axis] = centre[axis] + static_cast<std::int64_t>(random.index(span)) - reach * 256;
        }
        if (random.chance(0.3)) point = {point[0] / 256 * 256 + 128, point[1] / 256 * 256 + 128};
      }
      const Mesh mesh = triangle_soup({{in_view(corner[0]), in_view(corner[1]), in_view(corner[2])}});
      const auto buffer = raster::visibility(mesh, Camera{}, extent, extent, 1);
      if (turn(corner[0], corner[1], corner[2]) < 0) std::swap(corner[1], corner[2]);
      const bool has_area = turn(corner[0], corner[1], corner[2]) != 0;
      for (std::size_t i = 0; i < buffer.face.size(); ++i) {
        const Point p{static_cast<std::int64_t>(i % extent) * 256 + 128,
                      static_cast<std::int64_t>(i / extent) * 256 + 128};
        const bool expected = has_area && is_inside(corner[0], corner[1], p) &&
                              is_inside(corner[1], corner[2], p) && is_inside(corner[2], corner[0], p);
        owned += expected ? 1 : 0;
        wrong += (buffer.face[i] == 0) == expected ? 0 : 1;
      }
    }
  }
  CHECK(owned > 100000);
  CHECK(wrong == 0);
}

TEST_CASE("pictures of 8 to 32 thousand samples along an axis overflow nowhere", "[raster][visibility]") {
  // One long face whose side crosses the picture from corner to corner.
  for (const auto& [height, width, samples] :
       {std::array<std::size_t, 3>{48, 12000, 1}, {12000, 48, 1}, {10, 8192, 2}, {5, 4096, 8}}) {
    const Mesh mesh = triangle_soup({{Vector3{-2, -2, 2}, Vector3{2, 2, 2}, Vector3{-2, 2, 2}}});
    const auto buffer = raster::visibility(mesh, Camera{}, height, width, samples);
    const std::size_t rows = height * samples, columns = width * samples;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < buffer.face.size(); ++i) {
      const double down = (static_cast<double>(i / columns) + 0.5) / static_cast<double>(rows);
      const double right = (static_cast<double>(i % columns) + 0.5) / static_cast<double>(columns);
      if (std::abs(down - right) < 1e-3) continue;
      wrong += (buffer.face[i] == 0) == (down > right) ? 0 : 1;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("faces through the near plane and through w = 0 are cut exactly", "[raster][visibility]") {
  Camera camera;
  camera.near = 0.25;
  camera.far = 6;
  Random random(2);
  std::size_t compared = 0, wrong = 0, crossing = 0;
  for (std::size_t round = 0; round < 200; ++round) {
    std::array<Vector3, 3> corners;
    for (auto& corner : corners)
      corner = {random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 8)};
    crossing += std::min({corners[0][2], corners[1][2], corners[2][2]}) < 0 ? 1 : 0;
    const auto buffer = raster::visibility(triangle_soup({corners}), camera, 24, 32, 1);
    for (std::size_t i = 0; i < buffer.face.size(); ++i) {
      const Vector3 ray{(static_cast<double>(i % 32) + 0.5) / 16 - 1,
                        (static_cast<double>(i / 32) + 0.5) / 12 - 1, 1};
      double depth = 0;
      const int expected = hits(corners, ray, camera, depth);
      if (expected < 0) continue;
      ++compared;
      wrong += (buffer.face[i] == 0) == (expected == 1) ? 0 : 1;
    }
  }
  CHECK(crossing > 80);
  CHECK(compared > 100000);
  CHECK(wrong == 0);
}

TEST_CASE("the nearest face wins", "[raster][visibility]") {
  const Mesh mesh = random_triangles(60, 3);
  const Camera camera;
  const auto buffer = raster::visibility(mesh, camera, 33, 65, 1);
  std::size_t wrong = 0, covered = 0;
  for (std::size_t i = 0; i < buffer.face.size(); ++i) {
    const Vector3 ray{(static_cast<double>(i % 65) + 0.5) * 2 / 65 - 1,
                      (static_cast<double>(i / 65) + 0.5) * 2 / 33 - 1, 1};
    double nearest = 1e9, second = 1e9;
    std::int32_t expected = -1;
    bool is_clear = true;
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
      double depth = 0;
      const int hit =
          hits({mesh.positions[3 * face], mesh.positions[3 * face + 1], mesh.positions[3 * face + 2]}, ray,
               camera, depth);
      is_clear = is_clear && hit >= 0;
      if (hit <= 0) continue;
      second = std::min(second, std::max(nearest, depth));
      if (depth < nearest) expected = static_cast<std::int32_t>(face);
      nearest = std::min(nearest, depth);
    }
    if (!is_clear || second - nearest < 1e-5) continue;
    covered += expected >= 0 ? 1 : 0;
    wrong += buffer.face[i] == expected ? 0 : 1;
  }
  CHECK(covered > 500);
  CHECK(wrong == 0);
}

TEST_CASE("a camera inside a closed box sees a face at every sample", "[raster][visibility]") {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(
        {(i & 1) != 0 ? 1.1 : -0.9, (i & 2) != 0 ? 1.0 : -1.2, (i & 4) != 0 ? 1.3 : -0.7});
  }
  mesh.faces = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  Camera camera;
  camera.tan_half_fov_x = 3;
  camera.near = 1e-3;
  const auto buffer = raster::visibility(mesh, camera, 40, 50, 2);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), -1) == 0);
  CHECK(buffer.face[40 * 100 + 50] / 2 == 1);  // straight ahead: the wall at z = 1.3
}

TEST_CASE("of coincident faces the one with the lowest index is shown", "[raster][visibility]") {
  const Vector3 a{-0.7, -0.6, 1.9}, b{0.9, -0.4, 2.3}, c{0.1, 0.8, 1.4};
  for (const auto& copy :
       {std::array{a, b, c}, std::array{b, c, a}, std::array{c, b, a}, std::array{a, c, b}}) {
    const auto first = raster::visibility(triangle_soup({copy, {a, b, c}}), Camera{}, 30, 30, 2);
    CHECK(std::count(first.face.begin(), first.face.end(), 1) == 0);
    CHECK(std::count(first.face.begin(), first.face.end(), 0) > 100);
  }
}

TEST_CASE("repeated faces and faces without area change nothing", "[raster][visibility]") {
  Mesh mesh = random_triangles(20, 4);
  const auto clean = raster::visibility(mesh, Camera{}, 20, 20);
  mesh.faces.push_back(mesh.faces[3]);
  mesh.faces.push_back({0, 0, 1});
  mesh.faces.push_back({5, 5, 5});
  const auto on_line = static_cast<std::int32_t>(mesh.positions.size());
  for (const double s : {0.0, 0.5, 1.0}) mesh.positions.push_back({s - 0.5, 0.3 * s, 1});
  mesh.faces.push_back({on_line, on_line + 1, on_line + 2});
  CHECK(raster::visibility(mesh, Camera{}, 20, 20).face == clean.face);
}

TEST_CASE("corners that are not finite take their faces out and are counted", "[raster][visibility]") {
  Mesh mesh = random_triangles(30, 5);
  Mesh without = mesh;
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  mesh.positions[3 * 4][1] = nan;
  mesh.positions[3 * 9 + 2][0] = -infinity;
  mesh.positions[3 * 9][2] = infinity;
  mesh.positions[3 * 11 + 1] = {1e200, 1e200, 1e200};
  for (const std::size_t face : std::vector<std::size_t>{4, 9, 11}) without.faces[face] = {0, 0, 0};
  const auto buffer = raster::visibility(mesh, Camera{}, 24, 24);
  CHECK(buffer.non_finite_faces == 3);
  CHECK(buffer.face == raster::visibility(without, Camera{}, 24, 24).face);
}

TEST_CASE("huge and tiny coordinates are exact", "[raster][visibility]") {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Camera camera;
    camera.near = 1e-3 * scale;
    camera.far = 1e3 * scale;
    // Reaches far beyond the guard band; its edge is the diagonal of the picture.
    const Mesh mesh = triangle_soup(
        {{Vector3{-1e6 * scale, -1e6 * scale, 1 * scale}, Vector3{1e6 * scale, 1e6 * scale, 1 * scale},
          Vector3{-1e6 * scale, 1e6 * scale, 1 * scale}}});
    const auto buffer = raster::visibility(mesh, camera, 64, 64, 1);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < buffer.face.size(); ++i) {
      if (i / 64 == i % 64) continue;
      wrong += (buffer.face[i] == 0) == (i / 64 > i % 64) ? 0 : 1;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("one face over the whole picture, at any size of picture", "[raster][visibility]") {
  const Mesh mesh = triangle_soup({{Vector3{-9, -9, 2}, Vector3{30, -9, 2}, Vector3{-9, 30, 2}}});
  for (const auto& [height, width] :
       {std::array<std::size_t, 2>{1, 1}, {1, 4096}, {4096, 1}, {31, 33}, {32, 64}, {65, 127}}) {
    for (const std::size_t samples : std::vector<std::size_t>{1, 2, 4, 8}) {
      const auto buffer = raster::visibility(mesh, Camera{}, height, width, samples);
      CHECK(std::count(buffer.face.begin(), buffer.face.end(), 0) ==
            static_cast<std::ptrdiff_t>(height * width * samples * samples));
    }
  }
}

TEST_CASE("a mesh behind the camera, beside the view or beyond far shows nothing", "[raster][visibility]") {
  Camera camera;
  camera.far = 50;
  for (const Vector3& offset :
       {Vector3{0, 0, -9}, Vector3{40, 0, 0}, Vector3{0, -40, 0}, Vector3{0, 0, 90}}) {
    Mesh mesh = random_triangles(20, 6);
    for (auto& position : mesh.positions) position = geometry::add(position, offset);
    const auto buffer = raster::visibility(mesh, camera, 16, 16);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), -1) == 32 * 32);
  }
  const auto buffer = raster::visibility(Mesh{}, camera, 16, 16);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), -1) == 32 * 32);
}

TEST_CASE("visibility has the same bits for any number of threads and any instruction set",
          "[raster][visibility]") {
  // Small and large faces, some through the near plane, seen by a camera at no special place.
  Mesh mesh = random_triangles(4000, 7, 0.2);
  for (const auto& corner : random_triangles(60, 8, 6.0).positions) {
    if (mesh.positions.size() % 3 == 0) {
      const auto first = static_cast<std::int32_t>(mesh.positions.size());
      mesh.faces.push_back({first, first + 1, first + 2});
    }
    mesh.positions.push_back(corner);
  }
  Camera camera = geometry::look_at({0.3, -0.2, -0.5}, {0.1, 0.2, 2.5}, {0.1, 1, 0.2}, 1.7);
  camera.near = 0.02;
  const auto expected = raster::visibility(mesh, camera, 150, 171);
  CHECK(std::count(expected.face.begin(), expected.face.end(), -1) < 150 * 171);
  for (const int count : {1, 2, 3, 8}) {
    const Threads cap(count);
    for (const auto set : tapestry::instruction_sets()) {
      const auto kernels = raster::raster_kernels_of(set);
      const auto found = raster::visibility(mesh, camera, 150, 171, 2, raster::FaceCulling::none, kernels);
      CHECK(found.face == expected.face);
    }
  }
}

TEST_CASE("kernels of all instruction sets set up the same triangles, to the bit", "[raster][visibility]") {
  const Mesh mesh = random_triangles(500, 9, 0.3);
  const Camera camera = geometry::look_at({0.3, -0.2, -0.5}, {0.1, 0.2, 2.5}, {0.1, 1, 0.2}, 1.3);
  const raster::Projection projection(camera, 480, 640);
  const raster::RayGrid rays(camera, 480, 640);
  std::vector<std::vector<raster::ScreenTriangle>> made;
  std::vector<std::vector<std::array<double, 3>>> views;
  for (const auto set : tapestry::instruction_sets()) {
    const auto kernels = raster::raster_kernels_of(set);
    std::vector<std::array<double, 3>> view(mesh.positions.size());
    std::vector<raster::ScreenVertex> screen(mesh.positions.size());
    kernels.project(projection, mesh.positions.data(), view.size(), view.data(), screen.data());
    std::vector<std::int32_t> list(mesh.faces.size() + 1);
    const auto count = kernels.list_faces(mesh.faces.data(), 0, 500, screen.data(), 640, 480, list.data());
    const auto end = std::partition(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(count),
                                    [](std::int32_t face) { return face >= 0; });
    std::vector<raster::ScreenTriangle> triangles(mesh.faces.size());
    std::vector<raster::TileRange> tiles(mesh.faces.size());
    triangles.resize(kernels.set_up(rays, mesh.faces.data(), list.data(),
                                    static_cast<std::size_t>(end - list.begin()), screen.data(), view.data(),
                                    {640, 480, false}, triangles.data(), tiles.data()));
    for (std::size_t i = 0; i < view.size(); ++i) {
      if (screen[i].outside != 0) continue;
      const auto [x, y] = raster::snapped(projection, view[i]);
      CHECK((screen[i].x == x && screen[i].y == y));
    }
    made.push_back(triangles);
    views.push_back(view);
  }
  CHECK(made.front().size() > 300);
  for (std::size_t set = 1; set < made.size(); ++set) {
    CHECK(views[set] == views[0]);
    CHECK(made[set] == made[0]);
  }
}

TEST_CASE("culling back faces of a closed mesh seen from outside changes nothing", "[raster][visibility]") {
  Mesh mesh;  // an octahedron, corners counter-clockwise seen from outside
  mesh.positions = {{1, 0, 4}, {-1, 0, 4}, {0, 1, 4}, {0, -1, 4}, {0, 0, 5}, {0, 0, 3}};
  // The near ones first: on the silhouette the two sides are equally far.
  mesh.faces = {{2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}, {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}};
  const auto all = raster::visibility(mesh, Camera{}, 64, 64, 2);
  CHECK(raster::visibility(mesh, Camera{}, 64, 64, 2, raster::FaceCulling::back).face == all.face);
  for (auto& corners : mesh.faces) std::swap(corners[0], corners[1]);
  const auto inside = raster::visibility(mesh, Camera{}, 64, 64, 2, raster::FaceCulling::back);
  bool is_far_wall = true;
  for (std::size_t i = 0; i < all.face.size(); ++i)
    is_far_wall = is_far_wall && (all.face[i] < 0 ? inside.face[i] < 0 : inside.face[i] >= 4);
  CHECK(is_far_wall);
}

TEST_CASE("coverage_of counts the samples that are asked for", "[raster][visibility]") {
  raster::VisibilityBuffer buffer{1, 2, 2, {0, 1, -1, 2, 1, 1, -1, -1}, 0};
  const auto all = raster::coverage_of(buffer);
  CHECK(all(0, 0) == 1.0F);
  CHECK(all(0, 1) == 0.25F);
  const auto ones = raster::coverage_of(buffer, [](std::int32_t face) { return face == 1; });
  CHECK(ones(0, 0) == 0.75F);
  CHECK(ones(0, 1) == 0.0F);
}

TEST_CASE("visibility refuses pictures, cameras and meshes that make no sense", "[raster][visibility]") {
  Mesh mesh = random_triangles(1, 8);
  CHECK_THROWS_AS(raster::visibility(mesh, Camera{}, 0, 4), DomainError);
  CHECK_THROWS_AS(raster::visibility(mesh, Camera{}, 4, std::size_t{1} << 62U), DomainError);
  CHECK_THROWS_AS(raster::visibility(mesh, Camera{}, 4, 4, 3), DomainError);
  Camera camera;
  camera.near = 0;
  CHECK_THROWS_AS(raster::visibility(mesh, camera, 4, 4), DomainError);
  camera = {};
  camera.rotation[1][1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(raster::visibility(mesh, camera, 4, 4), DomainError);
  mesh.faces[0][2] = 3;
  CHECK_THROWS_WITH(raster::visibility(mesh, Camera{}, 4, 4), "visibility: face 0 refers to position 3 of 3");
}
