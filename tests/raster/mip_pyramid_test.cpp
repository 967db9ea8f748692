#include <Eigen/Dense>
#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3, raster::TextureFilter, raster::TextureKind;

namespace {
raster::TextureLayout layout_of(std::size_t height, std::size_t width,
                                TextureFilter filter = TextureFilter::trilinear) {
  return {TextureKind::atlas, height, width, 1, 0, filter};
}

/// A floor that runs from under the camera to far ahead, with the atlas repeated every two units.
Mesh floor_to_the_horizon() {
  Mesh mesh = test::triangle_soup({{Vector3{-60, 1, 0.5}, Vector3{60, 1, 0.5}, Vector3{0, 1, 120}}});
  for (std::size_t k = 0; k < 3; ++k) mesh.uvs[k] = {mesh.positions[k][0] / 2, mesh.positions[k][2] / 2};
  return mesh;
}
}  // namespace

TEST_CASE("a pyramid's texels are means of the areas that they cover", "[raster][mip_pyramid]") {
  const auto layout = layout_of(2, 5);
  const auto levels = raster::mip_levels(layout);
  REQUIRE(levels.size() == 3);
  CHECK(levels[1].height == 1);
  CHECK(levels[1].width == 2);
  CHECK(levels[2].first_texel == 12);
  auto texels = tapestry::zeros<double, 2>({10, 3});
  for (std::size_t i = 0; i < 10; ++i) texels(i, 1) = static_cast<double>(i);
  const auto pyramid = raster::MipPyramid(layout)(texels);
  // Columns 0, 1 and half of 2, of both rows: (0 + 1 + 2/2 + 5 + 6 + 7/2) / 5.
  CHECK(pyramid(10, 1) == Approx(16.5 / 5));
  CHECK(pyramid(11, 1) == Approx(28.5 / 5));
  CHECK(pyramid(12, 1) == Approx(4.5));
  CHECK(pyramid(12, 0) == 0);
}

TEST_CASE("the top of a pyramid is the mean, for any size", "[raster][mip_pyramid]") {
  for (const auto& [height, width] : {std::pair<std::size_t, std::size_t>{1, 1}, {7, 13}, {64, 3}, {1, 31}}) {
    const auto layout = layout_of(height, width);
    const auto texels = random_array<double>({height * width, 3}, 1);
    const auto pyramid = raster::MipPyramid(layout)(texels);
    double mean = 0;
    for (std::size_t i = 0; i < height * width; ++i) mean += texels(i, 2);
    mean /= static_cast<double>(height * width);
    CHECK(std::abs(pyramid(pyramid.shape(0) - 1, 2) - mean) <= 1e-12);
  }
}

namespace {
/// About half of the texels, in patches, and none of the last three rows.
Array<double, 2> patches(std::size_t height, std::size_t width) {
  auto used = tapestry::zeros<double, 2>({height, width});
  const auto chance = random_array<double>({height / 2 + 1, width / 2 + 1}, 9);
  for (std::size_t i = 0; i + 3 < height; ++i)
    for (std::size_t j = 0; j < width; ++j) used(i, j) = chance(i / 2, j / 2) < 0.5 ? 1 : 0;
  return used;
}

struct Size {
  std::size_t height, width;
};
const std::vector<Size> sizes{{1, 1}, {1, 9}, {9, 14}, {8, 16}, {7, 13}, {64, 3}, {33, 31}};
}  // namespace

TEST_CASE("the adjoint of a pyramid is its transpose, whatever is used", "[raster][mip_pyramid][gradient]") {
  for (const auto& [height, width] : sizes) {
    const auto layout = layout_of(height, width);
    const std::size_t texels = height * width;
    for (const auto& pyramid :
         {raster::MipPyramid(layout), raster::MipPyramid(layout, patches(height, width)),
          raster::MipPyramid(layout, tapestry::zeros<double, 2>({height, width}))}) {
      const auto x = random_array<double>({texels, 3}, 2, -1);
      const auto forward = pyramid(x);
      const auto y = random_array<double>({forward.shape(0), 3}, 3, -1);
      auto gradient = tapestry::zeros<double, 2>({texels, 3});
      pyramid.adjoint(y, gradient);
      pyramid.adjoint(y, gradient);  // adds
      CHECK(std::abs(test::dot(y, forward) - test::dot(gradient, x) / 2) <=
            1e-12 * static_cast<double>(y.size()));
    }
  }
}

