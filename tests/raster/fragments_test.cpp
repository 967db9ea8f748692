#include <tapestry/raster/detail/face_weights.hpp>
#include <tapestry/raster/fragments.hpp>

#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

namespace raster = tapestry::raster;
using tapestry::geometry::Camera, tapestry::geometry::Mesh, tapestry::geometry::Vector3;

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

TEST_CASE("barycentrics have the same bits with any instruction set, and those of one point at a time nearly",
          "[raster][barycentric]") {
  const Mesh mesh = tapestry::test::random_triangles(40, 2);
  const Camera camera;
  const raster::RayGrid rays(camera, 64, 64);
  tapestry::Random random(3);
  constexpr std::size_t count = 200;
  std::vector<std::int32_t> face(count + 8);
  std::array<std::vector<double>, 2> place{std::vector<double>(count + 8), std::vector<double>(count + 8)};
  for (std::size_t i = 0; i < count; ++i) {
    face[i] = i > 0 && random.chance(0.6) ? face[i - 1] : static_cast<std::int32_t>(random.index(40));
    for (auto& coordinates : place) coordinates[i] = random.uniform(-1, 64);
  }
  std::vector<std::array<std::vector<double>, 3>> found;
  for (const auto set : tapestry::instruction_sets()) {
    auto& b = found.emplace_back();
    for (auto& values : b) values.resize(count + 8);
    const std::array<double*, 3> result{b[0].data(), b[1].data(), b[2].data()};
    raster::raster_kernels_of(set).barycentrics(rays, mesh.faces.data(), mesh.positions.data(), count,
                                                face.data(), place[0].data(), place[1].data(), result.data());
    for (auto& values : b) values.resize(count);
    CHECK(b == found.front());
  }
  raster::Barycentric one(camera, 64, 64);
  double error = 0;
  for (std::size_t i = 0; i < count; ++i) {
    one.select(mesh, mesh.positions, face[i]);
    const auto expected = one.at(place[1][i], place[0][i]);
    for (std::size_t k = 0; k < 3; ++k) error = std::max(error, std::abs(found[0][k][i] - expected[k]));
  }
  CHECK(error <= 1e-9);  // points far outside of steep faces are clamped
}

TEST_CASE("list_fragments packs what fragments() finds, with the same bits for any number of threads",
          "[raster][fragments]") {
  const Mesh mesh = tapestry::test::random_triangles(300, 4, 0.4);
  const Camera camera;
  for (const std::size_t samples : std::vector<std::size_t>{1, 2, 4, 8}) {
    const auto expected = raster::fragments(raster::visibility(mesh, camera, 41, 70, samples), mesh, camera);
    for (const int count : {1, 2, 3, 8}) {
      const tapestry::test::Threads cap(count);
      const auto list = raster::list_fragments(mesh, camera, 41, 70, samples);
      std::size_t next = 0, wrong = 0;
      for (const auto& band : list.bands) {
        for (const auto& fragment : band) {
          if (next == expected.size()) break;
          const auto& e = expected[next++];
          const bool is_same = fragment.pixel == e.pixel && fragment.face == e.face &&
                               static_cast<double>(fragment.coverage) == e.coverage &&
                               fragment.barycentric_0 == static_cast<float>(e.barycentric[0]) &&
                               fragment.barycentric_1 == static_cast<float>(e.barycentric[1]);
          wrong += is_same ? 0 : 1;
        }
      }
      CHECK(next == expected.size());
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("a fragment's barycentrics are those of the mean place of its samples", "[raster][fragments]") {
  // The left part of each pixel row of a wall at z = 2 that ends inside pixel column 1.
  const Mesh mesh =
      tapestry::test::triangle_soup({{Vector3{-9, -9, 2}, Vector3{-0.2, -9, 2}, Vector3{-0.2, 30, 2}}});
  const Camera camera;
  const auto buffer = raster::visibility(mesh, camera, 4, 4, 4);
  double error = 0;
  for (const auto& fragment : raster::fragments(buffer, mesh, camera)) {
    double count = 0, column = 0, row = 0;
    for (std::size_t y = 0; y < 4; ++y) {
      for (std::size_t x = 0; x < 4; ++x) {
        const std::size_t sample_row = fragment.pixel / 4 * 4 + y, sample_column = fragment.pixel % 4 * 4 + x;
        if (buffer.face[sample_row * 16 + sample_column] != 0) continue;
        ++count;
        row += static_cast<double>(sample_row) + 0.5;
        column += static_cast<double>(sample_column) + 0.5;
      }
    }
    CHECK(fragment.coverage == count / 16);
    const Vector3 point = point_of(mesh, fragment);
    error = std::max({error, std::abs(point[0] - 2 * (column / count / 8 - 1)),
                      std::abs(point[1] - 2 * (row / count / 8 - 1))});
  }
  CHECK(error <= 1e-12);
}
