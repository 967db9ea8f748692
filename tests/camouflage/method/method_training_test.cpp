#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/camouflage/method/methods.hpp>
#include <tapestry/camouflage/training.hpp>
#include <tapestry/core/parallel.hpp>
#include <vector>

#include "../../support/catch.hpp"
#include "../../support/pipeline_gradient.hpp"
#include "../../support/random_array.hpp"
#include "../../support/stepped_car.hpp"

namespace camouflage = tapestry::camouflage;
namespace test = tapestry::test;

TEST_CASE("the gradient through every method agrees with central differences",
          "[camouflage][method][gradient]") {
  const auto car = test::stepped_car();
  const std::string name =
      GENERATE(std::string("planar_patch"), std::string("camou"), std::string("upc"), std::string("solid"));
  const auto method = camouflage::method_by_name<double>(name, car, 1);
  const auto network = test::tiny_network<double>("mish");
  camouflage::Objective<double> objective(network, {});
  objective.follow(method);
  std::vector<std::shared_ptr<const camouflage::View<double>>> views;
  for (std::size_t i = 0; i < 2; ++i)
    views.push_back(std::make_shared<const camouflage::View<double>>(
        camouflage::make_view<double>(test::tiny_frame(i), car, 48, 48)));
  INFO(name);
  test::check_pipeline_gradient(
      objective, views,
      camouflage::first_parameter(
          method, test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 4, -1, 1)));
}

TEST_CASE("a method trains to the same bits with one and two threads, and goes on from a checkpoint",
          "[camouflage][method][training]") {
  const auto car = test::stepped_car();
  const std::string name = GENERATE(std::string("planar_patch"), std::string("camou"), std::string("upc"),
                                    std::string("solid"), std::string("random"));
  const auto network = test::tiny_network<float>();
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
  const auto run = [&](int threads) {
    tapestry::limit_threads(threads);
    auto whole = training();
    while (!whole.finished()) whole.step();
    return whole.parameter();
  };
  INFO(name);
  const auto one = run(1), two = run(2);
  CHECK((one == two));
  auto first = training();
  for (int step = 0; step < 5 && !first.finished(); ++step) first.step();
  auto second = training();
  second.restore(first.state());
  while (!second.finished()) second.step();
  CHECK((second.parameter() == one));
  CHECK(second.history().size() == (objective.method().is_optimised ? 12U : 0U));
}
