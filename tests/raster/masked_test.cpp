#include <tapestry/raster/cropped.hpp>

#include "../support/catch.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
raster::TextureOperator<double> some_view() {
  const auto mesh = test::random_triangles(20, 3, 1.2);
  auto painted = test::every_face(mesh);
  for (std::size_t face = 0; face < painted.size(); face += 3) painted[face] = 0;
  return raster::texture_operator<double>({mesh, painted, test::atlas}, {}, 9, 12, test::warm);
}
}  // namespace

TEST_CASE("a masked view's picture and coverage are those of the view times the mask", "[raster][masked]") {
  const auto view = some_view();
  auto mask = random_array<double>({9, 12}, 4);
  for (std::size_t i = 0; i < mask.size(); i += 2) mask.data()[i] = i % 4 == 0 ? 0 : 1;
  const auto hidden = raster::masked(view, mask);
  const auto texels = random_array<double>({view.texel_count, 3}, 5);
  const auto whole = raster::render(view, texels), part = raster::render(hidden, texels);
  for (std::size_t i = 0; i < whole.size(); ++i)
    CHECK(part.data()[i] == Approx(mask.data()[i / 3] * whole.data()[i]).epsilon(1e-14));
  for (std::size_t i = 0; i < mask.size(); ++i)
    CHECK(hidden.coverage.data()[i] == mask.data()[i] * view.coverage.data()[i]);
}

TEST_CASE("a mask of ones keeps every bit, and one of zeros leaves no entry", "[raster][masked]") {
  const auto view = some_view();
  REQUIRE(!view.pixels.empty());
  const auto same = raster::masked(view, tapestry::filled<double, 2>({9, 12}, 1));
  CHECK(same.pixels == view.pixels);
  CHECK(same.row_begin == view.row_begin);
  CHECK(same.texels_of == view.texels_of);
  CHECK(same.weights == view.weights);
  CHECK((same.constant == view.constant));
  const auto none = raster::masked(view, tapestry::zeros<double, 2>({9, 12}));
  CHECK(none.weights.empty());
  CHECK(none.row_begin == std::vector<std::uint32_t>{0});
  CHECK((raster::render(none, tapestry::filled<double, 2>({view.texel_count, 3}, 1)) ==
         tapestry::zeros<double, 3>({9, 12, 3})));
}

TEST_CASE("masked refuses a mask of another size", "[raster][masked][bad_input]") {
  CHECK_THROWS_WITH(raster::masked(some_view(), tapestry::zeros<double, 2>({12, 9})),
                    "masked: mask is [12, 9], expected [9, 12]");
}
