// Cases that other renderers are known to fail at, from the mesh to the gradients.
#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/detail/vertex_gradient.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3, raster::TextureKind;

namespace {
Array<double, 3> picture_of(const Mesh& mesh, const raster::TextureLayout& layout, std::size_t height,
                            std::size_t width, std::uint64_t seed = 1) {
  const auto view = raster::texture_operator<double>({mesh, every_face(mesh), layout}, Camera{}, height,
                                                     width, raster::Unlit{}, 4);
  return raster::render(view, random_array<double>({view.texel_count, 3}, seed));
}

bool is_finite(const std::vector<Vector3>& gradient) {
  return std::all_of(gradient.begin(), gradient.end(),
                     [](const Vector3& value) { return geometry::is_finite(value); });
}

std::vector<Vector3> vertex_gradient(const Mesh& mesh, std::size_t height, std::size_t width) {
  const raster::PaintedMesh body{mesh, every_face(mesh), vertex};
  const auto colours = random_array<double>({mesh.positions.size(), 3}, 2);
  std::vector<Vector3> gradient(mesh.positions.size(), Vector3{0, 0, 0});
  raster::vertex_adjoint(raster::Surface<double, raster::Light>{body, colours, warm}, Camera{},
                         random_array<double>({height, width, 3}, 3), gradient);
  return gradient;
}

/// A square over the whole picture, its diagonal split into slivers that are 1e-3 to 1e-12 wide.
Mesh sliced_square() {
  std::vector<std::array<Vector3, 3>> triangles;
  const Vector3 low{-2, -2, 2}, high{2, 2, 2};
  Vector3 from{2, -2, 2};
  for (double width = 1e-3; width >= 1e-12; width /= 10) {
    const Vector3 to{2 - width, -2 + 0.3 * width, 2};
    triangles.push_back({low, from, high});
    triangles.push_back({low, to, from});
    from = to;
  }
  triangles.push_back({low, from, high});
  triangles.push_back({low, high, Vector3{-2, 2, 2}});
  return triangle_soup(triangles);
}
}  // namespace

TEST_CASE("slivers down to 1e-12 of a unit leave no hole, no number that is none, and barycentrics in [0, 1]",
          "[raster][hard_case]") {
  const Mesh mesh = sliced_square();
  const auto buffer = raster::visibility(mesh, Camera{}, 40, 50, 4);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), -1) == 0);
  bool is_inside = true;
  for (const auto& fragment : raster::fragments(buffer, mesh, Camera{}, raster::FragmentGrain::sample))
    for (const double b : fragment.barycentric) is_inside = is_inside && b >= 0 && b <= 1;
  CHECK(is_inside);
  for (const auto& layout : {atlas, trilinear, anisotropic, cube, vertex}) {
    const auto picture = picture_of(mesh, layout, 40, 50);
    CHECK(std::all_of(picture.data(), picture.data() + picture.size(),
                      [](double value) { return value >= 0 && value <= 1; }));
  }
  CHECK(is_finite(vertex_gradient(mesh, 40, 50)));
}

TEST_CASE("a corner in the camera, and in the camera's plane, gives no number that is none",
          "[raster][hard_case]") {
  const Mesh mesh = triangle_soup({{Vector3{0, 0, 0}, Vector3{1, 0.2, 3}, Vector3{-0.4, 1, 3}},
                                   {Vector3{0.5, 0.5, 0}, Vector3{-1, 0.1, 2}, Vector3{-1, 1, 2}},
                                   {Vector3{-3, -1, 0}, Vector3{3, -1, 0}, Vector3{0, -1, 8}}});
  for (const auto& layout : {atlas, trilinear, anisotropic, cube, vertex}) {
    const auto picture = picture_of(mesh, layout, 33, 47);
    CHECK(std::all_of(picture.data(), picture.data() + picture.size(),
                      [](double value) { return value >= 0 && value <= 1; }));
    CHECK(*std::max_element(picture.data(), picture.data() + picture.size()) > 0.1);
  }
  CHECK(is_finite(vertex_gradient(mesh, 33, 47)));
}

TEST_CASE("uv beyond the atlas repeat it", "[raster][hard_case]") {
  // Within the atlas by a texel, so that no lookup reaches over its border.
  const Mesh mesh = test::random_triangles(200, 4, 0.5, 0.2, 0.8);
  Mesh far = mesh;
  Random random(5);
  for (std::size_t face = 0; face < far.faces.size(); ++face) {
    const std::array<double, 2> whole{std::floor(random.uniform(-5, 5)), std::floor(random.uniform(-5, 5))};
    for (const std::int32_t corner : far.face_uvs[face]) {
      auto& uv = far.uvs[static_cast<std::size_t>(corner)];
      uv = {uv[0] + atlas.u_extent * whole[0], uv[1] + whole[1]};
    }
  }
  CHECK(largest_difference(picture_of(mesh, atlas, 64, 64), picture_of(far, atlas, 64, 64)) <= 1e-12);
  CHECK(largest_difference(picture_of(mesh, trilinear, 64, 64), picture_of(far, trilinear, 64, 64)) <= 1e-12);
}

