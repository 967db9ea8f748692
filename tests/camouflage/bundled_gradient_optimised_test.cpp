#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/paths.hpp"
#include "../support/pipeline_gradient.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"

// The pipeline's gradient at full size: the bundled sedan, detector and three of the bundled frames.

using namespace tapestry;

namespace {
const std::string assets = test::in_sources("examples/assets/");

raster::PaintedMesh sedan() {
  raster::PaintedMesh car;
  car.mesh = io::read_obj(assets + "car_sedan.obj").mesh;
  car.painted = geometry::faces_by_material(car.mesh, {"body"});
  car.layout.height = 64;
  car.layout.width = 128;
  car.layout.u_extent = 2;
  return car;
}

template <class T>
detect::Detector<T> bundled_detector() {
  return io::read_detector<T>({.weights = assets + "detector.weights", .config = assets + "detector.cfg"});
}

template <class T>
std::vector<std::shared_ptr<const camouflage::View<T>>> bundled_views(const raster::PaintedMesh& car) {
  std::vector<std::shared_ptr<const camouflage::View<T>>> views;
  for (const char* name : {"003", "027", "058"}) {
    auto frame = io::read_frame(assets + "frames/test/" + name + ".npz");
    views.push_back(
        std::make_shared<const camouflage::View<T>>(camouflage::make_view<T>(frame, car, 256, 256)));
  }
  return views;
}

Array<double, 2> start_texture(std::uint64_t seed = 7) {
  return test::random_array<double>({64 * 128, 3}, seed, -0.5, 0.5);
}

template <class T>
Array<T, 2> gradient_of(const raster::PaintedMesh& car, loss::AdversarialLoss kind, std::uint64_t seed) {
  const auto network = bundled_detector<T>();
  const auto views = bundled_views<T>(car);
  camouflage::ObjectiveOptions options;
  options.kind = kind;
  camouflage::Objective<T> objective(network, options);
  return test::pipeline_gradient(objective, views, tapestry::cast<T>(start_texture(seed)));
}
}  // namespace

TEST_CASE("the gradient of the bundled scene agrees with central differences", "[camouflage][gradient]") {
  using image::ColourSpace;
  const auto [kind, space] = GENERATE(
      table<loss::AdversarialLoss, ColourSpace>({{loss::AdversarialLoss::paper, ColourSpace::encoded},
                                                 {loss::AdversarialLoss::max_score, ColourSpace::encoded},
                                                 {loss::AdversarialLoss::max_score, ColourSpace::linear}}));
  auto car = sedan();
  car.space = space;
  if (space == ColourSpace::linear) {  // as new runs have it
    car.layout.filter = raster::TextureFilter::anisotropic;
    car.pyramid = raster::pyramid_of(car);
  }
  const auto network = bundled_detector<double>();
  const auto views = bundled_views<double>(car);
  camouflage::ObjectiveOptions options;
  options.kind = kind;
  camouflage::Objective<double> objective(network, options);
  CAPTURE(loss::name_of(kind), image::name_of(space));
  test::check_pipeline_gradient(objective, views, start_texture());
}

TEST_CASE("the float gradient of the bundled scene agrees with double", "[camouflage][gradient]") {
  const auto kind = GENERATE(loss::AdversarialLoss::paper, loss::AdversarialLoss::max_score);
  const auto car = sedan();
  std::vector<double> distances;
  for (const std::uint64_t seed : {7U, 9U, 10U, 11U, 12U})
    distances.push_back(
        test::relative_distance(gradient_of<float>(car, kind, seed), gradient_of<double>(car, kind, seed)));
  std::sort(distances.begin(), distances.end());
  CAPTURE(loss::name_of(kind), distances);
  CHECK(distances[2] <= 1e-5);
  // In float a leaky unit next to 0 may come out on its other side, which moves the gradient by a step.
  CHECK(distances.back() <= 5e-3);
}
