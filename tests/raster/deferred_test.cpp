#include <tapestry/raster/deferred.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Vector3;

namespace {
/// [V, 3]
template <class T>
Array<T, 2> positions_of(const geometry::Mesh& mesh) {
  Array<T, 2> positions(Extents<2>{mesh.positions.size(), 3});
  for (std::size_t i = 0; i < positions.size(); ++i)
    positions.data()[i] = static_cast<T>(mesh.positions[i / 3][i % 3]);
  return positions;
}

raster::PixelFaces seen(const geometry::Mesh& mesh, std::size_t height, std::size_t width,
                        const geometry::Camera& camera = {}) {
  return raster::pixel_faces(std::make_shared<const geometry::Mesh>(mesh), camera, height, width);
}

/// The rectangle [left, right] × [−1.5, 1.5] at z = 2, facing the default camera: two faces.
geometry::Mesh rectangle(double left, double right, double z = 2) {
  geometry::Mesh mesh;
  mesh.positions = {{left, -1.5, z}, {right, -1.5, z}, {right, 1.5, z}, {left, 1.5, z}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.uvs = {{0.1, 0.9}, {0.9, 0.9}, {0.9, 0.1}, {0.1, 0.1}};
  mesh.face_uvs = mesh.faces;
  return mesh;
}

/// A bumpy sphere before a rectangle, seen from the side: outlines before a background and before faces.
geometry::Mesh crowded() {
  auto mesh = test::bumpy_sphere(1, 0.15, 3);
  for (auto& p : mesh.positions) p = {0.9 * p[0] + 0.07, 0.9 * p[1] - 0.05, 0.9 * p[2] + 3};
  const auto behind = rectangle(-2.1, 1.3, 4.5);
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), behind.positions.begin(), behind.positions.end());
  for (const auto& face : behind.faces)
    mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
  return mesh;
}

/// Of length one, with the extents of another array.
template <class T, std::size_t Rank>
Array<T, Rank> direction_like(const Array<T, Rank>& other, std::uint64_t seed) {
  const auto numbers = random_direction<T>({other.size()}, seed);
  Array<T, Rank> direction(other.shape());
  std::copy(numbers.begin(), numbers.end(), direction.begin());
  return direction;
}

/// ⟨weights, f⟩ of f: ArrayVariable<T, Rank> → ArrayVariable<T, 3>, beside central differences.
template <class T, std::size_t Rank, class F>
void check_gradient(const F& f, const Array<T, Rank>& x, double looser = 1) {
  const auto value_and_gradient = [&](const Array<T, Rank>& at) {
    ActiveTape<T> tape;
    const auto input = tape.input(at);
    const ArrayVariable<T, 3> out = f(input);
    const auto weights = direction_like(out.value(), 9);
    tape.reverse(out, weights);
    return std::pair(test::dot(weights, out.value()), input.adjoint());
  };
  const auto gradient = value_and_gradient(x).second;
  const auto value = [&](const Array<T, Rank>& at) { return value_and_gradient(at).first; };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto direction = direction_like(x, seed);
    const T expected = test::central_difference(value, x, direction);
    CHECK(std::abs(expected) > T(1e-3));
    CHECK(std::abs(test::dot(gradient, direction) - expected) <=
          static_cast<T>(looser) * test::central_difference_tolerance(T(1) + std::abs(expected)));
  }
}
}  // namespace

TEST_CASE("barycentric coordinates sum to 1 and interpolate positions onto the pixels' rays",
          "[raster][deferred]") {
  const auto mesh = crowded();
  const auto camera = geometry::look_at({0.4, -0.3, -0.2}, {0, 0, 3}, {0, -1, 0}, 1.3, 1.1);
  const auto pixels = seen(mesh, 21, 30, camera);
  const auto b = raster::barycentrics<double>(pixels);
  const auto points = raster::interpolate(pixels, b, positions_of<double>(mesh), mesh.faces);
  std::size_t count = 0;
  for (std::size_t row = 0; row < 21; ++row)
    for (std::size_t column = 0; column < 30; ++column) {
      const bool shows = pixels.face[30 * row + column] >= 0;
      CHECK(b(row, column, 0) + b(row, column, 1) + b(row, column, 2) == Approx(shows ? 1 : 0));
      if (!shows) continue;
      ++count;
      const Vector3 point{points(row, column, 0), points(row, column, 1), points(row, column, 2)};
      const auto place =
          geometry::picture_from_view(camera, geometry::view_from_world(camera, point), 21, 30);
      CHECK(place[0] == Approx(static_cast<double>(row) + 0.5).epsilon(1e-10));
      CHECK(place[1] == Approx(static_cast<double>(column) + 0.5).epsilon(1e-10));
    }
  CHECK(count > 100);
}

