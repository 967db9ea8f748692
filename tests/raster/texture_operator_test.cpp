#include <tapestry/raster/cropped.hpp>
#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3, raster::TextureKind;

namespace {
const raster::Light unlit{1, 0, {0, 0, 1}, {1, 1, 1}};

/// A square of two faces over the whole picture; its uv span the picture.
Mesh screen() {
  Mesh mesh;
  mesh.positions = {{-2, -2, 2}, {2, -2, 2}, {2, 2, 2}, {-2, 2, 2}};
  mesh.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};  // v is up, view y is down
  mesh.faces = mesh.face_uvs = {{0, 1, 2}, {0, 2, 3}};
  mesh.face_materials = {-1, -1};
  return mesh;
}

template <class T>
Array<T, 2> numbered_texels(std::size_t count) {
  Array<T, 2> texels(Extents<2>{count, 3});
  for (std::size_t i = 0; i < texels.size(); ++i) texels.data()[i] = static_cast<T>(i);
  return texels;
}
}  // namespace

TEST_CASE("an atlas of the picture's size comes out as it is, row 0 on top", "[raster][atlas]") {
  const raster::TextureLayout layout{TextureKind::atlas, 6, 8, 1, 0};
  const Mesh mesh = screen();
  const auto picture =
      raster::texture_operator<double>({mesh, every_face(mesh), layout}, Camera{}, 6, 8, unlit, 1);
  const auto texels = random_array<double>({48, 3}, 1);
  CHECK(test::largest_difference(raster::render(picture, texels), texels) <= 1e-12);
  for (const double value : picture.coverage.storage()) CHECK(value == 1.0);
}

TEST_CASE("visit_atlas_taps equals weights worked out by hand", "[raster][atlas]") {
  const auto texels = numbered_texels<double>(128);
  const auto lookup = [&](double u, double v) {
    double value = 0, sum = 0;
    raster::visit_atlas_taps(atlas, {u, v}, [&](const raster::Tap& tap) {
      value += tap.weight * static_cast<double>(tap.texel);
      sum += tap.weight;
    });
    CHECK(std::abs(sum - 1) <= 1e-12);
    return value;
  };
  CHECK(lookup(1.0 / 16, 1 - 0.5 / 8) == Approx(0));  // the centre of texel 0
  CHECK(lookup(2.0 / 16, 1 - 1.0 / 8) == Approx((0 + 1 + 16 + 17) / 4.0));
  CHECK(lookup(2, 0) == Approx(127));  // the border itself is not wrapped
  CHECK(lookup(0, 1) == Approx(0));
  CHECK(lookup(2 + 1e-12, -1e-12) == Approx(127));  // nor its rounded values
  CHECK(lookup(2.3, 1.4) == Approx(lookup(0.3, 0.4)));
  CHECK(lookup(-0.7, -3.2) == Approx(lookup(1.3, 0.8)));
}

TEST_CASE("cube taps equal Neural Mesh Renderer's formulas", "[raster][cube]") {
  // w: screen-space barycentrics, z: corner depths, as in its kernel: zp = 1 / Σ w/z, position w·(s−1)·zp/z.
  Random random(3);
  const std::size_t s = 6;
  const raster::TextureLayout layout{TextureKind::cube, 0, 0, 1, s};
  const auto texels = random_array<double>({4 * s * s * s}, 4);
  double error = 0;
  for (int round = 0; round < 2000; ++round) {
    std::array<double, 3> w{random.uniform(), random.uniform(), random.uniform()}, z{};
    if (round % 5 == 0) w[0] = 0;
    if (round % 10 == 0) w[1] = 0;
    const double total = w[0] + w[1] + w[2];
    double inverse = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      w[k] /= total;
      z[k] = random.uniform(0.5, 3);
      inverse += w[k] / z[k];
    }
    std::array<double, 3> c{}, b{};
    for (std::size_t k = 0; k < 3; ++k) {
      b[k] = w[k] / (inverse * z[k]);
      c[k] = std::max(std::min(w[k] * (s - 1) / (inverse * z[k]), s - 1 - 1e-3), 0.0);
    }
    double expected = 0, found = 0;
    for (int i = 0; i < 8; ++i) {
      double weight = 1;
      std::array<std::size_t, 3> at{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double whole = std::floor(c[k]);
        const bool up = ((i >> k) & 1) != 0;
        weight *= up ? c[k] - whole : 1 - (c[k] - whole);
        at[k] = static_cast<std::size_t>(whole) + (up ? 1 : 0);
      }
      if (weight > 0) expected += weight * texels.data()[2 * s * s * s + at[0] * s * s + at[1] * s + at[2]];
    }
    raster::visit_cube_taps(layout, 2, b,
                            [&](const raster::Tap& tap) { found += tap.weight * texels.data()[tap.texel]; });
    error = std::max(error, std::abs(expected - found));
  }
  CHECK(error <= 1e-9);
}