TEST_CASE("a pyramid has the same bits for any number of threads", "[raster][mip_pyramid][threads]") {
  const raster::MipPyramid pyramid(layout_of(257, 300), patches(257, 300));
  const auto texels = random_array<float>({257 * 300, 3}, 4);
  same_by_threads({1, 2, 5}, [&] {
    auto gradient = tapestry::zeros<float, 2>(texels.shape());
    const auto levels = pyramid(texels);
    pyramid.adjoint(levels, gradient);
    return std::pair{levels, gradient};
  });
}

TEST_CASE("what no face refers to shows in no level", "[raster][mip_pyramid]") {
  for (const auto& [height, width] : sizes) {
    const auto layout = layout_of(height, width);
    const auto used = patches(height, width);
    auto white = tapestry::zeros<float, 2>({height * width, 3});
    for (std::size_t i = 0; i < used.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        white(i, c) = used.data()[i] != 0 ? 1.0F : std::numeric_limits<float>::infinity();
    const bool is_any = std::any_of(used.data(), used.data() + used.size(), [](double u) { return u != 0; });
    const auto pyramid = raster::MipPyramid(layout, used)(white);
    for (std::size_t i = 0; is_any && i < pyramid.size(); ++i)
      REQUIRE(pyramid.data()[i] == Approx(1).margin(1e-6));
  }
}

TEST_CASE("unused texels take the colours around them, used ones keep theirs", "[raster][mip_pyramid]") {
  const auto layout = layout_of(8, 8);
  auto used = tapestry::zeros<double, 2>({8, 8});
  auto texels = random_array<double>({64, 3}, 5);
  used(1, 1) = used(6, 6) = 1;
  const auto filled = raster::with_unused_filled(layout, used, texels);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(filled(0, c) == texels(9, c));  // in one block of 2 × 2 with the first
    CHECK(filled(9, c) == texels(9, c));
    CHECK(filled(3 * 8 + 2, c) == texels(9, c));  // in one block of 4 × 4
    CHECK(filled(54, c) == texels(54, c));
    CHECK(filled(7 * 8, c) == Approx((texels(9, c) + texels(54, c)) / 2));  // of none but the whole
  }
  CHECK((raster::with_unused_filled(layout, tapestry::zeros<double, 2>({8, 8}), texels) == texels));
}

TEST_CASE("a pyramid refuses what does not fit", "[raster][mip_pyramid][bad_input]") {
  const auto layout = layout_of(9, 14);
  const raster::MipPyramid pyramid(layout);
  auto texels = tapestry::zeros<double, 2>({126, 3});
  const auto levels = pyramid(texels);
  CHECK(levels.shape(0) == pyramid.texel_count());
  CHECK_THROWS_AS(pyramid(levels), ShapeError);
  CHECK_THROWS_AS(pyramid.adjoint(texels, texels), ShapeError);
  CHECK_THROWS_AS(raster::MipPyramid(layout, tapestry::zeros<double, 2>({14, 9})), ShapeError);
}