TEST_CASE("uvs of a rectangle in front of the camera are those worked out by hand", "[raster][deferred]") {
  // Columns −1 … 1 of 8 pixels of 0.5 units at z = 2: the centre of column j lies at x = (j + ½) / 2 − 2.
  const auto rasterised = raster::rasterise<double>(rectangle(-1, 1), {}, 8, 8);
  const auto uv = raster::texture_coordinates(rasterised).value();
  CHECK(uv(4, 2, 0) == Approx(0.1 + 0.8 * (-0.75 + 1) / 2));
  CHECK(uv(4, 5, 0) == Approx(0.1 + 0.8 * (0.75 + 1) / 2));
  CHECK(uv(1, 3, 1) == Approx(0.9 - 0.8 * (-1.25 + 1.5) / 3));
  CHECK((uv(4, 1, 0) == 0 && uv(4, 6, 0) == 0));
  const auto ones = raster::interpolate(rasterised, tapestry::filled<double, 2>({4, 1}, 1.0)).value();
  CHECK(ones(4, 2, 0) == Approx(1));
  CHECK(ones(4, 1, 0) == 0);
}

TEST_CASE("a lookup of texel centres gives texels, and between them their mean", "[raster][deferred]") {
  const auto texture = random_array<double>({3, 4, 2}, 1);
  const Array<double, 3> uv = {{{0.125, 5.0 / 6}, {0.5, 0.5}, {1.625, -0.5}}};
  const auto found = raster::look_up(texture, uv);
  for (std::size_t c = 0; c < 2; ++c) {
    CHECK(found(0, 0, c) == Approx(texture(0, 0, c)));
    CHECK(found(0, 1, c) == Approx((texture(1, 1, c) + texture(1, 2, c)) / 2));
    CHECK(found(0, 2, c) == Approx((texture(1, 2, c))));  // repeats: u = 0.625, v = 0.5
  }
}

TEST_CASE("an outline along columns blends by the share of the pixel that it covers", "[raster][deferred]") {
  // In 10 pixels of 0.4 units the right side lies at column 5 + 2.5·right, here 7.3 and 7.7.
  for (const double right : {0.92, 1.08}) {
    const auto pixels = seen(rectangle(-1.0, right), 10, 10);
    Array<double, 3> colour = tapestry::zeros<double, 3>({10, 10, 1});
    for (std::size_t i = 0; i < 100; ++i) colour.data()[i] = pixels.face[i] >= 0 ? 2 : 0.5;
    const auto out = raster::antialias(pixels, colour);
    const double covered = 5 + 2.5 * right - 7;
    CHECK(out(5, 7, 0) == Approx(0.5 + 1.5 * covered).epsilon(1e-12));
    CHECK(out(5, 6, 0) == 2);  // nothing blends between the rectangle's two faces
    CHECK(out(5, 8, 0) == 0.5);
    std::vector<Vector3> gradient(4, Vector3{0, 0, 0});
    Array<double, 3> row = tapestry::zeros<double, 3>({10, 10, 1});
    row(5, 7, 0) = 1;
    raster::antialias_adjoint<double>(pixels, colour, row, nullptr, &gradient);
    CHECK(gradient[1][0] + gradient[2][0] == Approx(1.5 * 2.5));  // both ends of the side to the right
    CHECK(gradient[0][0] + gradient[3][0] == Approx(0).margin(1e-12));
  }
}

TEST_CASE("antialiasing keeps a constant, and is linear with its adjoint as the transpose",
          "[raster][deferred]") {
  const auto pixels = seen(crowded(), 24, 26);
  const auto constant = tapestry::filled<double, 3>({24, 26, 3}, 0.3);
  CHECK((raster::antialias(pixels, constant) == constant));
  const auto x = random_array<double>({24, 26, 3}, 1), y = random_array<double>({24, 26, 3}, 2);
  Array<double, 3> transposed = xt::zeros_like(x);
  raster::antialias_adjoint<double>(pixels, x, y, &transposed, nullptr);
  CHECK(test::dot(raster::antialias(pixels, x), y) == Approx(test::dot(x, transposed)));
  CHECK((raster::antialias(pixels, x) != x));
}

TEMPLATE_TEST_CASE("each step agrees with central differences", "[raster][deferred][gradient]", float,
                   double) {
  using T = TestType;
  const auto mesh = rectangle(-0.93, 1.08);
  const auto positions = positions_of<T>(mesh);
  const auto attributes = random_array<T>({4, 3}, 1);
  const auto texture = random_array<T>({3, 3, 3}, 2);
  SECTION("interpolation, by attributes and by positions") {
    check_gradient(
        [&](const ArrayVariable<T, 2>& x) {
          return raster::interpolate(raster::rasterise<T>(mesh, {}, 9, 9), x);
        },
        attributes);
    check_gradient(
        [&](const ArrayVariable<T, 2>& x) {
          return raster::interpolate(raster::rasterise<T>(mesh, {}, 9, 9, x), attributes);
        },
        positions);
  }
  SECTION("lookup, by texture and by uv") {
    const auto uv = random_array<T>({2, 3, 2}, 6, 0.2, 0.45);  // between the same four texels
    check_gradient([&](const ArrayVariable<T, 3>& x) { return raster::look_up<T>(x, uv); }, texture);
    check_gradient([&](const ArrayVariable<T, 3>& x) { return raster::look_up<T>(texture, x); }, uv);
  }
  SECTION("antialiasing, by colours and by positions") {
    const auto colour = random_array<T>({9, 9, 3}, 4);
    check_gradient(
        [&](const ArrayVariable<T, 3>& x) {
          return raster::antialias(raster::rasterise<T>(mesh, {}, 9, 9), x);
        },
        colour);
    check_gradient(
        [&](const ArrayVariable<T, 2>& x) {
          return raster::antialias(raster::rasterise<T>(mesh, {}, 9, 9, x), colour);
        },
        positions);
  }
}