TEST_CASE("a cube of one texel an edge is the face's colour", "[raster][cube]") {
  const Mesh mesh = screen();
  const raster::TextureLayout layout{TextureKind::cube, 0, 0, 1, 1};
  const auto picture =
      raster::texture_operator<float>({mesh, every_face(mesh), layout}, Camera{}, 5, 5, unlit, 2);
  const Array<float, 2> texels = {{1, 0, 0}, {0, 1, 0}};
  const auto image = raster::render(picture, texels);
  CHECK(image(0, 4, 0) == 1.0F);
  CHECK(image(4, 0, 1) == 1.0F);
  CHECK(std::abs(image(2, 2, 0) + image(2, 2, 1) - 1) <= 1e-6F);
}

TEST_CASE("vertex colours are interpolated in perspective, a solid colour is everywhere",
          "[raster][texture_operator]") {
  // Two corners at depth 1, one at 3; the middle of the picture's left edge shows b = (3/4, 0, 1/4).
  const Mesh mesh = triangle_soup({{Vector3{-1, -1, 1}, Vector3{1, -1, 1}, Vector3{-3, 3, 3}}});
  const auto picture =
      raster::texture_operator<double>({mesh, {1}, vertex}, Camera{}, 1000, 1000, raster::Unlit{}, 1);
  const Array<double, 2> texels = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto image = raster::render(picture, texels);
  CHECK(std::abs(image(499, 0, 0) - 0.75) <= 2e-3);
  CHECK(std::abs(image(499, 0, 2) - 0.25) <= 2e-3);
  const auto plain = raster::texture_operator<double>({mesh, {1}, solid}, Camera{}, 9, 9, raster::Unlit{}, 2);
  CHECK(plain.texel_count == 1);
  const Array<double, 2> colour = {{0.25, 0.5, 1}};
  const auto filled = raster::render(plain, colour);
  for (std::size_t pixel = 0; pixel < 81; ++pixel)
    CHECK(filled.data()[3 * pixel + 1] == 0.5 * plain.coverage.data()[pixel]);
}

TEST_CASE("light, coverage and material make the picture of a plain texture", "[raster][texture_operator]") {
  Mesh mesh = random_triangles(40, 5);
  mesh.materials = {{"red", {0.9F, 0.1F, 0.2F}}};
  auto painted = every_face(mesh);
  for (std::size_t face = 0; face < 40; face += 3) {
    painted[face] = 0;
    mesh.face_materials[face] = 0;
  }
  const Camera camera;
  const auto light = raster::face_light(mesh, camera, warm);
  const auto buffer = raster::visibility(mesh, camera, 20, 28, 2);
  for (const auto& layout : {atlas, cube}) {
    const auto picture = raster::texture_operator<double>({mesh, painted, layout}, camera, 20, 28, warm, 2);
    const auto image =
        raster::render(picture, tapestry::filled<double, 2>({layout.texel_count(mesh), 3}, 0.5));
    double error = 0;
    for (std::size_t row = 0; row < 20; ++row) {
      for (std::size_t column = 0; column < 28; ++column) {
        for (std::size_t c = 0; c < 3; ++c) {
          double expected = 0, coverage = 0;
          for (std::size_t s = 0; s < 4; ++s) {
            const auto face = buffer.face[(2 * row + s / 2) * 56 + 2 * column + s % 2];
            if (face < 0) continue;
            const auto f = static_cast<std::size_t>(face);
            const double colour = painted[f] != 0 ? 0.5 : static_cast<double>(mesh.materials[0].colour[c]);
            expected += colour * light[f] * warm.colour[c] / 4;
            coverage += 0.25;
          }
          error = std::max(error, std::abs(image(row, column, c) - expected));
          error = std::max(error, std::abs(picture.coverage(row, column) - coverage));
        }
      }
    }
    CHECK(error <= 1e-12);
  }
}