TEST_CASE("the steps of a pixel in an atlas agree with central differences", "[raster][footprint]") {
  const Mesh mesh = test::random_triangles(20, 4);
  const auto uvs = random_array<double>({60, 2}, 9);
  Camera camera;
  camera.tan_half_fov_x = 1.25;
  auto layout = layout_of(30, 70);
  layout.u_extent = 2;
  double error = 0;
  for (std::size_t face = 0; face < 20; ++face) {
    std::array<Vector3, 3> corners;
    std::array<std::array<double, 2>, 3> corner_uvs;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = mesh.positions[3 * face + k];
      corner_uvs[k] = {uvs(3 * face + k, 0), uvs(3 * face + k, 1)};
    }
    const raster::FaceInAtlas map(corners, corner_uvs, layout, camera, 40, 60);
    const std::array<double, 3> b{0.5, 0.2, 0.3};
    Vector3 point{};
    for (std::size_t k = 0; k < 3; ++k) point = geometry::add(point, geometry::scale(corners[k], b[k]));
    const auto place_at = [&](double column, double row) {  // in texels, rows downwards
      const Vector3 ray{point[0] / point[2] + column * 2 * camera.tan_half_fov_x / 60,
                        point[1] / point[2] + row * 2 * camera.tan_half_fov_y / 40, 1};
      std::array<double, 2> texels{0, 0};
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double weight = geometry::dot(ray, geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]));
        sum += weight;
        texels[0] += weight * corner_uvs[k][0] / 2 * 70;
        texels[1] += weight * (1 - corner_uvs[k][1]) * 30;
      }
      return std::array<double, 2>{texels[0] / sum, texels[1] / sum};
    };
    const auto steps = map.steps(b, 0.5);
    const auto place = map.place(b);
    const double h = 1e-6;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      error = std::max(error, std::abs(place[axis] * (axis == 0 ? 70 : 30) - place_at(0, 0)[axis]));
      for (std::size_t way = 0; way < 2; ++way) {
        const double there = way == 0 ? h : 0, down = way == 0 ? 0 : h;
        const double slope = (place_at(there, down)[axis] - place_at(-there, -down)[axis]) / (2 * h);
        error = std::max(error, std::abs(2 * steps[2 * way + axis] - slope) / (1 + std::abs(slope)));
      }
    }
  }
  CHECK(error <= 1e-6);
  const raster::FaceInAtlas edge_on({Vector3{0, 0, 1}, Vector3{0, 0, 2}, Vector3{0, 1, 3}},
                                    {{{0, 0}, {1, 0}, {0, 1}}}, layout, camera, 40, 60);
  CHECK(edge_on.steps({0.25, 0.25, 0.5}) == raster::AtlasSteps{0, 0, 0, 0});
}

TEST_CASE("level and lookups follow the singular values of the map into the atlas",
          "[raster][atlas_filter]") {
  const Mesh mesh = test::triangle_soup({{Vector3{0, 0, 2}, Vector3{1, 0, 2}, Vector3{0, 1, 2}}});
  const auto random = random_array<double>({400, 5}, 7, -1, 1);
  for (const auto filter : {TextureFilter::trilinear, TextureFilter::anisotropic}) {
    const double most = filter == TextureFilter::trilinear ? 1 : 8;
    const raster::AtlasFilter lookup(raster::PaintedMesh{mesh, {1}, layout_of(512, 1024, filter)});
    raster::LookupBatch batch;
    double error = 0;
    for (std::size_t i = 0; i < 400; ++i) {
      Eigen::Matrix2d map;  // from steps in the picture to columns and rows of the atlas
      for (int way = 0; way < 2; ++way)
        for (int axis = 0; axis < 2; ++axis)
          map(axis, way) = std::exp2(5 * random(i, 4)) * random(i, static_cast<std::size_t>(2 * way + axis));
      if (i % 50 < 2) map.col(static_cast<int>(i % 50)).setZero();
      if (i % 50 == 2) map.row(1) = 2 * map.row(0);  // no area
      if (i % 50 == 3) map.setZero();
      if (i % 50 == 4) map << 0, -4, 4, 0;  // a circle
      for (int k = 0; k < 4; ++k) batch.steps[static_cast<std::size_t>(k)][i % 20] = map(k % 2, k / 2);
      lookup.choose(batch, i % 20 + 1);
      const Eigen::JacobiSVD<Eigen::Matrix2d> svd(map, Eigen::ComputeFullU);
      const double length = svd.singularValues()[0], width = std::max(svd.singularValues()[1], 1.0);
      const double lookups = std::clamp(std::ceil(length / width - 1e-9), 1.0, most);
      REQUIRE(batch.lookups[i % 20] == lookups);
      const double size = std::max({width, length / lookups, 1.0});
      error = std::max(error, std::abs(batch.level[i % 20] - std::min(std::log2(size), 10.0)));
      const Eigen::Vector2d between(batch.between[0][i % 20] * 1024, batch.between[1][i % 20] * 512);
      if (lookups > 1) {
        error = std::max(error, std::abs(between.norm() * lookups / length - 1));
        error = std::max(error, std::abs(between.dot(svd.matrixU().col(1))) / between.norm());
      } else {
        CHECK(between.norm() == 0);
      }
    }
    CHECK(error <= 1e-7);  // rounding of a sum of squares turns nearly round footprints
  }
}

