#include <tapestry/raster/render_variable.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/threads.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Vector3, raster::RenderInputs;

namespace {
Array<double, 2> array_of(const std::vector<Vector3>& vectors) {
  Array<double, 2> array(Extents<2>{vectors.size(), 3});
  for (std::size_t i = 0; i < array.size(); ++i) array.data()[i] = vectors[i / 3][i % 3];
  return array;
}

/// One face beyond the borders of the picture, tilted and textured: a wall that the camera stands before.
raster::PaintedMesh wall() {
  geometry::Mesh mesh =
      test::triangle_soup({{Vector3{-9.1, -7.3, 2.13}, Vector3{14.7, -8.2, 4.19}, Vector3{-6.3, 16.1, 3.07}}},
                          {{{0.1, 0.15}, {0.9, 0.2}, {0.3, 0.95}}});
  mesh.normals = {{0, 0.6, -0.8}, {0.6, 0, -0.8}, {-0.6, 0, -0.8}};
  mesh.face_normals = {{0, 1, 2}};
  return {mesh, {1}, test::small_atlas};
}

/// Values of all inputs.
struct Values {
  Array<double, 2> texels, positions;
  Array<double, 1> pose, light = raster::light_parameters<double>(warm);

  explicit Values(const raster::PaintedMesh& body)
      : texels(test::random_array<double>({body.layout.texel_count(body.mesh), 3}, 1)),
        positions(geometry::position_array<double>(body.mesh)),
        pose({0.02, -0.01, 0.03, 0.05, -0.04, -0.06}) {}
  [[nodiscard]] RenderInputs<double> passive() const { return {texels, positions, pose, light}; }
  [[nodiscard]] RenderInputs<double> active(Tape<double>& tape) const {
    return {tape.input(texels), tape.input(positions), tape.input(pose), tape.input(light)};
  }
};

Variable<double> weighted(const ArrayVariable<double, 3>& picture) {
  return tapestry::sum(picture * ArrayVariable<double, 3>(smooth_weights()));
}

/// All derivatives of ⟨weights, picture⟩ beside central differences, each input along random directions.
template <class Model>
void check_wall(const Model& light, const raster::TextureLayout& layout) {
  auto body = wall();
  body.layout = layout;
  const Values values(body);
  const raster::BoundaryIntegral once{1};
  REQUIRE((raster::render(body, Camera{}, side, side, light, values.passive(), once).coverage.value() ==
           tapestry::filled<double, 2>({side, side}, 1)));
  const auto loss = [&](const Values& at) {
    return weighted(raster::render(body, Camera{}, side, side, light, at.passive(), once).picture).value();
  };
  ActiveTape<double> tape;
  const auto inputs = values.active(tape);
  tape.reverse(weighted(raster::render(body, Camera{}, side, side, light, inputs, once).picture));
  const auto check = [&](const char* name, const auto& input, auto Values::*member) {
    INFO(name);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      auto direction = input.value();
      Random random(seed);
      for (double& value : direction.storage()) value = random.uniform(-1, 1);
      Values ahead = values, behind = values;
      const double h = 1e-6;
      for (std::size_t i = 0; i < direction.size(); ++i) {
        (ahead.*member).data()[i] += h * direction.data()[i];
        (behind.*member).data()[i] -= h * direction.data()[i];
      }
      const double expected = (loss(ahead) - loss(behind)) / (2 * h);
      CHECK(std::abs(test::dot(input.adjoint(), direction) - expected) <= 1e-6 * (1 + std::abs(expected)));
    }
  };
  check("texels", inputs.texels, &Values::texels);
  check("positions", inputs.positions, &Values::positions);
  check("pose", inputs.pose, &Values::pose);
  check("light", inputs.light, &Values::light);
}
}  // namespace

TEST_CASE("before a wall every derivative agrees with central differences", "[raster][variable][gradient]") {
  for (const auto& layout : {test::small_atlas, test::vertex, test::cube}) {
    check_wall(warm, layout);
    check_wall(raster::SmoothLight{warm}, layout);
  }
}

