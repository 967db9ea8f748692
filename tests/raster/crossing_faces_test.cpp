#include <tapestry/raster/detail/crossing_faces.hpp>

#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Mesh, geometry::Vector3, raster::FacePair;

namespace {
/// Crossings in a picture of one pixel that shows all faces.
std::vector<FacePair> crossings_of(const Mesh& mesh) {
  raster::SeenFaces seen(1, 1, 1);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) seen.band(0).add(0, static_cast<std::int32_t>(i));
  return raster::crossing_faces(mesh, raster::mesh_edges(mesh), seen);
}

const Vector3& corner(const Mesh& mesh, std::size_t face, std::size_t k) {
  return mesh.positions[static_cast<std::size_t>(mesh.faces[face][k % 3])];
}

/// Whether a side of one face goes through another one: the tetrahedra of it and the other's sides have
/// volumes of one sign, those with its ends of opposite signs.
bool pierces(const Mesh& mesh, std::size_t face, std::size_t other) {
  const auto volume = [](const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
    return geometry::dot(geometry::subtract(a, d),
                         geometry::cross(geometry::subtract(b, d), geometry::subtract(c, d)));
  };
  const Vector3 &a = corner(mesh, other, 0), &b = corner(mesh, other, 1), &c = corner(mesh, other, 2);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 &p = corner(mesh, face, k), &q = corner(mesh, face, k + 1);
    if (volume(a, b, c, p) * volume(a, b, c, q) >= 0) continue;
    const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
    if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)) return true;
  }
  return false;
}

/// Triangles of sizes from `least` to 1.
Mesh triangles_of_many_sizes(std::size_t count, std::uint64_t seed, double least) {
  Random random(seed);
  std::vector<std::array<Vector3, 3>> triangles(count);
  for (auto& triangle : triangles) {
    const double size = std::pow(least, random.uniform(0, 1));
    const Vector3 centre{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    for (auto& point : triangle)
      for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = centre[axis] + random.uniform(-size, size);
  }
  return triangle_soup(triangles);
}
}  // namespace

TEST_CASE("every pair of faces that cut each other is found, and few others", "[raster][crossing_faces]") {
  for (const double least : {1e-4, 0.05, 1.0}) {
    const Mesh mesh = triangles_of_many_sizes(300, 7, least);
    const auto found = crossings_of(mesh);
    CHECK(std::is_sorted(found.begin(), found.end()));
    CHECK(std::adjacent_find(found.begin(), found.end()) == found.end());
    std::size_t expected = 0, missed = 0;
    for (std::int32_t i = 0; i < 300; ++i) {
      for (std::int32_t j = i + 1; j < 300; ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        if (!pierces(mesh, a, b) && !pierces(mesh, b, a)) continue;
        ++expected;
        missed += std::binary_search(found.begin(), found.end(), FacePair{i, j}) ? 0U : 1U;
      }
    }
    REQUIRE(expected >= 10);
    CHECK(missed == 0);
    CHECK(found.size() <= 4 * expected);
  }
}

TEST_CASE("a closed convex surface, coincident faces and neighbours do not cut each other",
          "[raster][crossing_faces]") {
  Mesh sphere = geometry::icosphere(3, 1.2, {0, 0, 0.7});
  CHECK(crossings_of(sphere).empty());
  const std::size_t count = sphere.faces.size();
  for (std::size_t face = 0; face < count; ++face) sphere.faces.push_back(sphere.faces[face]);
  CHECK(crossings_of(sphere).empty());
  const Vector3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  CHECK(crossings_of(triangle_soup({{a, b, c}, {c, b, a}, {a, b, Vector3{0.3, 0.3, 1}}})).empty());
}

TEST_CASE("faces without area, far away or nowhere cut none", "[raster][crossing_faces]") {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  for (const double far : {1e9, 1e12, 1e15}) {
    const Mesh mesh =
        triangle_soup({{Vector3{-1, 0, -1}, Vector3{1, 0, -1}, Vector3{0, 0, 2}},
                       {Vector3{0, 3, 0}, Vector3{0, 3, 0}, Vector3{0, 3, 0}},
                       {Vector3{nan, 0, 0}, Vector3{0, nan, 0}, Vector3{0, 0, nan}},
                       {Vector3{infinite, 0, 0}, Vector3{0, -infinite, 0}, Vector3{0, 1, 0}},
                       {Vector3{1e200, 0, 0}, Vector3{0, 1e200, 0}, Vector3{0, 0, -1e200}},
                       {Vector3{0.1, -1, 0}, Vector3{0.1, 1, 0}, Vector3{0.2, 1, 0.3}},
                       {Vector3{-far, far, 0.1}, Vector3{far, far, 0.1}, Vector3{0, -far, 0.1}}});
    CHECK(crossings_of(mesh) == std::vector<FacePair>{{0, 5}, {0, 6}, {5, 6}});
  }
  CHECK(crossings_of(Mesh{}).empty());
}