TEST_CASE("a level between two powers of 2 is exact at both", "[raster][atlas_filter]") {
  const Mesh mesh = test::triangle_soup({{Vector3{0, 0, 2}, Vector3{1, 0, 2}, Vector3{0, 1, 2}}});
  const raster::AtlasFilter lookup(raster::PaintedMesh{mesh, {1}, layout_of(64, 64)});
  for (const double size : {0.0, 0.25, 1.0, 2.0, 8.0, 64.0, 1e9, std::numeric_limits<double>::infinity()}) {
    raster::LookupBatch batch;
    batch.steps[0][0] = batch.steps[3][0] = size;
    batch.steps[1][0] = batch.steps[2][0] = 0;
    lookup.choose(batch, 1);
    CHECK(batch.level[0] == std::min(std::max(std::log2(std::max(size, 1.0)), 0.0), 6.0));
    CHECK(batch.lookups[0] == 1);
  }
}

TEST_CASE("lookups of a filter weigh 1, and meet the opposite border only where faces repeat",
          "[raster][atlas_filter]") {
  for (const double reach : {1.0, 2.5}) {
    for (const auto filter : {TextureFilter::trilinear, TextureFilter::anisotropic}) {
      raster::PaintedMesh body{test::triangle_soup({{Vector3{0, 0, 2}, Vector3{1, 0, 2}, Vector3{0, 1, 2}}}),
                               {1},
                               layout_of(16, 32, filter)};
      body.mesh.uvs = {{0, 0}, {reach, 0}, {0, reach}};
      const raster::AtlasFilter lookup(body);
      for (const double u : {0.0, 1e-12, 0.25, 0.99, 1.0})
        for (const double length : {0.0, 0.5, 1.0, 3.0, 1e9, std::numeric_limits<double>::infinity()}) {
          double weight = 0;
          std::size_t taps = 0, left = 0;
          lookup.visit_taps({u, 0.5}, {length, 0, 0, std::min(length, 1.0)}, [&](const raster::Tap& tap) {
            weight += tap.weight;
            ++taps;
            if (tap.texel < 16 * 32 && tap.texel % 32 < 8) ++left;
          });
          CHECK(weight == Approx(1));
          CHECK(taps <= 8 * 8);
          if (u == 1.0 && length == 3.0)
            CHECK((left > 0) == (reach > 1 && filter == TextureFilter::anisotropic));
        }
    }
  }
}

