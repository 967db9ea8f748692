// A step's detector, forward and input gradient, of a picture in which only a car's window changes:
// everything, or only what the window reaches. yolov3 with random weights, on the threads that there are.
#include <benchmark/benchmark.h>

#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/io/darknet/model_file.hpp>

namespace {
namespace detect = tapestry::detect;
using tapestry::Array;

constexpr char cfg[] = "/usr/share/darknet/cfg/yolov3.cfg";

detect::DarknetModel<float> random_model(std::size_t side) {
  detect::DarknetModel<float> model(tapestry::io::read_network_config(cfg), side, side);
  tapestry::Random random(1);
  model.initialise(random);
  return model;
}

/// A detector of random weights and a picture, the last ones in use.
struct Problem {
  explicit Problem(std::size_t side) : detector(random_model(side).detector()) {
    tapestry::Random random(1);
    for (float& value : picture.storage()) value = static_cast<float>(random.uniform());
    detector.forward(picture, pass);
    weighting = pass.logits;
    for (auto& array : weighting)
      for (float& value : array.storage()) value = static_cast<float>(random.normal());
  }
  [[nodiscard]] Array<float, 4> gradient(detect::Pass<float>& of) const {
    auto adjoint = tapestry::zeros<float, 4>(picture.shape());
    detector.input_adjoint(of, weighting, adjoint);
    return adjoint;
  }

  detect::Detector<float> detector;
  Array<float, 4> picture =
      tapestry::zeros<float, 4>({1, detector.input_height(), detector.input_width(), 3});
  detect::Pass<float> pass;
  std::vector<Array<float, 4>> weighting;
};

Problem& problem_of(std::size_t side) {
  static std::unique_ptr<Problem> last;
  if (!last || last->detector.input_height() != side) {
    last.reset();
    last = std::make_unique<Problem>(side);
  }
  return *last;
}

void whole(benchmark::State& state) {
  Problem& problem = problem_of(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    problem.detector.forward(problem.picture, problem.pass, detect::Mode::input_gradient);
    benchmark::DoNotOptimize(problem.gradient(problem.pass).data());
  }
}

/// The window is in the middle, its height and width are thousandths of the picture's.
void window(benchmark::State& state) {
  const auto side = static_cast<std::size_t>(state.range(0));
  Problem& problem = problem_of(side);
  const auto extent = [&](std::size_t argument) {
    return std::max<std::size_t>(1, side * static_cast<std::size_t>(state.range(argument)) / 1000);
  };
  const std::size_t height = extent(1), width = extent(2);
  detect::KeptPicture<float> kept({(side - height) / 2, (side - width) / 2, height, width});
  detect::Pass<float> pass;
  const auto run = [&] {
    problem.detector.forward_within(problem.picture, {&kept}, pass, detect::Mode::input_gradient);
    return problem.gradient(pass);
  };
  run();
  for (auto _ : state) benchmark::DoNotOptimize(run().data());
  state.counters["kept_MiB"] = static_cast<double>(kept.bytes()) / double(1 << 20);
  const auto found = run();
  problem.detector.forward(problem.picture, problem.pass, detect::Mode::input_gradient);
  const auto expected = problem.gradient(problem.pass);
  if (found(0, side / 2, side / 2, 1) != expected(0, side / 2, side / 2, 1) ||
      pass.logits != problem.pass.logits)
    state.SkipWithError("other bits than of a whole pass");
}
}  // namespace

// A near car from the side and from the front, one at 10 m, one at 20 m.
BENCHMARK(whole)->Arg(416)->Arg(608)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(window)
    ->Args({416, 240, 550})
    ->Args({416, 350, 300})
    ->Args({416, 100, 170})
    ->Args({416, 50, 80})
    ->Args({608, 240, 550})
    ->Args({608, 350, 300})
    ->Args({608, 100, 170})
    ->Args({608, 50, 80})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
