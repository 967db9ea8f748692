#include <tapestry/raster/mip_pyramid.hpp>

#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("a filtered atlas on the tape agrees with central differences, in both colour spaces",
          "[raster][variable][gradient]") {
  const auto filter = GENERATE(raster::TextureFilter::trilinear, raster::TextureFilter::anisotropic);
  const auto space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const std::size_t height = GENERATE(std::size_t(1), std::size_t(7), std::size_t(16));
  const auto layout = raster::atlas_layout(height, 2 * height - 1, 1, filter);
  const auto mesh = test::random_triangles(30, 1, 0.9);
  const raster::PaintedMesh body{mesh, test::every_face(mesh), layout};
  const auto view = raster::texture_operator<double>(body, {}, 20, 24, test::warm);
  const auto pyramid = raster::pyramid_of(body);
  const auto loss = [&](const ArrayVariable<double, 2>& texels) {
    const auto picture = raster::render(view, raster::stored_texels(pyramid, texels, space));
    return tapestry::sum(square(picture));
  };
  const auto texels = random_array<double>({layout.height * layout.width, 3}, 2, 0.3, 1);
  CHECK((raster::stored_texels(pyramid, texels, space) ==
         raster::stored_texels(pyramid, image::in_space(space, texels))));
  ActiveTape<double> tape;
  CHECK(!raster::stored_texels(pyramid, ArrayVariable<double, 2>(texels)).is_active());
  const auto input = tape.input(texels);
  tape.reverse(loss(input) + loss(input));
  const auto direction = test::random_direction<double>({layout.height * layout.width, 3}, 3);
  const auto twice = [&](double step) {
    const Array<double, 2> at = texels + step * direction;
    return 2 * loss(ArrayVariable<double, 2>(at)).value();
  };
  CHECK(test::dot(input.adjoint(), direction) ==
        Approx(test::fourth_order_difference(twice, 1e-3)).epsilon(1e-9).margin(1e-10));
}
