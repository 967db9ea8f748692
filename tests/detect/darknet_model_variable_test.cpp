#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/optim/adam.hpp>

#include "../support/active_tape.hpp"
#include "../support/cfg_text.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
const std::string two_heads = test::cfg_text("two_heads");

template <class T>
detect::DarknetModel<T> two_headed_model() {
  detect::DarknetModel<T> model(io::parse_network_config(two_heads, "two heads"));
  Random random(5);
  model.initialise(random);
  return model;
}

/// Something that weighs every logit differently.
template <class T>
Variable<T> total(const std::vector<ArrayVariable<T, 4>>& logits) {
  return sum(logits[0] * logits[0]) + sum(logits[1] * exp(T(0.1) * logits[1]));
}

/// The gradient of first · Σ logits[0] + second · Σ logits[1], without a tape.
template <class T>
Array<T, 4> weighted_adjoint(const detect::Detector<T>& detector, const Array<T, 4>& images, T first,
                             T second) {
  detect::Pass<T> pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  auto adjoint = tapestry::zeros<T, 4>(images.shape());
  detector.input_adjoint(pass,
                         {tapestry::filled<T, 4>(pass.logits[0].shape(), first),
                          tapestry::filled<T, 4>(pass.logits[1].shape(), second)},
                         adjoint);
  return adjoint;
}

template <class F, std::size_t Rank>
void check_along(const F& value, const Array<double, Rank>& at, const Array<double, Rank>& direction,
                 const Array<double, Rank>& adjoint) {
  const double expected = test::central_difference(value, at, direction);
  CHECK(test::dot(adjoint, direction) ==
        Approx(expected).epsilon(1e-8).margin(test::central_difference_tolerance(value(at))));
}
}  // namespace

TEST_CASE("a network on the tape is its input adjoint, bit for bit", "[detect][darknet_model][tape]") {
  const auto detector = two_headed_model<float>().detector();
  const auto images = random_array<float, 4>({2, 8, 8, 3}, 1);
  ActiveTape<float> tape;
  const auto input = tape.input(images);
  const auto logits = forward(detector, input);
  REQUIRE(logits.size() == 2);
  tape.reverse(sum(logits[0]) + 2 * sum(logits[1]));

  detect::Pass<float> pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  CHECK((logits[0].value() == pass.logits[0]));
  CHECK((logits[1].value() == pass.logits[1]));
  CHECK((input.adjoint() == weighted_adjoint(detector, images, 1.F, 2.F)));
}

TEST_CASE("the gradient through a network on the tape agrees with central differences",
          "[detect][darknet_model][tape][gradient]") {
  const auto detector = two_headed_model<double>().detector();
  const auto images = random_array<double, 4>({2, 8, 8, 3}, 2);
  const auto direction = random_array<double, 4>({2, 8, 8, 3}, 3);
  const auto value = [&](const Array<double, 4>& x) {
    return total(forward(detector, ArrayVariable<double, 4>(x))).value();
  };
  ActiveTape<double> tape;
  const auto input = tape.input(images);
  tape.reverse(total(forward(detector, input)));
  check_along(value, images, direction, input.adjoint());
}

TEST_CASE("weights on the tape get their adjoints in training mode",
          "[detect][darknet_model][tape][gradient]") {
  auto detector = two_headed_model<double>().learning_detector();
  const auto start = detector.weights();
  const auto images = random_array<double, 4>({3, 8, 8, 3}, 4);
  const auto direction = random_array<double, 1>({start.size()}, 6, -1, 1);
  const auto value = [&](const Array<double, 1>& weights) {
    return total(forward(detector, ArrayVariable<double, 4>(images), ArrayVariable<double, 1>(weights)))
        .value();
  };
  ActiveTape<double> tape;
  const auto weights = tape.input(start);
  const bool wants_images = GENERATE(false, true);
  const auto input = wants_images ? tape.input(images) : ArrayVariable<double, 4>(images);
  tape.reverse(total(forward(detector, input, weights)));
  const Array<double, 1> adjoint = weights.adjoint();
  CHECK((detector.weights() == start));
  check_along(value, start, direction, adjoint);
  if (!wants_images) return;
  const auto image_direction = random_array<double, 4>({3, 8, 8, 3}, 7);
  const auto image_value = [&](const Array<double, 4>& x) {
    return total(forward(detector, ArrayVariable<double, 4>(x), ArrayVariable<double, 1>(start))).value();
  };
  check_along(image_value, images, image_direction, input.adjoint());
}