namespace {
/// Texel [0, size − 1] and share of the next along an axis of a repeated atlas, the coordinate moved by steps
/// of 1. Lookups do not reach over the border.
std::array<double, 2> texel_and_share(double coordinate, double size) {
  while (coordinate < 0) coordinate += 1;
  while (coordinate > 1) coordinate -= 1;
  double texel = 0;
  const double at = coordinate * size - 0.5;
  while (texel + 1 <= std::min(at, size - 1)) texel += 1;
  return {texel, texel + 1 < size ? std::max(at - texel, 0.0) : 0};
}

/// Colour of a repeated atlas at {u, v} by its nearest four texels.
double repeated(const Array<float, 2>& texels, double height, double width, double u, double v,
                std::size_t channel) {
  const auto [column, right] = texel_and_share(u, width);
  const auto [row, down] = texel_and_share(1 - v, height);
  const auto at = [&](double i, double j) {
    return static_cast<double>(
        texels(static_cast<std::size_t>(std::min(i, height - 1) * width + std::min(j, width - 1)), channel));
  };
  return (1 - down) * ((1 - right) * at(row, column) + right * at(row, column + 1)) +
         down * ((1 - right) * at(row + 1, column) + right * at(row + 1, column + 1));
}

/// A square that fills a picture of Camera{}, whose uv grow from {u, v} by `span`.
Mesh filled_frame(double u, double v, double span) {
  Mesh mesh = test::triangle_soup({{Vector3{-2, -2, 2}, Vector3{2, -2, 2}, Vector3{2, 2, 2}},
                                   {Vector3{-2, -2, 2}, Vector3{2, 2, 2}, Vector3{-2, 2, 2}}});
  for (std::size_t i = 0; i < 6; ++i)
    mesh.uvs[i] = {u + (mesh.positions[i][0] > 0 ? span : 0), v + (mesh.positions[i][1] < 0 ? span : 0)};
  return mesh;
}
}  // namespace

TEST_CASE("an atlas repeats between any two integers of uv, by any filter", "[raster][atlas_filter]") {
  const auto filter = GENERATE(TextureFilter::bilinear, TextureFilter::trilinear, TextureFilter::anisotropic);
  const double span = GENERATE(1.0, 2.0);
  const auto layout = layout_of(5, 7, filter);
  const Camera camera;
  const std::size_t size = 38;  // no pixel's centre lies on an integer of uv
  double error = 0;
  for (double u = -3; u <= 2; ++u)
    for (double v = -3; v <= 2; ++v) {
      const raster::PaintedMesh body{filled_frame(u, v, span), {1, 1}, layout};
      const auto texels = random_array<float>({raster::stored_texel_count(layout, body.mesh), 3}, 5);
      const auto view = raster::texture_operator<float>(body, camera, size, size, raster::Unlit{}, 1);
      const auto by_operator = raster::render(view, texels);
      const auto drawn =
          raster::render_textured<float>(body, camera, size, size, raster::Unlit{}, texels, 1).colour;
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const double along = (static_cast<double>(i / 3 % size) + 0.5) / static_cast<double>(size);
        const double down = (static_cast<double>(i / 3 / size) + 0.5) / static_cast<double>(size);
        const double expected = repeated(texels, 5, 7, u + span * along, v + span * (1 - down), i % 3);
        for (const float found : {by_operator.data()[i], drawn.data()[i]})
          error = std::max(error, std::abs(static_cast<double>(found) - expected));
      }
    }
  CHECK(error <= 1e-5);
}

TEST_CASE("pictures by kernels are those of the operator in double, at borders and highest levels, too",
          "[raster][atlas_filter]") {
  const auto size = GENERATE(std::array<std::size_t, 2>{1, 1}, std::array<std::size_t, 2>{3, 2},
                             std::array<std::size_t, 2>{8, 16}, std::array<std::size_t, 2>{53, 31},
                             std::array<std::size_t, 2>{256, 128}, std::array<std::size_t, 2>{1, 512});
  const auto filter = GENERATE(TextureFilter::trilinear, TextureFilter::anisotropic);
  const double reach = GENERATE(1.0, 40.0);  // times that uv repeats
  auto layout = layout_of(size[0], size[1], filter);
  layout.most_lookups = 19;  // more than the kernel's groups
  raster::PaintedMesh body{test::random_triangles(40, 4), std::vector<std::uint8_t>(40, 1), layout};
  const auto uvs = random_array<double>({body.mesh.uvs.size(), 2}, 3, reach > 1 ? -reach : 0, reach);
  for (std::size_t i = 0; i < uvs.shape(0); ++i) body.mesh.uvs[i] = {uvs(i, 0), uvs(i, 1)};
  body.mesh.uvs.front() = {0, 1};  // on the border
  body.painted[7] = 0;
  const auto texels = random_array<float>({raster::stored_texel_count(layout, body.mesh), 3}, 5);
  const auto drawn = raster::render_textured<float>(body, Camera{}, 48, 64, raster::Unlit{}, texels, 4);
  const auto in_double = raster::texture_operator<double>(body, Camera{}, 48, 64, raster::Unlit{}, 4);
  const auto expected = raster::render(in_double, tapestry::cast<double>(texels));
  CHECK(test::largest_difference(drawn.colour, expected) <=
        2e-5);  // places of 19 lookups reach 2 · 19 texels: 38 · 2⁻²⁴ of a texel each, and sums
}

