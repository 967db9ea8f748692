#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
raster::TextureOperator<double> view_of(std::uint64_t seed, std::size_t height, std::size_t width) {
  const auto mesh = test::random_triangles(20, seed, 1.2);
  return raster::texture_operator<double>({mesh, test::every_face(mesh), test::atlas}, {}, height, width,
                                          test::warm);
}

/// An operator of one entry a pixel.
raster::TextureOperator<double> one_entry_a_pixel(std::size_t texel_count,
                                                  std::vector<std::uint32_t> texels) {
  raster::TextureOperator<double> picture;
  picture.height = 1;
  picture.width = texels.size();
  picture.texel_count = texel_count;
  picture.constant = zeros<double, 3>({1, texels.size(), 3});
  picture.coverage = zeros<double, 2>({1, texels.size()});
  picture.row_begin.push_back(0);
  for (std::uint32_t i = 0; i < texels.size(); ++i) {
    picture.pixels.push_back(i);
    picture.row_begin.push_back(i + 1);
    picture.weights.push_back(1);
  }
  picture.texels_of = std::move(texels);
  return picture;
}
}  // namespace

TEST_CASE("a compact operator draws the bits of the whole one, and pulls them back",
          "[raster][compact_operator]") {
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    const auto whole = view_of(seed, 9, 12);
    const auto compact = raster::compacted(whole);
    CHECK(compact.whole_count == whole.texel_count);
    CHECK(compact.texel_count == compact.texels.size());
    CHECK(std::is_sorted(compact.texels.begin(), compact.texels.end(), std::less_equal{}));
    const auto texels = random_array<double>({whole.texel_count, 3}, seed);
    CHECK((raster::render(compact, raster::own_texels(compact, texels)) == raster::render(whole, texels)));

    const auto adjoint = random_array<double>({9, 12, 3}, seed + 1);
    auto by_whole = zeros<double, 2>(texels.shape()), by_own = zeros<double, 2>({compact.texel_count, 3});
    raster::render_adjoint(whole, adjoint, by_whole);
    raster::render_adjoint(compact, adjoint, by_own);
    auto scattered = zeros<double, 2>(texels.shape());
    raster::add_own_texels(compact, by_own, 1.0, scattered);
    CHECK((scattered == by_whole));
    raster::add_own_texels(compact, by_own, -0.5, scattered);
    for (std::size_t i = 0; i < scattered.size(); ++i)
      CHECK(scattered.data()[i] == Approx(-by_whole.data()[i]).epsilon(1e-15));
  }
}

TEST_CASE("compact operators at the ends: the first and last texel, all of them, none",
          "[raster][compact_operator]") {
  for (const std::size_t count : {1U, 63U, 64U, 65U, 200U}) {
    const auto last = static_cast<std::uint32_t>(count - 1);
    const auto ends = raster::compacted(one_entry_a_pixel(count, {last, 0, last}));
    CHECK(ends.texels == (count == 1 ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>{0, last}));
    CHECK(ends.texels_of ==
          (count == 1 ? std::vector<std::uint32_t>{0, 0, 0} : std::vector<std::uint32_t>{1, 0, 1}));
    std::vector<std::uint32_t> every(count);
    for (std::uint32_t i = 0; i < count; ++i) every[i] = i;
    const auto all = raster::compacted(one_entry_a_pixel(count, every));
    CHECK(all.texels == every);
    CHECK(all.texels_of == every);
  }
  const auto none = raster::compacted(one_entry_a_pixel(5, {}));
  CHECK(none.texels.empty());
  CHECK(none.texel_count == 0);
  CHECK(raster::own_texels(none, zeros<double, 2>({5, 3})).shape(0) == 0);
}

TEST_CASE("a texture of another size is refused by a compact operator", "[raster][compact_operator][error]") {
  const auto compact = raster::compacted(one_entry_a_pixel(5, {1, 3}));
  CHECK_THROWS_WITH(raster::own_texels(compact, zeros<double, 2>({2, 3})),
                    "own_texels: texels is [2, 3], expected [5, 3]");
}