TEST_CASE("faces cut each other that pixels side by side or one above the other show",
          "[raster][crossing_faces]") {
  const Mesh mesh = triangle_soup({{Vector3{-1, 0, -1}, Vector3{1, 0, -1}, Vector3{0, 0, 2}},
                                   {Vector3{0.1, -1, 0}, Vector3{0.1, 1, 0}, Vector3{0.2, 1, 0.3}}});
  const auto pixels_cross = [&](std::size_t first, std::size_t second) {
    constexpr std::size_t width = 4, band_rows = 2, bands = 2;
    raster::SeenFaces seen(width, band_rows, bands);
    seen.band(first / (width * band_rows)).add(first, 0);
    seen.band(second / (width * band_rows)).add(second, 1);
    return crossing_faces(mesh, raster::mesh_edges(mesh), seen) == std::vector<FacePair>{{0, 1}};
  };
  CHECK(pixels_cross(5, 5));
  CHECK(pixels_cross(5, 6));
  CHECK(pixels_cross(2, 6));
  CHECK(pixels_cross(6, 10));       // of two bands
  CHECK_FALSE(pixels_cross(3, 4));  // the last of a row and the first of the next
  CHECK_FALSE(pixels_cross(1, 3));
  CHECK_FALSE(pixels_cross(0, 15));
}

TEST_CASE("pairs of faces are the same wherever the mesh lies", "[raster][crossing_faces]") {
  Mesh mesh = triangles_of_many_sizes(1000, 11, 1e-2);
  // Multiples of 2⁻²⁰, which doubles hold there as well as here.
  for (Vector3& position : mesh.positions)
    for (double& coordinate : position) coordinate = std::ldexp(std::round(std::ldexp(coordinate, 20)), -20);
  Mesh moved = mesh;
  for (Vector3& position : moved.positions) position = geometry::add(position, {5e6, -4.6e6, 5e6});
  const auto found = crossings_of(mesh);
  CHECK(!found.empty());
  CHECK(crossings_of(moved) == found);
}

TEST_CASE("faces meet in pixels that show both, or beside each other, once in however many",
          "[raster][crossing_faces]") {
  const Mesh mesh = triangles_of_many_sizes(40, 5, 0.3);
  const auto edges = raster::mesh_edges(mesh);
  const auto all = crossings_of(mesh);
  REQUIRE(all.size() >= 10);
  constexpr std::size_t width = 70, rows = 3;
  const auto pairs_seen = [&](auto shows) {  // by two bands, the second of fewer rows
    raster::SeenFaces seen(width, 2, 2);
    for (std::size_t pixel = 0; pixel < rows * width; ++pixel)
      for (std::int32_t face = 0; face < 40; ++face)
        for (int sample = 0; shows(pixel, face) && sample < 2; ++sample)
          seen.band(pixel / (2 * width)).add(pixel, face);
    return raster::crossing_faces(mesh, edges, seen);
  };
  CHECK(pairs_seen([](std::size_t, std::int32_t) { return true; }) == all);
  const auto apart = [](std::size_t pixel, std::int32_t face) {  // every other pixel of every other row
    const std::size_t row = pixel / width, column = pixel % width;
    return row % 2 == 0 && column % 2 == 0 &&
           (column + row * width / 2) / 2 % 40 == static_cast<std::size_t>(face);
  };
  CHECK(pairs_seen(apart).empty());
  const FacePair& one = all[all.size() / 2];
  CHECK(pairs_seen([&](std::size_t pixel, std::int32_t face) {
          return pixel == 150 ? face == one.first || face == one.second : apart(pixel, face);
        }) == std::vector<FacePair>{one});
}

TEST_CASE("what is seen is listed pixel by pixel", "[raster][crossing_faces]") {
  raster::SeenFaces seen(4, 2, 2);
  seen.band(0).add(2, 7);
  seen.band(0).add(2, 7);  // another sample of it
  seen.band(0).add(2, 5);
  seen.band(0).add(6, 5);
  seen.band(1).add(9, 1);
  const auto at = [&](std::size_t pixel) {
    const auto faces = seen.at(pixel);
    return std::vector<std::int32_t>(faces.begin(), faces.end());
  };
  CHECK(at(2) == std::vector<std::int32_t>{7, 5});
  CHECK(at(6) == std::vector<std::int32_t>{5});
  CHECK(at(9) == std::vector<std::int32_t>{1});
  for (const std::size_t pixel : {0U, 1U, 3U, 5U, 7U, 8U, 10U, 15U, 16U, 100U}) CHECK(at(pixel).empty());
  CHECK(raster::SeenFaces{}.at(0).empty());
}

TEST_CASE("pairs of faces are the same for any number of threads", "[raster][crossing_faces]") {
  const Mesh mesh = triangles_of_many_sizes(400, 3, 1e-1);
  const auto edges = raster::mesh_edges(mesh);
  raster::SeenFaces seen(8, 1, 9);
  for (std::size_t pixel = 0; pixel < 72; ++pixel)
    for (std::int32_t face = 0; face < 400; ++face)
      if ((static_cast<std::size_t>(face) * 31 + pixel) % 7 < 3) seen.band(pixel / 8).add(pixel, face);
  CHECK(!same_by_threads({1, 3}, [&] { return raster::crossing_faces(mesh, edges, seen); }).empty());
}