TEST_CASE("lookups have the same bits with any instruction set", "[raster][atlas_filter]") {
  const auto levels = raster::mip_levels(layout_of(200, 300, TextureFilter::anisotropic));
  const auto texels = random_array<float>({levels.back().first_texel + 1, 3}, 8);
  const auto random = random_array<double>({raster::LookupBatch::size, 7}, 9);
  std::vector<std::vector<double>> found;
  for (const auto set : tapestry::instruction_sets()) {
    const auto kernels = raster::raster_kernels_of(set);
    raster::LookupBatch batch;
    const std::size_t count = raster::LookupBatch::size;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < 4; ++k)
        batch.steps[k][i] = (random(i, k) - 0.5) * std::exp2(6 * random(i, 6) - 2);
      batch.place[0][i] = random(i, 4);
      batch.place[1][i] = random(i, 5);
    }
    kernels.choose_lookups({{300, 200}, 11, 8}, batch, count);
    std::vector<float> sums(8 * count);
    kernels.look_up({levels.data(), texels.data()}, batch, count, sums.data());
    auto& all = found.emplace_back();
    for (std::size_t i = 0; i < count; ++i) {
      all.insert(all.end(), {batch.level[i], batch.lookups[i], batch.between[0][i], batch.between[1][i]});
      for (std::size_t k = 0; k < 6; ++k) all.push_back(static_cast<double>(sums[8 * i + k]));
    }
    CHECK(all == found.front());
  }
}

TEST_CASE("a texel that is no number shows only where it counts", "[raster][atlas_filter]") {
  const Mesh mesh = test::triangle_soup({{Vector3{0, 0, 2}, Vector3{1, 0, 2}, Vector3{0, 1, 2}}});
  const raster::AtlasFilter lookup(raster::PaintedMesh{mesh, {1}, layout_of(16, 16)});
  auto texels = tapestry::zeros<float, 2>({16 * 16 + 8 * 8 + 4 * 4 + 2 * 2 + 1, 3});
  for (float& value : texels.storage()) value = std::numeric_limits<float>::quiet_NaN();
  texels(16 * 5 + 3, 0) = 0.25F, texels(16 * 5 + 3, 1) = 0.5F, texels(16 * 5 + 3, 2) = 0.75F;
  raster::LookupBatch batch;
  for (auto& steps : batch.steps) steps[0] = steps[1] = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    batch.place[0][i] = (3.5 + static_cast<double>(i) / 4) / 16;
    batch.place[1][i] = 5.5 / 16;
  }
  raster::AtlasFilter::Colours colours;
  lookup.look_up(batch, 2, texels.data(), colours);
  CHECK(colours[0] == std::array<float, 3>{0.25F, 0.5F, 0.75F});
  CHECK(std::isnan(colours[1][0]));
}