TEST_CASE("the picture on the tape is render_textured's, the coverage a silhouette", "[raster][variable]") {
  const test::Scene<raster::Light> scene{test::box(true), test::cube, warm};
  const RenderInputs<double> plain{.texels = scene.texels};
  const auto found = raster::render(scene, Camera{}, side, side, scene.light, plain);
  const auto expected = raster::render_textured(scene, Camera{}, side, side, scene.light, scene.texels, 4);
  CHECK((found.picture.value() == expected.colour));
  CHECK((found.coverage.value() == expected.coverage));
  CHECK((raster::silhouette<double>(scene.mesh, Camera{}, side, side) == expected.coverage));
}

TEST_CASE("positions on the tape pull back to vertex_adjoint and silhouette_adjoint",
          "[raster][variable][gradient]") {
  const test::Scene<raster::Light> scene{test::box(true), test::cube, warm};
  auto seed = tapestry::zeros<double, 2>({side, side});
  const auto weights = smooth_weights();
  for (std::size_t i = 0; i < seed.size(); ++i) seed.data()[i] = weights.data()[3 * i];
  ActiveTape<double> tape;
  const auto positions = tape.input(geometry::position_array<double>(scene.mesh));
  const auto drawn = raster::render(scene, Camera{}, side, side, scene.light,
                                    RenderInputs<double>{.texels = scene.texels, .positions = positions});
  tape.reverse(weighted(drawn.picture));
  CHECK((positions.adjoint() == array_of(scene.gradient(weights))));
  tape.reverse(drawn.coverage, seed);
  std::vector<Vector3> expected(8, Vector3{0, 0, 0});
  raster::silhouette_adjoint(scene.mesh, Camera{}, seed, expected);
  CHECK((positions.adjoint() == array_of(expected)));
}

TEST_CASE("recorded twice before one reverse gives the sum, exactly", "[raster][variable]") {
  auto body = wall();
  const Values values(body);
  const auto gradients = [&](int times) {
    ActiveTape<double> tape;
    const auto inputs = values.active(tape);
    Variable<double> loss = 0;
    for (int i = 0; i < times; ++i) {
      const auto drawn = raster::render(body, Camera{}, side, side, warm, inputs);
      loss = loss + weighted(drawn.picture) + tapestry::sum(drawn.coverage);
    }
    body.mesh.positions[0][0] += 1;  // the tape keeps its own copies
    tape.reverse(loss);
    body.mesh.positions[0][0] -= 1;
    return std::tuple{Array<double, 2>(inputs.texels.adjoint()), Array<double, 2>(inputs.positions.adjoint()),
                      Array<double, 1>(inputs.pose.adjoint()), Array<double, 1>(inputs.light.adjoint())};
  };
  const auto [texels, positions, pose, light] = gradients(1);
  const auto twice = gradients(2);
  CHECK((std::get<1>(twice) == Array<double, 2>(2 * positions)));
  CHECK((std::get<2>(twice) == Array<double, 1>(2 * pose)));
  CHECK((std::get<3>(twice) == Array<double, 1>(2 * light)));
  for (std::size_t i = 0; i < texels.size(); ++i)  // whose sums go on from one picture to the next
    CHECK(std::get<0>(twice).data()[i] == Approx(2 * texels.data()[i]).epsilon(1e-13));
}

TEST_CASE("derivatives on the tape have the same bits for any number of threads", "[raster][variable]") {
  const raster::PaintedMesh body{test::random_triangles(300, 5, 0.4), std::vector<std::uint8_t>(300, 1),
                                 test::small_atlas};
  const Values values(body);
  same_by_threads({1, 2, 3}, [&] {
    ActiveTape<double> tape;
    const auto inputs = values.active(tape);
    const auto drawn = raster::render(body, Camera{}, side, side, warm, inputs);
    tape.reverse(weighted(drawn.picture) + tapestry::sum(drawn.coverage));
    return std::pair(inputs.positions.adjoint(), inputs.pose.adjoint());
  });
}

