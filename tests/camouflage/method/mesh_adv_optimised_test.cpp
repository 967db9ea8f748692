#include <tapestry/camouflage/method/comparators.hpp>

#include "../../support/finite_difference.hpp"
#include "../../support/pipeline_gradient.hpp"
#include "../../support/random_array.hpp"
#include "../../support/threads.hpp"
#include "../../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
template <class T>
using Views = std::vector<std::shared_ptr<const camouflage::View<T>>>;

/// Views that keep their Sight.
template <class T>
Views<T> views_of(const raster::PaintedMesh& car, const std::vector<tapestry::io::Frame>& frames,
                  std::size_t samples = 2) {
  Views<T> views;
  for (const auto& frame : frames) {
    auto view = camouflage::make_view<T>(frame, car, 48, 48, samples);
    view.sight = std::make_shared<const camouflage::Sight<T>>(
        camouflage::sight_of<T>(frame, car.space, 48, 48, samples, {}));
    views.push_back(std::make_shared<const camouflage::View<T>>(std::move(view)));
  }
  return views;
}

/// A frame behind whose mask the lower left of the car is hidden, and which is not square.
io::Frame half_hidden(std::size_t number) {
  auto frame = test::tiny_frame(number, 60);
  Array<std::uint8_t, 3> wide(Extents<3>{60, 80, 3});
  for (std::size_t i = 0; i < wide.size(); ++i) wide.data()[i] = frame.image.data()[i % frame.image.size()];
  frame.image = std::move(wide);
  frame.mask = Array<std::uint8_t, 2>(Extents<2>{60, 80});
  for (std::size_t y = 0; y < 60; ++y)
    for (std::size_t x = 0; x < 80; ++x) (*frame.mask)(y, x) = static_cast<std::uint8_t>(x > y ? 255 : 0);
  return frame;
}

/// A frame whose camera stands so near before the car's side that nothing else is in it.
io::Frame before_the_side() {
  auto frame = test::tiny_frame(0);
  frame.camera = geometry::look_along({0.07, -1.35, 0.76}, {0.05, 1, 0.03}, {0, 0, 1});
  frame.camera->tan_half_fov_x = frame.camera->tan_half_fov_y = 0.9;
  frame.light = raster::Light{0.8, 0, {0, 0, 1}, {1, 0.95, 0.9}};  // alike on both faces of the side
  return frame;
}

/// Texture and shape somewhere within their bounds.
template <class T>
Array<T, 2> some_parameter(const camouflage::Method<T>& method) {
  const auto& car = method.shape->car;
  return test::random_array<T>({car.layout.texel_count(car.mesh) + car.mesh.positions.size(), 3}, 4, -1, 1);
}
}  // namespace

