#include <tapestry/autodiff/array_derivatives.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;

TEST_CASE("the compressed Jacobian of a picture by its texels is the operator itself", "[raster][sparsity]") {
  const auto mesh = test::random_triangles(40, 5);
  const std::size_t height = 24, width = 30;
  const auto picture = raster::texture_operator<double>({mesh, test::every_face(mesh), test::cube},
                                                        geometry::Camera{}, height, width, test::warm, 2);
  const auto start = test::random_array<double>({picture.texel_count, 3}, 1);

  // Channel c of pixel p depends on channel c of its texels.
  std::vector<JacobianPattern::Entry> entries;
  for (std::size_t row = 0; row < picture.pixels.size(); ++row)
    for (std::size_t i = picture.row_begin[row]; i < picture.row_begin[row + 1]; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        entries.push_back(
            {picture.pixels[row] * std::size_t(3) + c, picture.texels_of[i] * std::size_t(3) + c});
  const JacobianPlan plan(JacobianPattern(height * width * 3, start.size(), entries));
  REQUIRE(plan.pattern().entry_count() > 500);

  test::ActiveTape<double> tape;
  const auto texels = tape.input(start);
  const auto pullback = [&](const Array<double, 3>& g, Array<double, 2>* texels_adjoint) {
    raster::render_adjoint(picture, g, *texels_adjoint);
  };
  const ArrayVariable<double, 3> render =
      tapestry::record_array(raster::render(picture, start), pullback, texels);
  std::vector<double> values(plan.pattern().entry_count());
  tapestry::compressed_jacobian(tape, render, texels, plan, values);

  std::vector<double> dense(render.size() * start.size());  // by differences: the picture is linear in texels
  Array<double, 2> unit = tapestry::zeros<double, 2>(start.shape());
  const auto dark = raster::render(picture, unit);
  for (std::size_t j = 0; j < start.size(); ++j) {
    unit.data()[j] = 1;
    const auto lit = raster::render(picture, unit);
    unit.data()[j] = 0;
    for (std::size_t i = 0; i < lit.size(); ++i) dense[i * start.size() + j] = lit.data()[i] - dark.data()[i];
  }
  double worst = 0;
  plan.pattern().visit([&](std::size_t row, std::size_t column, std::size_t number) {
    double& entry = dense[row * start.size() + column];
    worst = std::max(worst, std::abs(entry - values[number]));
    entry = 0;
  });
  CHECK(worst <= 1e-14);
  CHECK(std::all_of(dense.begin(), dense.end(), [](double rest) { return rest == 0; }));
  CHECK(plan.row_colouring().colour_count < start.size() / 3);
}