TEST_CASE("passive inputs record nothing", "[raster][variable]") {
  const auto body = wall();
  const Values values(body);
  ActiveTape<double> tape;
  const auto draw = [&](const RenderInputs<double>& inputs, const auto& gradient) {
    const std::size_t before = tape.record_count();
    (void)raster::render(body, Camera{}, side, side, warm, inputs, gradient);
    return tape.record_count() - before;
  };
  auto inputs = values.passive();
  CHECK(draw(inputs, raster::BoundaryIntegral{}) == 0);
  CHECK(!raster::silhouette(body.mesh, Camera{}, side, side, inputs.positions, inputs.pose).is_active());
  inputs.light = tape.input(values.light);
  CHECK(draw(inputs, raster::BoundaryIntegral{}) == 1);  // the coverage does not depend on it
  inputs.pose = tape.input(values.pose);
  CHECK(draw(inputs, raster::BoundaryIntegral{}) == 2);
  CHECK(draw(inputs, raster::InteriorOnly{}) == 1);
}

TEST_CASE("render on the tape refuses what does not fit", "[raster][variable][bad_input]") {
  const auto body = wall();
  ActiveTape<double> tape;
  const auto draw = [&](const raster::PaintedMesh& what, const auto& light,
                        const RenderInputs<double>& inputs) {
    return raster::render(what, Camera{}, side, side, light, inputs);
  };
  const Values values(body);
  auto inputs = values.passive();
  inputs.positions = tapestry::zeros<double, 2>({4, 3});
  CHECK_THROWS_WITH(draw(body, warm, inputs), "render: positions is [4, 3], expected [3, 3]");
  inputs = values.passive();
  inputs.pose = tapestry::zeros<double, 1>({3});
  CHECK_THROWS_WITH(draw(body, warm, inputs), "render: pose is [3], expected [6]");
  inputs.pose = tapestry::filled<double, 1>({6}, std::nan(""));
  CHECK_THROWS_AS(draw(body, warm, inputs), DomainError);
  inputs = values.passive();
  CHECK_THROWS_AS(draw(body, raster::Unlit{}, inputs), DomainError);
  auto filtered = body;
  filtered.layout.filter = raster::TextureFilter::trilinear;
  inputs = {};
  inputs.texels = tapestry::zeros<double, 2>({raster::stored_texel_count(filtered.layout, body.mesh), 3});
  CHECK_NOTHROW(draw(filtered, warm, inputs));
  inputs.pose = tape.input(values.pose);
  CHECK_THROWS_WITH(draw(filtered, warm, inputs), "render: expected a bilinear atlas, found a filtered one");
}

TEST_CASE("sun and sky are differentiated on the tape, but a mesh does not move under them",
          "[raster][variable][light]") {
  const auto body = wall();
  raster::OutdoorLight light;
  light.direction = {0.2, -0.4, -1};
  const auto start = raster::light_parameters<double>(light);
  const Values values(body);
  const auto loss = [&](const ArrayVariable<double, 1>& numbers) {
    RenderInputs<double> inputs{values.texels};
    inputs.light = numbers;
    return weighted(raster::render(body, Camera{}, side, side, light, inputs).picture);
  };
  ActiveTape<double> tape;
  const auto numbers = tape.input(start);
  tape.reverse(loss(numbers));
  auto at = start;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double expected = test::slope_by(at(i), 1e-6, [&] { return loss(at).value(); });
    CHECK(std::abs(numbers.adjoint()(i) - expected) <= 1e-6 * (1 + std::abs(expected)));
  }
  RenderInputs<double> moving{values.texels};
  moving.pose = tape.input(values.pose);
  CHECK_THROWS_AS(raster::render(body, Camera{}, side, side, light, moving), DomainError);
}