TEST_CASE("a shape that has not moved gives the pictures, loss and texture gradient of a mesh that stays",
          "[camouflage][mesh_adv]") {
  auto car = test::tiny_car(12, GENERATE(raster::TextureKind::atlas, raster::TextureKind::cube));
  car.space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const auto network = test::tiny_detector<double>("mish");
  const auto views = views_of<double>(car, {test::tiny_frame(0), half_hidden(1), test::tiny_frame(2, 60)});
  camouflage::ObjectiveOptions options;
  options.smoothness = 100;
  camouflage::Objective<double> plain(network, options), moving(network, options);
  moving.follow(camouflage::mesh_adv<double>(car));
  moving.keep_layers(std::size_t(1) << 30U);  // has no part in it
  const auto texture = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  const auto start = camouflage::first_parameter(moving.method(), texture);
  REQUIRE(start.shape(0) == texture.shape(0) + 8);
  CHECK((camouflage::method_colours(moving.method(), start) == camouflage::texture_colours(texture)));
  const auto expected = test::pipeline_gradient(plain, views, texture);
  const auto found = test::pipeline_gradient(moving, views, start);
  for (const auto& term : camouflage::ObjectiveTerms::all) {
    CAPTURE(term.name);
    CHECK(moving.terms().*term.value == Approx(plain.terms().*term.value).epsilon(1e-12));
  }
  double largest = 0, moves = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) largest = std::max(largest, std::abs(expected.data()[i]));
  for (std::size_t i = 0; i < expected.size(); ++i)
    REQUIRE(std::abs(found.data()[i] - expected.data()[i]) <= 1e-12 * largest);
  for (std::size_t i = expected.size(); i < found.size(); ++i) moves += std::abs(found.data()[i]);
  CHECK(moves > 0);
  CHECK(moving.kept_layers(0).bytes() == 0);
  for (const auto& view : views) {
    const auto colours = camouflage::texture_colours(texture);
    const auto anew =
        camouflage::redrawn<double>(*view, *moving.method().shape, image::in_space(view->space, colours),
                                    ArrayVariable<double, 2>(geometry::position_array<double>(car.mesh)));
    const auto picture = camouflage::picture_of(*view, colours);
    for (std::size_t i = 0; i < picture.size(); ++i)
      REQUIRE(std::abs(anew.picture.value().data()[i] - picture.data()[i]) <= 1e-13);
  }
}

TEST_CASE("before the car's side the gradient by texture and offsets agrees with central differences",
          "[camouflage][mesh_adv][gradient]") {
  auto car = test::tiny_car();
  car.space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const auto views = views_of<double>(car, {before_the_side()});
  REQUIRE(views.front()->visible_pixels == 48 * 48);
  const auto network = test::tiny_detector<double>("mish");
  camouflage::ObjectiveOptions options;
  options.smoothness = 100;
  camouflage::Objective<double> objective(network, options);
  objective.follow(camouflage::mesh_adv<double>(car));
  const auto start = some_parameter(objective.method());
  test::check_pipeline_gradient(objective, views, start);
  // Tests all offsets: they are few beside the texels.
  const std::size_t texels = car.layout.texel_count(car.mesh);
  const auto gradient = test::pipeline_gradient(objective, views, start);
  std::size_t moved = 0;
  auto at = start;
  const auto value = [&] { return objective(ArrayVariable<double, 2>(at), views).value(); };
  for (std::size_t i = 3 * texels; i < start.size(); ++i) {
    const double numeric = test::slope_by(at.data()[i], 1e-5, value);
    CAPTURE(i - 3 * texels, numeric, gradient.data()[i]);
    CHECK(std::abs(gradient.data()[i] - numeric) <= 1e-6 * std::max(std::abs(numeric), 1e-2));
    if (std::abs(numeric) > 1e-4) ++moved;
  }
  CHECK(moved >= 12);
}

TEST_CASE("through outlines a redrawn view's gradient adds up to what the picture changes by",
          "[camouflage][mesh_adv][gradient][long]") {
  auto car = test::tiny_car(12, raster::TextureKind::cube);  // which each sample looks up for itself
  car.space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const auto frame = GENERATE(0, 1) == 0 ? test::tiny_frame(0) : half_hidden(2);
  const auto view = views_of<double>(car, {frame}, 8).front();
  const auto shape = camouflage::shape_parameter(car);
  const ArrayVariable<double, 2> texels(image::in_space(
      car.space, test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, 0.2, 0.8)));
  Array<double, 3> weights(Extents<3>{48, 48, 3});  // change slowly over the picture
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights.data()[i] = std::sin(0.05 * static_cast<double>(i / 144)) *
                        std::cos(0.07 * static_cast<double>(i / 3 % 48) + static_cast<double>(i % 3));
  const auto weighted = [&](const ArrayVariable<double, 2>& positions) {
    return tapestry::sum(camouflage::redrawn<double>(*view, shape, texels, positions).picture *
                         ArrayVariable<double, 3>(weights));
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto motion = test::random_array<double>({8, 3}, seed, -0.15, 0.15);
    const auto at = [&](double t) {
      auto positions = geometry::position_array<double>(car.mesh);
      for (std::size_t i = 0; i < positions.size(); ++i) positions.data()[i] += t * motion.data()[i];
      return positions;
    };
    double sum = 0, passed = 0;
    const int steps = 16;
    for (int k = 0; k < steps; ++k) {
      test::ActiveTape<double> tape;
      const auto positions = tape.input(at((k + 0.5) / steps));
      tape.reverse(weighted(positions));
      double slope = 0;
      for (std::size_t i = 0; i < motion.size(); ++i)
        slope += positions.adjoint().data()[i] * motion.data()[i];
      sum += slope / steps;
      passed += std::abs(slope) / steps;
    }
    const double change =
        weighted(ArrayVariable<double, 2>(at(1))).value() - weighted(ArrayVariable<double, 2>(at(0))).value();
    CAPTURE(seed, sum, change, passed);
    // Some 100 pixels of outline, 8 samples a pixel, jump each by up to 1/8 pixel of a contrast of about ½
    // in three channels: an error of 0.15 between the ends.
    CHECK(std::abs(sum - change) <= 0.15);
    CHECK(passed > 1);
  }
}

