#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/catch.hpp"
#include "../support/hessian_product_error.hpp"
#include "../support/paint.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using test::hessian_product_error, test::number, test::random_array;

TEST_CASE("a drawn texture has the Hessian that differences of its gradient give", "[raster][second_order]") {
  const auto space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const bool is_filtered = GENERATE(false, true);
  const auto layout = is_filtered ? raster::atlas_layout(7, 13, 1, raster::TextureFilter::trilinear)
                                  : raster::atlas_layout(7, 13, 1);
  const auto mesh = test::random_triangles(30, 1, 0.9);
  const raster::PaintedMesh body{mesh, test::every_face(mesh), layout};
  const auto view = raster::texture_operator<double>(body, {}, 20, 24, test::warm);
  const auto compact = std::make_shared<const raster::CompactOperator<double>>(raster::compacted(view));
  const auto pyramid = raster::pyramid_of(body);
  const auto texels = random_array<double>({layout.height * layout.width, 3}, 2, 0.1, 1);
  const auto one = [&](const auto& x) {
    return number(x, sum(sin(raster::render(view, raster::stored_texels(pyramid, x, space)))));
  };
  CHECK(hessian_product_error(one, texels) < 1e-7);
  const auto two = [&](const auto& x) {
    const auto pictures =
        raster::render(std::vector{compact, compact}, raster::stored_texels(pyramid, x, space));
    return number(x, sum(exp(pictures[0]) * pictures[1]));
  };
  CHECK(hessian_product_error(two, texels) < 1e-7);
}