TEST_CASE("running statistics follow the batch's while weights are stepped",
          "[detect][darknet_model][tape]") {
  auto model = two_headed_model<double>();
  auto detector = model.learning_detector();
  const auto images = random_array<double, 4>({3, 8, 8, 3}, 14);
  auto own = detector.weights();
  optim::Adam<double> adam(own.size());
  const auto pass = std::make_shared<detect::Pass<double>>();
  const int steps = 200;
  for (int step = 0; step < steps; ++step) {
    ActiveTape<double> tape;
    const auto weights = tape.input(own);
    tape.reverse(total(forward(detector, ArrayVariable<double, 4>(images), weights, pass)));
    model.update_running_statistics(*pass);
    if (step + 1 == steps) break;  // the last pass has the statistics of the detector's weights
    adam.set_learning_rate(0.03 * std::pow(0.9, step));
    adam.step(own, weights.adjoint());
  }
  // A running value forgets a tenth a step, and so does the learning rate: of what a step moves at most
  // 200 · 0.9^199 < 2e-7 is missing. The variance is unbiased: n/(n−1) with n = 3·8·8 in the first layer.
  const double* const means = pass->graph[0].output(pass->logits.size());  // behind the heads' logits
  const double* const variances = pass->graph[0].output(pass->logits.size() + 1);
  const auto& place = model.layout().layers[0];
  const double unbias = 3. * 8 * 8 / (3 * 8 * 8 - 1);
  for (std::size_t c = 0; c < model.config().layers[0].filters; ++c) {
    const auto& parameters = model.parameters();
    CHECK(parameters[place.mean + c] == Approx(means[c]).epsilon(1e-6).margin(1e-6));
    CHECK(parameters[place.variance + c] == Approx(variances[c] * unbias).epsilon(1e-6));
  }
}

TEST_CASE("a head that nothing depends on changes nothing", "[detect][darknet_model][tape]") {
  const auto detector = two_headed_model<double>().detector();
  const auto images = random_array<double, 4>({1, 8, 8, 3}, 8);
  ActiveTape<double> tape;
  const auto input = tape.input(images);
  tape.reverse(sum(forward(detector, input)[1]));
  CHECK((input.adjoint() == weighted_adjoint(detector, images, 0.0, 1.0)));
}

TEST_CASE("a network's record may be reversed again", "[detect][darknet_model][tape]") {
  const auto detector = two_headed_model<double>().detector();
  ActiveTape<double> tape;
  const auto input = tape.input(random_array<double, 4>({1, 8, 8, 3}, 13));
  const auto logits = forward(detector, input);
  const auto first = sum(logits[0]);
  const auto second = 3 * sum(logits[0]);
  tape.reverse(first);
  const Array<double, 4> once = input.adjoint();
  tape.reverse(second);
  CHECK(test::relative_distance(input.adjoint(), Array<double, 4>(3.0 * once)) < 1e-14);
}

TEST_CASE("passive pictures leave no record of a network", "[detect][darknet_model][tape]") {
  const auto detector = two_headed_model<float>().detector();
  ActiveTape<float> tape;
  const auto logits = forward(detector, ArrayVariable<float, 4>(random_array<float, 4>({1, 8, 8, 3}, 9)));
  CHECK_FALSE(logits[0].is_active());
  CHECK(tape.statement_count() == 0);
}

TEST_CASE("a loop records a network again and again in the same memory", "[detect][darknet_model][tape]") {
  const auto detector = two_headed_model<float>().detector();
  const auto images = random_array<float, 4>({1, 8, 8, 3}, 10);
  const auto pass = std::make_shared<detect::Pass<float>>();
  Array<float, 4> first;
  for (int step = 0; step < 3; ++step) {
    ActiveTape<float> tape;
    const auto input = tape.input(images);
    tape.reverse(total(forward(detector, input, pass)));
    if (step == 0) first = input.adjoint();
    CHECK((input.adjoint() == first));
  }
}

TEST_CASE("a network on the tape refuses what does not fit", "[detect][darknet_model][tape][error]") {
  auto detector = two_headed_model<float>().learning_detector();
  ActiveTape<float> tape;
  const auto images = tape.input(random_array<float, 4>({1, 8, 8, 3}, 11));
  CHECK_THROWS_AS(forward(detector, images, tape.input(tapestry::zeros<float, 1>({3}))), ShapeError);
  const auto wide = tape.input(random_array<float, 4>({1, 8, 16, 3}, 12));
  CHECK_THROWS_AS(forward(detector, wide), ShapeError);

  const auto before = detector.weights();
  const auto zeros = tape.input(tapestry::zeros<float, 1>({before.size()}));
  CHECK_THROWS_AS(forward(detector, wide, zeros), ShapeError);
  Tape<float> other;
  const auto other_scope = other.activate();
  CHECK_THROWS_AS(forward(detector, images, zeros), DomainError);
  CHECK((detector.weights() == before));
}