TEST_CASE("trilinear comes nearer to the area average than bilinear", "[raster][mip_pyramid]") {
  const Mesh mesh = floor_to_the_horizon();
  const auto texels = random_array<double>({64 * 64, 3}, 5);
  const auto fine = layout_of(64, 64, TextureFilter::bilinear);
  const auto reference = raster::render(
      raster::texture_operator<double>({mesh, {1}, fine}, Camera{}, 480, 640, raster::Unlit{}, 8), texels);
  Array<double, 3> mean = tapestry::zeros<double, 3>({60, 80, 3});  // of 64 × 64 samples a pixel
  for (std::size_t i = 0; i < 480; ++i)
    for (std::size_t j = 0; j < 640; ++j)
      for (std::size_t c = 0; c < 3; ++c) mean(i / 8, j / 8, c) += reference(i, j, c) / 64;
  const auto error_of = [&](TextureFilter filter, std::size_t samples) {
    const raster::PaintedMesh body{mesh, {1}, layout_of(64, 64, filter)};
    const auto picture = raster::texture_operator<double>(body, Camera{}, 60, 80, raster::Unlit{}, samples);
    return test::relative_distance(
        raster::render(picture, raster::stored_texels(raster::pyramid_of(body), texels)), mean);
  };
  // Random texels, far smaller than pixels: one of them is off by their spread, 0.29 of 0.5.
  const double bilinear = error_of(TextureFilter::bilinear, 4),
               trilinear = error_of(TextureFilter::trilinear, 4);
  CHECK(bilinear >= 0.2);
  CHECK(trilinear <= 0.5 * bilinear);
  CHECK(error_of(TextureFilter::anisotropic, 4) <= 0.5 * trilinear);
}

TEST_CASE("an anisotropic lookup keeps a grazing checker where trilinear blurs it",
          "[raster][atlas_filter]") {
  // A sheet of 8 by 8 that is seen at 7 degrees, with a checker of 16 x 16 fields.
  const double c = std::cos(0.122), s = std::sin(0.122);
  const auto at = [&](double across, double along) { return Vector3{across, -along * s, 5 + along * c}; };
  Mesh plane = test::triangle_soup({{at(-4, -4), at(4, -4), at(4, 4)}, {at(-4, -4), at(4, 4), at(-4, 4)}});
  plane.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  auto texels = tapestry::zeros<double, 2>({512 * 512, 3});
  for (std::size_t i = 0; i < 512 * 512; ++i)
    for (std::size_t k = 0; k < 3; ++k) texels(i, k) = static_cast<double>((i / 512 / 32 + i % 512 / 32) % 2);
  Camera camera;
  camera.tan_half_fov_x = camera.tan_half_fov_y = 0.5;
  const auto picture_of = [&](TextureFilter filter, std::size_t side, std::size_t samples) {
    const raster::PaintedMesh body{plane, {1, 1}, layout_of(512, 512, filter)};
    return raster::render_textured<double>(body, camera, side, side, raster::Unlit{},
                                           raster::stored_texels(raster::pyramid_of(body), texels), samples);
  };
  const std::size_t side = 64, of_pixel = 32;
  const auto fine = picture_of(TextureFilter::bilinear, side * of_pixel, 1);
  auto mean = tapestry::zeros<double, 2>({side, side}), covered = mean;
  for (std::size_t i = 0; i < side * of_pixel; ++i)
    for (std::size_t j = 0; j < side * of_pixel; ++j) {
      mean(i / of_pixel, j / of_pixel) += fine.colour(i, j, 0) / (of_pixel * of_pixel);
      covered(i / of_pixel, j / of_pixel) += fine.coverage(i, j) / (of_pixel * of_pixel);
    }
  const auto rms = [&](TextureFilter filter) {
    const auto picture = picture_of(filter, side, 4);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < side * side; ++i) {
      if (covered.data()[i] < 1) continue;
      sum += std::pow(picture.colour.data()[3 * i] - mean.data()[i], 2);
      ++count;
    }
    REQUIRE(count >= 1000);
    return std::sqrt(sum / count);
  };
  CHECK(rms(TextureFilter::bilinear) >= 0.1);
  CHECK(rms(TextureFilter::trilinear) >= 0.04);
  CHECK(rms(TextureFilter::anisotropic) <= 0.03);
}