namespace {
/// |⟨y, Ax⟩ − ⟨Aᵀy, x⟩| over Σ |y · Ax| of a view's linear map, the pyramid of a filtered atlas included.
template <class T, class Model>
double transpose_error(const Mesh& mesh, const raster::TextureLayout& layout, const Model& light,
                       std::size_t samples) {
  auto painted = every_face(mesh);
  painted[7] = 0;
  const auto picture = raster::texture_operator<T>({mesh, painted, layout}, Camera{}, 45, 37, light, samples);
  const auto x = random_array<T>({layout.texel_count(mesh), 3}, 7, -1);
  const auto y = random_array<T>({45, 37, 3}, 8, -1);
  const auto pyramid = raster::pyramid_of({mesh, painted, layout});
  const Array<T, 3> image = raster::render(picture, raster::stored_texels(pyramid, x));
  auto stored = tapestry::zeros<T, 2>({raster::stored_texel_count(layout, mesh), 3});
  raster::render_adjoint(picture, y, stored);
  raster::render_adjoint(picture, y, stored);  // adds
  Array<T, 2> gradient = stored;
  if (pyramid) {
    gradient = tapestry::zeros<T, 2>(x.shape());
    pyramid->adjoint(stored, gradient);
  }
  double forward = 0, backward = 0, size = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const double linear =
        static_cast<double>(image.data()[i]) - static_cast<double>(picture.constant.data()[i]);
    forward += static_cast<double>(y.data()[i]) * linear;
    size += std::abs(static_cast<double>(y.data()[i]) * linear);
  }
  for (std::size_t i = 0; i < x.size(); ++i)
    backward += static_cast<double>(gradient.data()[i]) * static_cast<double>(x.data()[i]) / 2;
  return std::abs(forward - backward) / size;
}
}  // namespace

TEMPLATE_TEST_CASE("render_adjoint is the transpose of render", "[raster][gradient]", float, double) {
  const Mesh mesh = random_triangles(300, 6, 0.4, -1, 3);
  const double bound = std::is_same_v<TestType, float> ? 1e-6 : 1e-12;
  for (const auto& layout : {atlas, trilinear, test::anisotropic, cube, vertex, solid}) {
    for (const std::size_t samples : std::vector<std::size_t>{1, 4})
      CHECK(transpose_error<TestType>(mesh, layout, warm, samples) <= bound);
    CHECK(transpose_error<TestType>(mesh, layout, raster::Unlit{}, 2) <= bound);
    CHECK(transpose_error<TestType>(mesh, layout, raster::SmoothLight{warm}, 2) <= bound);
  }
}

TEMPLATE_TEST_CASE("render_adjoint agrees with central differences", "[raster][gradient]", float, double) {
  const Mesh mesh = random_triangles(20, 9);
  const auto picture =
      raster::texture_operator<TestType>({mesh, every_face(mesh), atlas}, Camera{}, 16, 16, warm);
  const auto texels = random_array<TestType>({128, 3}, 10);
  const auto direction = test::random_direction<TestType>({128, 3}, 11);
  const auto weights = test::random_direction<TestType>({16, 16, 3}, 12);
  const auto value = [&](const auto& x) { return dot(weights, raster::render(picture, x)); };
  auto gradient = tapestry::zeros<TestType, 2>({128, 3});
  raster::render_adjoint(picture, weights, gradient);
  CHECK(std::abs(dot(gradient, direction) - test::central_difference(value, texels, direction)) <=
        test::central_difference_tolerance(value(texels)));
}

