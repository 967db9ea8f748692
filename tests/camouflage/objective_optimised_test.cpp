#include <tapestry/camouflage/objective.hpp>
#include <tapestry/loss/printability.hpp>

#include "../support/finite_difference.hpp"
#include "../support/pipeline_gradient.hpp"
#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/relative_distance.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
/// The first views of the tiny scene, prepared.
template <class T>
std::vector<std::shared_ptr<const camouflage::View<T>>> views_of(const raster::PaintedMesh& car,
                                                                 std::size_t count = 3) {
  auto store = test::tiny_store<T>(car, count);
  std::vector<std::shared_ptr<const camouflage::View<T>>> views;
  for (std::size_t i = 0; i < count; ++i) views.push_back(store.view(i));
  return views;
}

detect::Detector<float> window_detector(std::size_t size) {
  const auto config = io::parse_network_config(test::cfg_text("window_layers"), "some.cfg");
  return test::random_model<float>(config, 1, size).detector();
}
}  // namespace

TEST_CASE("the gradient of the whole pipeline agrees with central differences", "[camouflage][gradient]") {
  const auto kind = GENERATE(loss::AdversarialLoss::paper, loss::AdversarialLoss::as_coded,
                             loss::AdversarialLoss::max_score);
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>();
  const auto views = views_of<double>(car);
  camouflage::ObjectiveOptions options;
  options.kind = kind;
  options.smoothness = 100;
  if (kind == loss::AdversarialLoss::as_coded)
    options.weights.iou = 0;  // its α is detached: no true derivative
  std::shared_ptr<const Array<double, 2>> used_texels;
  if (kind == loss::AdversarialLoss::max_score)
    used_texels = std::make_shared<const Array<double, 2>>(
        tapestry::filled<double, 2>({car.layout.height, car.layout.width}, 1));
  camouflage::Objective<double> objective(network, options, used_texels);
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  CAPTURE(loss::name_of(kind));
  test::check_pipeline_gradient(objective, views, start);
}

TEST_CASE("the gradient with a non-printability score agrees with central differences",
          "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>();
  const auto views = views_of<double>(car);
  const std::size_t texels = car.layout.texel_count(car.mesh);
  camouflage::ObjectiveOptions options;
  options.printability = 30;
  camouflage::Objective<double> objective(network, options), plain(network, options);
  const auto palette = std::make_shared<const Array<double, 2>>(loss::printable_colours());
  const auto used = std::make_shared<const Array<double, 2>>(tapestry::filled<double, 2>({1, texels}, 1));
  objective.print_by(palette, used);
  const auto start = test::random_array<double>({texels, 3}, 1, -1, 1);
  test::check_pipeline_gradient(objective, views, start);
  const ArrayVariable<double, 2> passive(start);
  const double with = objective(passive, views).value(), without = plain(passive, views).value();
  const double score = loss::non_printability(camouflage::texture_colours(start), *used, *palette);
  CHECK(objective.terms().printability == score);
  CHECK(plain.terms().printability == 0);
  CHECK(with == Approx(without + 30 * score).epsilon(1e-14));
  objective.print_by(palette, std::make_shared<const Array<double, 2>>(tapestry::zeros<double, 2>({1, 5})));
  CHECK_THROWS_AS(objective(passive, views), ShapeError);
}