TEST_CASE("texture and shape are trained together, within bounds, to the same bits",
          "[camouflage][mesh_adv][training]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  std::vector<camouflage::ViewStore<float>::Loader> loaders{
      [] { return test::tiny_frame(0); }, [] { return half_hidden(1); }, [] { return test::tiny_frame(2); }};
  camouflage::ViewStore<float>::Settings settings{48, 48};
  settings.redrawn = true;
  camouflage::ViewStore<float> store(car, settings, std::move(loaders));
  camouflage::Objective<float> objective(network, {});
  objective.follow(camouflage::mesh_adv<float>(car));
  const auto& shape = *objective.method().shape;
  camouflage::TrainingOptions options;
  options.epochs = 12;
  options.adam.learning_rate = 0.1;
  const auto training = [&] {
    const auto start = tapestry::zeros<float, 2>({car.layout.texel_count(car.mesh), 3});
    return camouflage::Training<float>(objective, store, {0, 1, 2},
                                       camouflage::first_parameter(objective.method(), start), options);
  };
  const auto mean_loss = [](const camouflage::Training<float>& of, std::size_t first) {
    double sum = 0;
    for (std::size_t i = first; i < first + 3; ++i) sum += of.history()[i].total;  // an epoch
    return sum / 3;
  };
  const auto run = [&] {
    auto whole = training();
    while (!whole.finished()) whole.step();
    CHECK(mean_loss(whole, 33) < mean_loss(whole, 0));
    return whole.parameter();
  };
  const auto one = test::same_by_threads({1, 2}, run);
  auto first = training();
  for (int step = 0; step < 17; ++step) first.step();
  auto second = training();
  second.restore(first.state());
  while (!second.finished()) second.step();
  CHECK((second.parameter() == one));
  const auto offsets = camouflage::shape_offsets(shape, one);
  float farthest = 0;
  for (const float offset : offsets) farthest = std::max(farthest, std::abs(offset));
  CHECK(farthest > 0.001F);
  CHECK(farthest <= 0.01F);
  const auto moved = camouflage::reshaped(car, offsets);
  CHECK(moved.mesh.positions[3][0] ==
        Approx(car.mesh.positions[3][0] + 4.0 * static_cast<double>(offsets(3, 0))).epsilon(1e-15));
}