TEST_CASE("operator, picture and gradient have the same bits for any number of threads",
          "[raster][texture_operator]") {
  const Mesh mesh = random_triangles(500, 13, 0.3);
  const auto texels = random_array<float>({mesh.faces.size() * 27, 3}, 14);
  const auto y = random_array<float>({70, 90, 3}, 15, -1);
  same_by_threads({1, 3, 4}, [&] {
    const auto picture =
        raster::texture_operator<float>({mesh, every_face(mesh), cube}, Camera{}, 70, 90, warm);
    auto gradient = tapestry::zeros<float, 2>({mesh.faces.size() * 27, 3});
    raster::render_adjoint(picture, y, gradient);
    return std::pair(raster::render(picture, texels), gradient);
  });
}

TEST_CASE("a view without the mesh, a view of one pixel and a mesh of one face",
          "[raster][texture_operator]") {
  Mesh mesh = triangle_soup({{Vector3{-9, -9, 2}, Vector3{30, -9, 2}, Vector3{-9, 30, 2}}});
  Camera away;
  away.translation = {0, 0, -20};
  const auto texels = random_array<double>({128, 3}, 16);
  const auto empty = raster::texture_operator<double>({mesh, {1}, atlas}, away, 9, 7, warm);
  CHECK(empty.pixels.empty());
  CHECK((raster::render(empty, texels) == tapestry::zeros<double, 3>({9, 7, 3})));
  auto gradient = tapestry::zeros<double, 2>({128, 3});
  raster::render_adjoint(empty, random_array<double>({9, 7, 3}, 17), gradient);
  CHECK((gradient == tapestry::zeros<double, 2>({128, 3})));

  const auto one = raster::texture_operator<double>({mesh, {1}, atlas}, Camera{}, 1, 1, unlit);
  REQUIRE(one.pixels.size() == 1);
  double sum = 0;
  for (const double weight : one.weights) sum += weight;
  CHECK(std::abs(sum - 1) <= 1e-12);
  CHECK(raster::memory_bytes(one) >= sizeof(double) * (one.weights.size() + 4));
}

TEST_CASE("texture_operator refuses what does not fit", "[raster][texture_operator]") {
  Mesh mesh = random_triangles(2, 18);
  const auto make = [&](const raster::TextureLayout& layout, const std::vector<std::uint8_t>& painted) {
    return raster::texture_operator<float>({mesh, painted, layout}, Camera{}, 8, 8, warm);
  };
  CHECK_THROWS_WITH(make(atlas, {1}), "texture_operator: painted is [1], expected [2], one entry a face");
  CHECK_THROWS_AS(make({TextureKind::atlas, 0, 4, 1, 0}, {1, 1}), DomainError);
  CHECK_THROWS_AS(make({TextureKind::atlas, 4, 4, 0, 0}, {1, 1}), DomainError);
  CHECK_THROWS_AS(make({TextureKind::cube, 4, 4, 1, 0}, {1, 1}), DomainError);
  const auto picture = make(atlas, {1, 1});
  CHECK_THROWS_WITH(raster::render(picture, tapestry::zeros<float, 2>({5, 3})),
                    "render: texels is [5, 3], expected [128, 3]");
  auto gradient = tapestry::zeros<float, 2>({128, 3});
  CHECK_THROWS_AS(raster::render_adjoint(picture, tapestry::zeros<float, 3>({8, 9, 3}), gradient),
                  ShapeError);
  mesh.uvs[4][0] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(make(atlas, {1, 1}),
                    contains("face 1 is painted from an atlas but has a uv that is not finite"));
  CHECK_NOTHROW(make(atlas, {1, 0}));
  mesh.face_uvs[0][1] = -1;
  CHECK_THROWS_WITH(make(atlas, {1, 0}), "texture_operator: face 0 is painted from an atlas but has no uv");
  mesh.face_uvs[0][1] = 1048576;
  CHECK_THROWS_WITH(make(atlas, {1, 0}),
                    "texture_operator: face 0 is painted from an atlas but refers to uv 1048576 of 6");
  CHECK_THROWS_WITH(raster::render_textured({mesh, {1, 0}, atlas}, Camera{}, 8, 8, warm,
                                            tapestry::zeros<float, 2>({128, 3})),
                    contains("render_textured: face 0 is painted from an atlas but refers to uv"));
  mesh.face_uvs.clear();
  CHECK_THROWS_AS(make(atlas, {1, 0}), Error);
  CHECK_NOTHROW(make(cube, {1, 1}));
}