TEST_CASE("the gradient through a photo session agrees with central differences", "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>("mish");
  const auto views = views_of<double>(car);
  image::Conditions conditions = image::physical_conditions;
  conditions.worst_quality = 0;  // rounding jumps, see the test of JPEG's own adjoint
  const auto session = camouflage::draw_session<double>(views, conditions, Random(5), true);
  REQUIRE(session.print);
  camouflage::Objective<double> objective(network, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  test::check_pipeline_gradient(objective, views, start, &session);
  const auto short_session =
      camouflage::draw_session<double>(std::span(views).first(2), conditions, Random(5), true);
  CHECK_THROWS_AS(objective(ArrayVariable<double, 2>(start), views, &short_session), ShapeError);
}

TEST_CASE("a session without conditions changes no bit", "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  const auto views = views_of<float>(car);
  const auto session = camouflage::draw_session<float>(views, {}, Random(5), true);
  CHECK_FALSE(session.print);
  camouflage::Objective<float> objective(network, {});
  const auto start = test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  const ArrayVariable<float, 2> parameter(start);
  CHECK(objective(parameter, views, &session).value() == objective(parameter, views).value());
}

TEST_CASE("the float pipeline's gradient agrees with double where no kink lies between",
          "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network =
      test::tiny_detector<double>("mish");  // smooth: no sign can flip between the precisions
  const auto network_float = test::tiny_detector<float>("mish");
  const auto views = views_of<double>(car);
  const auto views_float = views_of<float>(car);
  camouflage::Objective<double> objective(network, {});
  camouflage::Objective<float> objective_float(network_float, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  const auto exact = test::pipeline_gradient(objective, views, start);
  const auto rounded = test::pipeline_gradient(objective_float, views_float, tapestry::cast<float>(start));
  CHECK(test::relative_distance(rounded, exact) <= 1e-4);
}

TEST_CASE("the tape adds nothing of its own to the pipeline's gradient in cubes", "[camouflage][gradient]") {
  const auto car = test::tiny_car(12, raster::TextureKind::cube);
  const auto network = test::tiny_detector<double>();
  const auto views = views_of<double>(car);
  camouflage::Objective<double> objective(network, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 3, -1, 1);
  const auto gradient = test::pipeline_gradient(objective, views, start);
  const auto direction = test::random_direction<double>({car.layout.texel_count(car.mesh), 3}, 4);
  double t = 0;
  const double numeric = test::slope_by(t, 1e-6, [&] {
    return objective(ArrayVariable<double, 2>(Array<double, 2>(start + t * direction)), views).value();
  });
  CHECK(std::abs(test::dot(gradient, direction) - numeric) <= 1e-6 * std::max(std::abs(numeric), 1e-3));
}

TEST_CASE("a class that the network does not have is refused", "[camouflage]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  camouflage::ObjectiveOptions options;
  options.class_index = 2;
  CHECK_THROWS_AS(camouflage::Objective<float>(network, options), DomainError);
}

TEST_CASE("texels that no view shows get no gradient", "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  const auto views = views_of<float>(car, 1);
  camouflage::Objective<float> objective(network, {});
  const auto gradient = test::pipeline_gradient(objective, views, tapestry::zeros<float, 2>({24 * 12, 3}));
  std::size_t untouched = 0;
  for (std::size_t texel = 0; texel < 24 * 12; ++texel)
    if (gradient(texel, 0) == 0 && gradient(texel, 1) == 0 && gradient(texel, 2) == 0) ++untouched;
  CHECK(untouched > 24 * 12 / 4);
  CHECK(untouched < 24 * 12);
}

TEST_CASE("recorded twice before one reverse, the gradient is the sum of both", "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<double>();
  const auto views = views_of<double>(car);
  camouflage::Objective<double> objective(network, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  const std::span all(views);
  const auto first = test::pipeline_gradient(objective, all.first(1), start);
  const auto second = test::pipeline_gradient(objective, all.last(2), start);
  test::ActiveTape<double> tape;
  const auto parameter = tape.input(start);
  const auto loss_of_first = objective(parameter, all.first(1));
  const auto loss_of_second = objective(parameter, all.last(2));
  tape.reverse(loss_of_first);
  CHECK((parameter.adjoint() == first));
  tape.reverse(Variable<double>(loss_of_first + loss_of_second));
  const Array<double, 2> sum = first + second;
  CHECK(test::relative_distance(parameter.adjoint(), sum) <= 1e-15);  // added in another order
}

TEST_CASE("the profile names every stage of both directions", "[camouflage]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  camouflage::Objective<float> objective(network, {});
  const auto views = views_of<float>(car);
  (void)test::pipeline_gradient(objective, views,
                                tapestry::zeros<float, 2>({car.layout.texel_count(car.mesh), 3}));
  const auto& times = objective.times();
  for (const double seconds : {times.render, times.composite, times.detector_forward, times.detector_backward,
                               times.losses, times.update}) {
    CHECK(seconds > 0);
    CHECK(seconds < 60);
  }
}

TEST_CASE("a passive texture records nothing", "[camouflage]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_detector<float>();
  camouflage::Objective<float> objective(network, {});
  const auto views = views_of<float>(car, 1);
  test::ActiveTape<float> tape;
  const auto start = tapestry::zeros<float, 2>({car.layout.texel_count(car.mesh), 3});
  CHECK_FALSE(objective(ArrayVariable<float, 2>(start), views).is_active());
  CHECK(tape.record_count() == 0);
}

TEST_CASE("the loss of an ensemble is the mean of its members', and so is the gradient",
          "[camouflage][ensemble]") {
  const auto car = test::tiny_car();
  const auto first = test::tiny_detector<double>(), second = test::tiny_detector<double>("mish", 8);
  const auto views = views_of<double>(car);
  camouflage::ObjectiveOptions options;
  options.class_index = 1;
  camouflage::Objective<double> one(first, options), ensemble(first, options);
  ensemble.join(second, 0);
  options.class_index = 0;
  camouflage::Objective<double> other(second, options);
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 3, -1, 1);
  const Array<double, 2> mean =
      (test::pipeline_gradient(one, views, start) + test::pipeline_gradient(other, views, start)) / 2;
  for (int pass = 0; pass < 2; ++pass)  // with own memory, then with that of the step before
    CHECK(test::relative_distance(test::pipeline_gradient(ensemble, views, start), mean) <= 1e-13);
  CHECK(ensemble.terms().total == Approx((one.terms().total + other.terms().total) / 2).epsilon(1e-13));
  CHECK(ensemble.terms().iou == Approx((one.terms().iou + other.terms().iou) / 2).epsilon(1e-13));
  CHECK(ensemble.terms().smoothness == one.terms().smoothness);
  CHECK(one.terms().total != Approx(other.terms().total));
}

TEST_CASE("an ensemble refuses what cannot look at its pictures", "[camouflage][ensemble]") {
  const auto first = test::tiny_detector<double>();
  const auto larger = test::tiny_model<double>().resized(96, 96).detector();
  camouflage::Objective<double> objective(first, {});
  CHECK_THROWS_WITH(objective.join(larger, 0),
                    "objective: the ensemble's detectors take pictures of different extents");
  CHECK_THROWS_AS(objective.join(first, 2), DomainError);
}

TEST_CASE("layers that the car cannot reach are kept, and change no bit of a loss or gradient",
          "[camouflage]") {
  const auto car = test::tiny_car();
  const auto views = views_of<float>(car);
  const auto network = window_detector(views[0]->background.shape()[1]);
  camouflage::Objective<float> plain(network, {}), keeping(network, {}), full(network, {});
  keeping.join(network, 0);
  plain.join(network, 0);
  keeping.keep_layers(std::size_t(1) << 30U, 0);
  full.keep_layers(1, 0);
  const auto gradient_of = [&](camouflage::Objective<float>& objective, const Array<float, 2>& texture,
                               std::size_t first, std::size_t count) {
    test::ActiveTape<float> tape;
    const auto parameter = tape.input(texture);
    tape.reverse(objective(parameter, std::span(views).subspan(first, count)));
    return parameter.adjoint();
  };
  for (std::uint64_t step = 1; step <= 3; ++step) {
    const auto texture = test::random_array<float>({car.layout.texel_count(car.mesh), 3}, step, -1, 1);
    CHECK((gradient_of(keeping, texture, 0, 3) == gradient_of(plain, texture, 0, 3)));
    CHECK(keeping.terms().total == plain.terms().total);
    CHECK((gradient_of(keeping, texture, 1, 1) == gradient_of(plain, texture, 1, 1)));
    CHECK((gradient_of(full, texture, 0, 2) == gradient_of(plain, texture, 0, 2)));
  }
  CHECK(plain.kept_layers(0).bytes() == 0);
  CHECK(full.kept_layers(0).bytes() == 0);
  for (const std::size_t member : {0U, 1U}) {
    // More than the pictures themselves, of three views.
    CHECK(keeping.kept_layers(member).bytes() > 3 * views[0]->background.size() * sizeof(float));
    CHECK(keeping.kept_layers(member).kept_count() == 3);
  }
}

TEST_CASE("layers are kept of those views only whose windows leave out a share of the products",
          "[camouflage]") {
  const auto car = test::tiny_car();
  const auto views = views_of<float>(car);
  const auto network = window_detector(views[0]->background.shape()[1]);
  std::vector<double> shares;
  for (const auto& view : views) shares.push_back(network.share_kept(view->window));
  std::ranges::sort(shares);
  REQUIRE(shares.front() < shares.back());
  for (const double least : {shares.front(), shares.back(), 1.0}) {
    camouflage::Objective<float> objective(network, {});
    objective.keep_layers(std::size_t(1) << 30U, least);
    test::ActiveTape<float> tape;
    const auto parameter =
        tape.input(test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1));
    static_cast<void>(objective(parameter, views));
    const auto worth = std::ranges::count_if(shares, [&](double share) { return share >= least; });
    CHECK(objective.kept_layers(0).view_count() == views.size());
    CHECK(objective.kept_layers(0).kept_count() == static_cast<std::size_t>(worth));
    CHECK((objective.kept_layers(0).bytes() > 0) == (worth > 0));
  }
}
