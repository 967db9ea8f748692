#include <tapestry/camouflage/method/methods.hpp>

#include "../../support/pipeline_gradient.hpp"
#include "../../support/random_array.hpp"
#include "../../support/stepped_car.hpp"
#include "../../support/threads.hpp"

using namespace tapestry;

namespace {
/// A detector that observes the last layer that all heads see.
template <class T>
detect::Detector<T> observing_detector(const std::string& activation) {
  const auto model = test::tiny_model<T>(activation);
  const auto network = model.description();
  return model.detector({detect::common_layer(network, network.outputs)});
}

template <class Predicate>
std::vector<std::string> names_where(Predicate is_wanted) {
  std::vector<std::string> names;
  for (const auto& row : camouflage::methods<double>())
    if (is_wanted(row)) names.push_back(row.name);
  return names;
}
}  // namespace

TEST_CASE("the gradient through every method agrees with central differences",
          "[camouflage][method][gradient]") {
  const auto car = test::stepped_car();
  const std::string name = GENERATE(from_range(names_where([](const auto& row) {
    return row.traits.is_optimised && !row.traits.moves_shape && !row.traits.needs_photo_light;
  })));
  const auto method = camouflage::method_by_name<double>(name, car, 1);
  // The gradient of a score in a layer is constant only in a network that is piecewise linear above it.
  const auto network = observing_detector<double>(method.attention > 0 ? "leaky" : "mish");
  camouflage::Objective<double> objective(network, {});
  objective.follow(method);
  std::vector<std::shared_ptr<const camouflage::View<double>>> views;
  for (std::size_t i = 0; i < 2; ++i)
    views.push_back(std::make_shared<const camouflage::View<double>>(
        camouflage::make_view<double>(test::tiny_frame(i), car, 48, 48)));
  const auto start = camouflage::first_parameter(
      method, test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 4, -1, 1));
  INFO(name);
  REQUIRE(camouflage::method_colours(method, start).shape(0) == car.layout.texel_count(car.mesh));
  test::check_pipeline_gradient(objective, views, start);
  const auto& terms = objective.terms();
  const double rest = terms.total - camouflage::smoothness_unit * terms.smoothness;
  CHECK(rest > 1e-3);
  const double adversarial =
      0.05 * terms.iou + terms.objectness + 0.5 * terms.classification;  // of the paper
  CHECK((rest == Approx(adversarial)) == (method.attention == 0));
}

TEST_CASE("a detector that tells no layer cannot be asked for its attention",
          "[camouflage][method][bad_input]") {
  const auto car = test::stepped_car();
  const auto network = test::tiny_detector<double>();
  camouflage::Objective<double> objective(network, {});
  objective.follow(camouflage::das_full<double>());
  const std::vector<std::shared_ptr<const camouflage::View<double>>> views{
      std::make_shared<const camouflage::View<double>>(
          camouflage::make_view<double>(test::tiny_frame(0), car, 48, 48))};
  const ArrayVariable<double, 2> paint(tapestry::zeros<double, 2>({car.layout.texel_count(car.mesh), 3}));
  CHECK_THROWS_AS(objective(paint, views), DomainError);
}

TEST_CASE("a method trains to the same bits with one and two threads, and goes on from a checkpoint",
          "[camouflage][method][training]") {
  const auto car = test::stepped_car();
  const std::string name = GENERATE(from_range(
      names_where([](const auto& row) { return !row.traits.moves_shape && !row.traits.needs_photo_light; })));
  const auto network = observing_detector<float>("leaky");
  auto store = test::tiny_store<float>(car, 3);
  camouflage::Objective<float> objective(network, {});
  objective.follow(camouflage::method_by_name<float>(name, car, 1));
  camouflage::TrainingOptions options;
  options.epochs = objective.method().is_optimised ? 4 : 0;
  const auto training = [&] {
    const auto start = tapestry::zeros<float, 2>({car.layout.texel_count(car.mesh), 3});
    return camouflage::Training<float>(objective, store, {0, 1, 2},
                                       camouflage::first_parameter(objective.method(), start), options);
  };
  const auto run = [&] {
    auto whole = training();
    while (!whole.finished()) whole.step();
    return whole.parameter();
  };
  INFO(name);
  const auto one = test::same_by_threads({1, 2}, run);
  auto first = training();
  for (int step = 0; step < 5 && !first.finished(); ++step) first.step();
  auto second = training();
  second.restore(first.state());
  while (!second.finished()) second.step();
  CHECK((second.parameter() == one));
  CHECK(second.history().size() == (objective.method().is_optimised ? 12U : 0U));
}
