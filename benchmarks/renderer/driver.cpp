// renderer: speed and error of visibility, frames and gradients of a car, ours beside Embree and llvmpipe

#include "comparison.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

struct Options : DriverOptions {
  std::vector<int> threads{1, 2};
  std::vector<double> distances{1.5, 5, 20};
  std::vector<std::size_t> sizes{256, 640, 1024};
  std::string mesh = TAPESTRY_SHARED "/data/mesh/audi_et_te.obj";
};

[[nodiscard]] bool is_gradient(const Comparison& comparison) {
  return comparison.stage == "step" || comparison.stage == "vertex-gradient";
}

/// Pictures or gradients a second against error.
[[nodiscard]] Panel panel_of(const Comparison& comparison) {
  Panel panel{comparison.case_name, thread_title(comparison.threads)};
  panel.is_speed_logarithmic = is_gradient(comparison);
  for (const Contestant& contestant : comparison.contestants) {
    const Result& result = contestant.result;
    if (!result.seconds || !result.error) continue;
    panel.points.push_back(point_of(result, 1e-6, 1 / *result.seconds));
    std::string& label = panel.points.back().label;
    label = std::regex_replace(label, std::regex("_(integral|only|mesh_renderer)-"), " ");
  }
  return panel;
}

/// All threads and stages of one picture, so that its reference is made once.
void compare(const Scene& scene, double distance, std::size_t size, const Options& options,
             const Folders& folders, std::vector<Comparison>& comparisons) {
  References references;
  for (const std::string& stage : stages) {
    if (!options.takes(case_name_of(stage, distance, size))) continue;
    for (const int threads : options.threads) {
      Comparison comparison = make_comparison(stage, distance, size, threads);
      measure(comparison, folders, options.mesh, options.schedule, scene, references);
      print(comparison, scene);
      comparisons.push_back(std::move(comparison));
    }
  }
}

void run(Options options) {
  if (!options.mesh.empty() && !fs::exists(options.mesh)) {
    std::cout << "there is no " << options.mesh << ": a procedural car takes its place\n";
    options.mesh.clear();
  }
  if (!options.mesh.empty()) options.mesh = fs::absolute(options.mesh);
  const Folders folders = make_folders("renderer", options.output);
  std::vector<Comparison> comparisons;
  for (const double distance : options.distances) {
    const Scene scene = make_scene(options.mesh, distance);
    for (const std::size_t size : options.sizes)
      compare(scene, distance, size, options, folders, comparisons);
  }
  std::vector<Result> results;
  std::vector<Panel> pictures, gradients;
  for (const Comparison& comparison : comparisons) {
    add_results(comparison.contestants, results);
    add_working_memory(comparison, results);
    Panel panel = panel_of(comparison);
    if (panel.points.size() < 2) continue;
    if (!is_gradient(comparison))
      pictures.push_back(std::move(panel));
    else if (comparison.threads == options.threads.front())
      gradients.push_back(std::move(panel));
  }
  write_results(folders, "renderer", "Renderers: pictures a second against error", results, pictures,
                2 * options.threads.size());
  write_figure_beside(folders, "renderer-gradients",
                      "Gradients a second against error, by coverage rate and model", gradients,
                      options.sizes.size() + 1);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = tapestry::shell::command_line(
      "Times renderers, ours and those of other libraries in turn, on a car from three sides. The error is "
      "the share of samples that show another face than a reference in double precision (visibility), "
      "or the relative distance: from the means of 8 x 8 samples a pixel (frame), from the gradient to one "
      "colour a face of 16 x 16 (texture-backward, step), from central differences of such pictures along "
      "eight motions, up to 256 pixels (vertex-gradient). Writes renderer.csv, renderer.svg and "
      "renderer-gradients.svg.");
  benchmarks::Options options;
  benchmarks::add_threads_option(app, options.threads);
  auto* distances =
      app.add_option("--distances", options.distances, "Of the camera")->check(CLI::Range(1.5, 1000.0));
  auto* sizes =
      app.add_option("--sizes", options.sizes, "Of the picture in pixels")->check(CLI::Range(1, 4096));
  app.add_option("--mesh", options.mesh, "The car, an OBJ file; a procedural one if it does not exist");
  options.schedule = {5, 0.1};
  benchmarks::add_driver_options(app, options, "Distance 5 at 256 and 640 pixels only, 3 rounds of 0.05 s",
                                 {3, 0.05});
  return benchmarks::run_driver(app, argc, argv, [&] {
    if (options.is_quick && distances->count() == 0) options.distances = {5};
    if (options.is_quick && sizes->count() == 0) options.sizes = {256, 640};
    benchmarks::run(options);
  });
}
