#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/loss/smoothness.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/tiny_scene.hpp"
#include "../support/vertex_gradient_scene.hpp"

// The pipeline as a user composes it: render → over → detector → losses, without camouflage/.

using namespace tapestry;

namespace {
constexpr std::size_t side = 48;
const raster::Light light{0.4, 0.5, {0.3, 0.4, -0.8}, {1, 0.95, 0.9}};

/// A tilted, textured wall that fills the picture: no silhouette, so the pipeline is smooth in everything.
raster::PaintedMesh wall() {
  return {test::triangle_soup({{geometry::Vector3{-9.1, -7.3, 2.13}, geometry::Vector3{14.7, -8.2, 4.19},
                                geometry::Vector3{-6.3, 16.1, 3.07}}},
                              {{{0.1, 0.15}, {0.9, 0.2}, {0.3, 0.95}}}),
          {1},
          test::small_atlas};
}

Variable<double> pipeline(const raster::PaintedMesh& body, const detect::Detector<double>& network,
                          const raster::RenderInputs<double>& inputs) {
  const Array<double, 3> background = test::random_array<double>({side, side, 3}, 5);
  const auto drawn =
      raster::render(body, geometry::Camera{}, side, side, light, inputs, raster::BoundaryIntegral{1});
  const auto picture = image::over<double>(drawn.picture, drawn.coverage, background);
  const auto logits = detect::forward(network, image::batch_of(std::vector{picture}));
  const std::vector<loss::Target> targets{{1, {24, 24, 30, 26}}};
  const auto adversarial = loss::adversarial(network, logits, targets, loss::AdversarialLoss::max_score);
  const auto everywhere =
      std::make_shared<const Array<double, 2>>(tapestry::filled<double, 2>({side, side}, 1));
  return adversarial.total +
         0.01 * loss::smoothness(image::batch_of(std::vector{drawn.picture}), {{everywhere}});
}

/// Compares the derivative along a direction of one input with a central difference of the whole.
template <std::size_t Rank>
void check(const raster::RenderInputs<double>& at,
           ArrayVariable<double, Rank> raster::RenderInputs<double>::*member) {
  const auto body = wall();
  const auto network = test::tiny_detector<double>("mish");  // smooth
  test::ActiveTape<double> tape;
  auto inputs = at;
  inputs.*member = tape.input(at.*member);
  const auto root = pipeline(body, network, inputs);
  tape.reverse(root);
  const Array<double, Rank> analytic = (inputs.*member).adjoint();
  const auto value = [&](const Array<double, Rank>& moved) {
    auto other = at;
    other.*member = moved;
    return pipeline(body, network, other).value();
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    auto direction = analytic;
    Random random(seed);
    for (double& entry : direction.storage()) entry = random.uniform(-1, 1) / 3;
    const double expected = test::central_difference(value, (at.*member).value(), direction);
    const double found = test::dot(analytic, direction);
    INFO("found " << found << ", expected " << expected);
    REQUIRE(std::abs(expected) > 1e-5);
    CHECK(std::abs(found - expected) <= 1e-6 * std::abs(expected));
  }
}
}  // namespace

TEST_CASE("the composed pipeline agrees with central differences by texture, positions, pose and light",
          "[camouflage][gradient]") {
  const auto body = wall();
  Array<double, 2> positions(Extents<2>{3, 3});
  for (std::size_t i = 0; i < 9; ++i) positions.data()[i] = body.mesh.positions[i / 3][i % 3];
  const raster::RenderInputs<double> at{
      test::random_array<double>({body.layout.texel_count(body.mesh), 3}, 1), positions,
      Array<double, 1>{0.02, -0.01, 0.03, 0.05, -0.04, -0.06}, raster::light_parameters<double>(light)};
  SECTION("texture") { check(at, &raster::RenderInputs<double>::texels); }
  SECTION("positions") { check(at, &raster::RenderInputs<double>::positions); }
  SECTION("pose") { check(at, &raster::RenderInputs<double>::pose); }
  SECTION("light") { check(at, &raster::RenderInputs<double>::light); }
}