TEST_CASE("a pattern finer than pixels is a camera's grey in light and too dark by numbers",
          "[raster][image]") {
  // A wall of 512 x 512 black and white texels, 16 of them across a pixel.
  Mesh wall = test::triangle_soup({{Vector3{-4, -4, 2}, Vector3{12, -4, 2}, Vector3{-4, 12, 2}}});
  for (std::size_t k = 0; k < 3; ++k)
    wall.uvs[k] = {(wall.positions[k][0] + 4) / 8, (wall.positions[k][1] + 4) / 8};
  auto texels = tapestry::zeros<double, 2>({512 * 512, 3});
  for (std::size_t i = 0; i < 512 * 512; ++i)
    for (std::size_t c = 0; c < 3; ++c) texels(i, c) = static_cast<double>((i / 512 + i % 512) % 2);
  const auto picture_of = [&](const raster::TextureLayout& layout, std::size_t side, std::size_t samples,
                              const Array<double, 2>& of) {
    return raster::render(
        raster::texture_operator<double>({wall, {1}, layout}, Camera{}, side, side, raster::Unlit{}, samples),
        of);
  };
  const auto seen =
      picture_of(layout_of(512, 512, TextureFilter::bilinear), 16 * 64, 1, image::linearised(texels));
  auto light = tapestry::zeros<double, 3>({16, 16, 3});  // of 64 × 64 samples a pixel
  for (std::size_t i = 0; i < seen.shape(0); ++i)
    for (std::size_t j = 0; j < seen.shape(1); ++j)
      for (std::size_t c = 0; c < 3; ++c) light(i / 64, j / 64, c) += seen(i, j, c) / (64 * 64);
  const auto camera = image::encoded(light);
  const auto layout = layout_of(512, 512);
  const auto pyramid_of = [&](const Array<double, 2>& of) { return raster::MipPyramid(layout)(of); };
  const auto linear = image::encoded(picture_of(layout, 16, 4, pyramid_of(image::linearised(texels))));
  const auto encoded = picture_of(layout, 16, 4, pyramid_of(texels));
  for (std::size_t i = 0; i < camera.size(); ++i) {
    REQUIRE(camera.data()[i] == Approx(0.735).margin(0.01));
    REQUIRE(std::abs(linear.data()[i] - camera.data()[i]) <= 0.01);
    REQUIRE(std::abs(encoded.data()[i] - camera.data()[i]) >= 0.2);
  }
}

TEST_CASE("an atlas that is not minified is the same with all filters", "[raster][mip_pyramid]") {
  Mesh mesh = test::triangle_soup({{Vector3{-2, -2, 2}, Vector3{6, -2, 2}, Vector3{-2, 6, 2}}});
  for (auto& uv : mesh.uvs) uv = {uv[0] / 4, uv[1] / 4};
  const auto texels = random_array<double>({16 * 16, 3}, 6);
  const auto at = [&](TextureFilter filter) {
    const auto layout = layout_of(16, 16, filter);
    const auto picture =
        raster::texture_operator<double>({mesh, {1}, layout}, Camera{}, 50, 50, raster::Unlit{}, 1);
    return raster::render(picture, raster::is_filtered(layout) ? raster::MipPyramid(layout)(texels) : texels);
  };
  // Places of up to 16 texels are rounded a few times on another way.
  const double tolerance = 16 * 8 * std::numeric_limits<double>::epsilon();
  for (const auto filter : {TextureFilter::trilinear, TextureFilter::anisotropic})
    CHECK(test::relative_distance(at(filter), at(TextureFilter::bilinear)) <= tolerance);
}

TEST_CASE("a filter takes 1 to 64 lookups", "[raster][atlas_filter][bad_input]") {
  const Mesh mesh = floor_to_the_horizon();
  for (const std::size_t lookups : {0U, 1U, 64U, 65U}) {
    auto layout = layout_of(4, 4, TextureFilter::anisotropic);
    layout.most_lookups = lookups;
    const auto draw = [&] {
      return raster::texture_operator<double>({mesh, {1}, layout}, Camera{}, 8, 8, raster::Unlit{});
    };
    if (lookups == 1 || lookups == 64)
      CHECK_NOTHROW(draw());
    else
      CHECK_THROWS_AS(draw(), DomainError);
  }
}