TEST_CASE("the shape alone lowers the loss, and less so the stiffer it is", "[camouflage][mesh_adv]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>("mish");
  const auto views = views_of<double>(car, {test::tiny_frame(0), test::tiny_frame(1)});
  const auto uneven_after = [&](double stiffness) {
    auto shape = camouflage::shape_parameter(car);
    shape.stiffness = stiffness;
    camouflage::Method<double> method;
    method.shape = std::make_shared<const camouflage::ShapeParameter>(shape);
    camouflage::Objective<double> objective(network, {});
    objective.follow(method);
    auto at = camouflage::first_parameter(
        method, test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1));
    const std::size_t first = at.size() - 24;
    const double before = objective(ArrayVariable<double, 2>(at), views).value();
    for (int step = 0; step < 10; ++step) {
      const auto gradient = test::pipeline_gradient(objective, views, at);
      double length = 0;
      for (std::size_t i = first; i < at.size(); ++i) length += gradient.data()[i] * gradient.data()[i];
      for (std::size_t i = first; i < at.size(); ++i)
        at.data()[i] -= 0.05 * gradient.data()[i] / std::sqrt(length);
    }
    CHECK(objective(ArrayVariable<double, 2>(at), views).value() < before);
    const auto steps = camouflage::shape_steps(shape, ArrayVariable<double, 2>(at));
    return camouflage::shape_roughness(shape, steps).value();
  };
  CHECK(uneven_after(1) < uneven_after(0));
}

TEST_CASE("positions at one place move together, and only one row moves them", "[camouflage][mesh_adv]") {
  auto car = test::tiny_car();
  auto& mesh = car.mesh;
  const auto twin = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.push_back(mesh.positions[7]);
  for (std::int32_t& corner : mesh.faces[0])
    if (corner == 7) corner = twin;
  for (std::int32_t& corner : mesh.faces[1])
    if (corner == 7) corner = twin;
  const auto shape = camouflage::shape_parameter(car);
  CHECK(shape.topology.edges == geometry::mesh_topology(test::tiny_car().mesh).edges);
  const auto parameter = test::random_array<double>({20, 3}, 3, -2, 2);
  const auto offsets = camouflage::shape_offsets(shape, parameter);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(offsets(8, c) == offsets(7, c));
    CHECK(offsets(7, c) == Approx(0.01 * std::tanh(parameter(20 - 9 + 7, c))).epsilon(1e-15));
  }
  const ArrayVariable<double, 2> together(tapestry::filled<double, 2>({9, 3}, 0.7));
  CHECK(camouflage::shape_roughness(shape, camouflage::shape_steps(shape, together)).value() == 0);
}

TEST_CASE("what cannot move is refused", "[camouflage][mesh_adv][bad_input]") {
  auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>();
  camouflage::Objective<double> objective(network, {});
  objective.follow(camouflage::mesh_adv<double>(car));
  const ArrayVariable<double, 2> start(
      camouflage::first_parameter(objective.method(), tapestry::zeros<double, 2>({288, 3})));
  auto store = test::tiny_store<double>(car, 1);
  const Views<double> views{store.view(0)};
  CHECK_THROWS_WITH(objective(start, views), "redrawn: view frame0 does not keep what it is drawn by");
  const ArrayVariable<double, 2> shape_only(tapestry::zeros<double, 2>({8, 3}));
  CHECK_THROWS_WITH(objective(shape_only, views), "texture_rows: 8 rows, of which the shape has 8");
  CHECK_THROWS_AS(camouflage::shape_steps(*objective.method().shape,
                                          ArrayVariable<double, 2>(tapestry::zeros<double, 2>({7, 3}))),
                  ShapeError);
  CHECK_THROWS_WITH(camouflage::reshaped(car, tapestry::zeros<double, 2>({7, 3})),
                    "reshaped: offsets is [7, 3], expected [8, 3]");
  car.layout.filter = raster::TextureFilter::trilinear;
  CHECK_THROWS_WITH(camouflage::mesh_adv<double>(car),
                    "shape_parameter: expected a bilinear atlas, found a filtered one");
  car.layout.filter = raster::TextureFilter::bilinear;
  car.mesh.faces[0][1] = 8;
  CHECK_THROWS_AS(camouflage::mesh_adv<double>(car), Error);
}