TEST_CASE("a crowded picture shaded by a user's formula agrees with central differences by positions",
          "[raster][deferred][gradient]") {
  const auto mesh = crowded();
  const auto camera = geometry::look_at({0.4, -0.3, -0.2}, {0, 0, 3}, {0, -1, 0}, 1.3, 1.1);
  const auto faces = seen(mesh, 33, 35, camera).face;
  const auto picture = [&](const ArrayVariable<double, 2>& x) {
    const auto rasterised = raster::rasterise<double>(mesh, camera, 33, 35, x);
    REQUIRE(rasterised.pixels->face == faces);  // the step is too short to change a pixel's face
    const auto point = raster::interpolate(rasterised, x);
    const auto shows = raster::interpolate(rasterised, tapestry::filled<double, 2>({x.shape()[0], 3}, 1.0));
    return raster::antialias(rasterised, shows * (0.5 + 0.4 * sin(3.0 * point)) + (1.0 - shows) * 0.2);
  };
  check_gradient(picture, positions_of<double>(mesh), 10);  // the second derivative of 1 / (A − B) is large
}

TEST_CASE("deferred shading has the same bits on one thread and two", "[raster][deferred][determinism]") {
  const auto mesh = crowded();
  same_by_threads({1, 2}, [&] {
    ActiveTape<float> tape;
    const auto x = tape.input(positions_of<float>(mesh));
    const auto rasterised = raster::rasterise<float>(mesh, {}, 40, 40, x);
    const auto out = raster::antialias(rasterised, raster::interpolate(rasterised, x));
    tape.reverse(out, random_array<float>({40, 40, 3}, 1));
    return std::pair(out.value(), x.adjoint());
  });
}

TEST_CASE("deferred shading takes meshes with nothing to see", "[raster][deferred]") {
  const auto empty = seen(geometry::Mesh{}, 3, 4);
  CHECK((raster::barycentrics<double>(empty) == tapestry::zeros<double, 3>({3, 4, 3})));
  auto broken = rectangle(-1, 1);
  broken.positions[0][1] = std::numeric_limits<double>::quiet_NaN();  // of both faces
  const auto pixels = seen(broken, 3, 4);
  const auto colour = random_array<double>({3, 4, 3}, 1);
  CHECK((raster::antialias(pixels, colour) == colour));
}

TEST_CASE("deferred shading refuses what does not fit", "[raster][deferred][bad_input]") {
  const auto mesh = rectangle(-1, 1);
  const auto pixels = seen(mesh, 8, 8);
  const auto b = raster::barycentrics<double>(pixels);
  const auto few = random_array<double>({3, 2}, 1);
  const auto small = random_array<double>({8, 7, 3}, 2);
  std::vector<Vector3> gradient(3);
  CHECK_THROWS_WITH(raster::interpolate(pixels, b, few, mesh.faces),
                    "interpolate: face 1 refers to attribute 3 of 3");
  CHECK_THROWS_WITH(raster::interpolate(pixels, b, few, {}), "interpolate: corners of 0 faces, expected 2");
  CHECK_THROWS_AS(raster::interpolate(pixels, small, few, mesh.faces), ShapeError);
  CHECK_THROWS_AS(raster::antialias(pixels, small), ShapeError);
  CHECK_THROWS_AS(raster::barycentrics_adjoint(pixels, b, gradient), ShapeError);
  CHECK_THROWS_AS(raster::antialias_adjoint<double>(pixels, b, b, nullptr, &gradient), ShapeError);
  CHECK_THROWS_AS(raster::look_up(small, small), ShapeError);
  CHECK_THROWS_WITH(raster::look_up(Array<double, 3>(), random_array<double>({2, 2, 2}, 1)),
                    "look_up: the texture has no texel, expected one at least");
  CHECK_THROWS_AS(raster::rasterise<double>(mesh, {}, 8, 8, few), ShapeError);
  const auto other = std::make_shared<const raster::MeshEdges>(raster::mesh_edges(crowded()));
  CHECK_THROWS_AS(raster::rasterise<double>(mesh, {}, 8, 8, {}, other), ShapeError);
}
