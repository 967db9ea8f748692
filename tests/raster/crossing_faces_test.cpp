#include <tapestry/raster/crossing_faces.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/icosphere.hpp>
#include <vector>

#include "../support/catch.hpp"
#include "../support/refusal.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
namespace geometry = tapestry::geometry;
using geometry::Mesh;
using geometry::Vector3;
using raster::FacePair;
using tapestry::test::check_refused;
using tapestry::test::triangle_soup;

namespace {

std::vector<std::int32_t> all_faces(const Mesh& mesh) {
  std::vector<std::int32_t> all(mesh.faces.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
  return all;
}

std::vector<FacePair> crossings_of(const Mesh& mesh, std::size_t most = raster::most_crossing_pairs) {
  return raster::crossing_faces(mesh, raster::mesh_edges(mesh), all_faces(mesh), most);
}

/// How many pairs of boxes the search compares.
std::size_t candidates_of(const Mesh& mesh) {
  const raster::MeshEdges edges = raster::mesh_edges(mesh);
  return raster::detail::CrossingSearch(mesh, edges, all_faces(mesh)).candidate_count();
}

const Vector3& corner(const Mesh& mesh, std::size_t face, std::size_t k) {
  return mesh.positions[static_cast<std::size_t>(mesh.faces[face][k % 3])];
}

/// Whether a side of one face goes through another one: the volumes of the tetrahedra that it spans with the
/// other's sides have one sign, those with its ends opposite ones.
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

/// Triangles of sizes from `least` to 1, so that many levels of the grid are in use.
Mesh triangles_of_many_sizes(std::size_t count, std::uint64_t seed, double least) {
  tapestry::Random random(seed);
  std::vector<std::array<Vector3, 3>> triangles(count);
  for (auto& triangle : triangles) {
    const double size = std::pow(least, random.uniform(0, 1));
    const Vector3 centre{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    for (auto& point : triangle)
      for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = centre[axis] + random.uniform(-size, size);
  }
  return triangle_soup(triangles);
}

/// Blades that turn about the z axis, which all cut each other along it, and faces that stand apart in a row.
Mesh star(std::size_t blade_count, std::size_t apart) {
  std::vector<std::array<Vector3, 3>> faces(blade_count);
  for (std::size_t i = 0; i < blade_count; ++i) {
    const double angle = 3.14 * static_cast<double>(i) / static_cast<double>(blade_count);
    const double x = std::cos(angle), y = std::sin(angle);
    faces[i] = {Vector3{x, y, -1}, Vector3{-x, -y, -1}, Vector3{0.3 * x, 0.3 * y, 1}};
  }
  for (std::size_t i = 0; i < apart; ++i) {
    const double x = 10 + static_cast<double>(i);
    faces.push_back({Vector3{x, 0, 0}, Vector3{x + 0.5, 0, 0}, Vector3{x, 0.5, 0}});
  }
  return triangle_soup(faces);
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

TEST_CASE("faces without area, far away or nowhere are left out of the search", "[raster][crossing_faces]") {
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

TEST_CASE("a far polygon takes away no crossing of other faces", "[raster][crossing_faces]") {
  Mesh mesh = triangles_of_many_sizes(300, 7, 0.05);
  const auto alone = crossings_of(mesh);
  REQUIRE(alone.size() >= 10);
  for (const double far : {1e12, 1e15}) {
    const Mesh sky =
        triangle_soup({{Vector3{-far, far, far}, Vector3{far, far, 0.9 * far}, Vector3{0, -far, far}}});
    Mesh both = mesh;
    for (const Vector3& position : sky.positions) both.positions.push_back(position);
    both.faces.push_back({900, 901, 902});
    CHECK(crossings_of(both) == alone);
  }
}

TEST_CASE("the search does the same wherever the mesh lies", "[raster][crossing_faces]") {
  Mesh mesh = triangles_of_many_sizes(3000, 11, 1e-2);
  // Multiples of 2⁻²⁰, which doubles hold there as well as here.
  for (Vector3& position : mesh.positions)
    for (double& coordinate : position) coordinate = std::ldexp(std::round(std::ldexp(coordinate, 20)), -20);
  Mesh moved = mesh;
  for (Vector3& position : moved.positions) position = geometry::add(position, {5e6, -4.6e6, 5e6});
  const auto found = crossings_of(mesh);
  CHECK(!found.empty());
  CHECK(crossings_of(moved) == found);
  const auto here = static_cast<double>(candidates_of(mesh)),
             there = static_cast<double>(candidates_of(moved));
  CHECK(there < 1.05 * here);
  CHECK(there > 0.95 * here);
  CHECK(here < 0.1 * 3000 * 3000);
}

TEST_CASE("faces that all cut each other are reported once, up to a limit", "[raster][crossing_faces]") {
  // Were pairs kept once for each of the eight cells that the blades share, they would not fit. With so many
  // faces apart the search has several parts, which count together.
  constexpr std::size_t count = 400, pairs = count * (count - 1) / 2;
  const Mesh mesh = star(count, 5000);
  const auto found = crossings_of(mesh, pairs);
  CHECK(found.size() == pairs);
  CHECK(std::adjacent_find(found.begin(), found.end()) == found.end());
  const int threads = tapestry::thread_count();
  for (const int limit : {1, 3}) {
    tapestry::limit_threads(limit);
    check_refused(tapestry::ErrorKind::limit, "crossing_faces: more than 79799 pairs of faces",
                  [&] { (void)crossings_of(mesh, pairs - 1); });
  }
  tapestry::limit_threads(threads);
}

TEST_CASE("pairs of faces are the same for any number of threads", "[raster][crossing_faces]") {
  const Mesh mesh = triangles_of_many_sizes(6000, 3, 1e-3);
  const int threads = tapestry::thread_count();
  tapestry::limit_threads(1);
  const auto one = crossings_of(mesh);
  tapestry::limit_threads(3);
  CHECK(crossings_of(mesh) == one);
  tapestry::limit_threads(threads);
  CHECK(!one.empty());
}