TEST_CASE("a face whose uv have no area shows one colour", "[raster][hard_case]") {
  const Vector3 a{-2, -2, 2}, b{6, -2, 2}, c{-2, 6, 2};
  for (const auto& layout : {atlas, trilinear, anisotropic}) {
    const auto texels = random_array<double>({layout.height * layout.width, 3}, 6);
    const auto view = raster::texture_operator<double>(
        {triangle_soup({{a, b, c}}, {{{0.3, 0.6}, {0.3, 0.6}, {0.3, 0.6}}}), {1}, layout}, Camera{}, 16, 16,
        raster::Unlit{}, 4);
    const auto picture =
        raster::render(view, raster::is_filtered(layout) ? raster::MipPyramid(layout)(texels) : texels);
    std::array<double, 3> expected{};
    raster::visit_atlas_taps(layout, {0.3, 0.6}, [&](const raster::Tap& tap) {
      for (std::size_t channel = 0; channel < 3; ++channel)
        expected[channel] += tap.weight * texels(tap.texel, channel);
    });
    double error = 0;
    for (std::size_t i = 0; i < picture.size(); ++i)
      error = std::max(error, std::abs(picture.data()[i] - expected[i % 3]));
    CHECK(error <= 1e-12);
  }
}

TEST_CASE("a seam between two charts mixes no colour of what lies beside them", "[raster][hard_case]") {
  // Left half of the square from a red chart, right half from a green one; between them the atlas is blue.
  const Vector3 a{-2, -2, 2}, b{0.1, -2, 2}, c{0.1, 2, 2}, d{-2, 2, 2}, e{2, -2, 2}, f{2, 2, 2};
  Mesh mesh;
  mesh.positions = {a, b, c, d, e, f};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  mesh.uvs = {{0.1, 0.9}, {0.4, 0.9}, {0.4, 0.1}, {0.1, 0.1}, {1.5, 0.9}, {1.9, 0.9}, {1.9, 0.1}, {1.5, 0.1}};
  mesh.face_uvs = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  mesh.face_materials = {-1, -1, -1, -1};
  const raster::TextureLayout wide{TextureKind::atlas, 8, 64, 2, 0};
  auto texels = tapestry::zeros<double, 2>({8 * 64, 3});
  for (std::size_t i = 0; i < texels.shape(0); ++i) texels(i, i % 64 < 16 ? 0 : i % 64 >= 46 ? 1 : 2) = 1;
  const auto view =
      raster::texture_operator<double>({mesh, every_face(mesh), wide}, Camera{}, 32, 32, raster::Unlit{}, 8);
  const auto picture = raster::render(view, texels);
  double blue = 0, darkest = 1;
  for (std::size_t pixel = 0; pixel < 32 * 32; ++pixel) {
    const double* const colour = picture.data() + 3 * pixel;
    blue = std::max(blue, colour[2]);
    darkest = std::min(darkest, colour[0] + colour[1]);
  }
  CHECK(blue == 0);
  CHECK(darkest >= 1 - 1e-12);  // nor does anything shine through
}

TEST_CASE("pictures of 1 x 1, 1 x 4096, 4096 x 1 and of no whole number of tiles are shaded and transposed",
          "[raster][hard_case]") {
  const Mesh mesh = test::random_triangles(60, 7, 1.5);
  for (const auto& [height, width] :
       std::vector<std::array<std::size_t, 2>>{{1, 1}, {1, 4096}, {4096, 1}, {33, 65}, {31, 127}}) {
    const auto view =
        raster::texture_operator<double>({mesh, every_face(mesh), atlas}, Camera{}, height, width, warm, 4);
    const auto texels = random_array<double>({view.texel_count, 3}, 8);
    const auto picture = raster::render(view, texels);
    const auto once =
        raster::render_textured({mesh, every_face(mesh), atlas}, Camera{}, height, width, warm, texels, 4);
    CHECK(largest_difference(picture, once.colour) <= 1e-12);
    const auto weights = random_array<double>({height, width, 3}, 9);
    auto gradient = tapestry::zeros<double, 2>({view.texel_count, 3});
    raster::render_adjoint(view, weights, gradient);
    double forward = 0, backward = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) forward += weights.data()[i] * picture.data()[i];
    for (std::size_t i = 0; i < gradient.size(); ++i) backward += gradient.data()[i] * texels.data()[i];
    CHECK(forward > 0);
    CHECK(std::abs(forward - backward) <= 1e-12 * forward);
    CHECK(is_finite(vertex_gradient(mesh, height, width)));
  }
}
