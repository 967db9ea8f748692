#include <cmath>
#include <tapestry/camouflage/objective.hpp>

#include "../support/catch.hpp"
#include "../support/pipeline_gradient.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/tiny_scene.hpp"

namespace camouflage = tapestry::camouflage;
namespace loss = tapestry::loss;
namespace test = tapestry::test;
using tapestry::Array;

namespace {
/// The three views, prepared.
template <class T>
struct Views {
  std::vector<std::shared_ptr<const camouflage::View<T>>> kept;
  std::vector<const camouflage::View<T>*> pointers;

  explicit Views(camouflage::ViewStore<T> store) {
    for (std::size_t i = 0; i < store.size(); ++i) kept.push_back(store.view(i));
    for (const auto& view : kept) pointers.push_back(view.get());
  }
};
}  // namespace

TEST_CASE("the gradient of the whole pipeline agrees with central differences", "[camouflage][gradient]") {
  const auto kind = GENERATE(loss::AdversarialLoss::paper, loss::AdversarialLoss::as_coded,
                             loss::AdversarialLoss::max_score);
  const bool smooth_texture = kind == loss::AdversarialLoss::max_score;
  const auto car = test::tiny_car();
  const auto network = test::tiny_network<double>();
  const Views<double> views(test::tiny_store<double>(car, 3));
  camouflage::ObjectiveOptions options;
  options.kind = kind;
  options.smooth_texture = smooth_texture;
  options.smoothness = 100;
  if (kind == loss::AdversarialLoss::as_coded)
    options.weights.iou = 0;  // its α is detached: no true derivative
  camouflage::Objective<double> objective(network, car.layout, options);
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  CAPTURE(loss::name_of(kind));
  test::check_pipeline_gradient(objective, views.pointers, start);
}

TEST_CASE("the float pipeline's gradient agrees with double where no kink lies between",
          "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_network<double>("mish");  // smooth: no sign can flip between the precisions
  const auto network_float = network.cast<float>();
  const Views<double> views(test::tiny_store<double>(car, 3));
  const Views<float> views_float(test::tiny_store<float>(car, 3));
  camouflage::Objective<double> objective(network, car.layout, {});
  camouflage::Objective<float> objective_float(network_float, car.layout, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 1, -1, 1);
  const auto exact = test::pipeline_gradient(objective, views.pointers, start);
  const auto rounded =
      test::pipeline_gradient(objective_float, views_float.pointers, tapestry::cast<float>(start));
  CHECK(test::relative_distance(rounded, exact) <= 1e-4);
}

TEST_CASE("the tape adds nothing of its own to the pipeline's gradient in cubes", "[camouflage][gradient]") {
  const auto car = test::tiny_car(12, tapestry::raster::TextureKind::cube);
  const auto network = test::tiny_network<double>();
  const Views<double> views(test::tiny_store<double>(car, 3));
  camouflage::Objective<double> objective(network, car.layout, {});
  const auto start = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 3, -1, 1);
  const auto gradient = test::pipeline_gradient(objective, views.pointers, start);
  const auto direction = test::random_direction<double>({car.layout.texel_count(car.mesh), 3}, 4);
  const double step = 1e-6;
  const auto value = [&](double t) {
    Array<double, 2> moved = start;
    for (std::size_t i = 0; i < moved.size(); ++i) moved.data()[i] += t * direction.data()[i];
    return objective(tapestry::ArrayVariable<double, 2>(moved), views.pointers).value();
  };
  double along = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) along += gradient.data()[i] * direction.data()[i];
  const double numeric = (value(step) - value(-step)) / (2 * step);
  CHECK(std::abs(along - numeric) <= 1e-6 * std::max(std::abs(numeric), 1e-3));
}

TEST_CASE("a class that the network does not have is refused", "[camouflage]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_network<float>();
  camouflage::ObjectiveOptions options;
  options.class_index = 2;
  CHECK_THROWS_AS(camouflage::Objective<float>(network, car.layout, options), tapestry::DomainError);
}

TEST_CASE("texels that no view shows get no gradient", "[camouflage][gradient]") {
  const auto car = test::tiny_car();
  const auto network = test::tiny_network<float>();
  const Views<float> views(test::tiny_store<float>(car, 1));
  camouflage::Objective<float> objective(network, car.layout, {});
  const auto gradient =
      test::pipeline_gradient(objective, views.pointers, tapestry::zeros<float, 2>({24 * 12, 3}));
  std::size_t untouched = 0;
  for (std::size_t texel = 0; texel < 24 * 12; ++texel)
    if (gradient(texel, 0) == 0 && gradient(texel, 1) == 0 && gradient(texel, 2) == 0) ++untouched;
  CHECK(untouched > 24 * 12 / 4);
  CHECK(untouched < 24 * 12);
}
