// renderer: speed and error of visibility, frames and texture gradients of a car, ours beside Embree and
// llvmpipe
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <regex>
#include <string>
#include <vector>

#include "../../examples/support/program.hpp"
#include "../support/figure.hpp"
#include "comparison.hpp"

namespace tapestry::benchmarks {
namespace {

namespace fs = std::filesystem;

struct Options {
  bool is_quick = false;
  std::string case_pattern{};
  std::vector<int> threads{1, 2};
  std::vector<double> distances{1.5, 5, 20};
  std::vector<std::size_t> sizes{256, 640, 1024};
  std::string mesh = TAPESTRY_SHARED "/data/mesh/audi_et_te.obj";
  std::string output{};
  Schedule schedule{};
};

/// Frames a second against error.
[[nodiscard]] Panel panel_of(const Comparison& comparison) {
  Panel panel{comparison.case_name,
              std::to_string(comparison.threads) + (comparison.threads == 1 ? " thread" : " threads")};
  for (const Result& result : comparison.results) {
    if (!result.seconds || !result.error) continue;
    const bool peer = is_peer(result.variant);
    constexpr double least = 1e-6;  // the axis is logarithmic
    panel.points.push_back({peer ? result.variant.substr(5) : result.variant, std::max(*result.error, least),
                            1 / *result.seconds, peer});
  }
  return panel;
}

[[nodiscard]] std::string complaint_about_pattern(const std::string& text) {
  try {
    const std::regex pattern(text);
    return {};
  } catch (const std::regex_error& error) {
    return "'" + text + "' is not a regular expression: " + error.what();
  }
}

/// All threads and stages of one picture, so that its reference is made once.
void compare(const Scene& scene, double distance, std::size_t size, const Options& options,
             const Folders& folders, std::vector<Comparison>& comparisons) {
  const std::regex pattern(options.case_pattern);
  References references;
  for (const std::string& stage : stages) {
    if (!std::regex_search(case_name_of(stage, distance, size), pattern)) continue;
    for (const int threads : options.threads) {
      Comparison comparison = make_comparison(stage, distance, size, threads);
      measure(comparison, folders, options.schedule, scene, references);
      print(comparison);
      comparisons.push_back(std::move(comparison));
    }
  }
}

int run(Options options) {
  if (!options.mesh.empty() && !fs::exists(options.mesh)) {
    std::cout << "there is no " << options.mesh << ": a procedural car takes its place\n";
    options.mesh.clear();
  }
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path output = options.output.empty() ? programs : fs::path(options.output);
  const Folders folders{programs, output / "renderer-files", options.mesh};
  fs::create_directories(folders.work);
  std::vector<Comparison> comparisons;
  for (const double distance : options.distances) {
    const Scene scene = make_scene(options.mesh, distance);
    for (const std::size_t size : options.sizes)
      compare(scene, distance, size, options, folders, comparisons);
  }
  if (comparisons.empty()) throw Error(ErrorKind::usage, "no case to measure");
  std::vector<Result> results;
  std::vector<Panel> panels;
  for (const Comparison& comparison : comparisons) {
    results.insert(results.end(), comparison.results.begin(), comparison.results.end());
    Panel panel = panel_of(comparison);
    if (panel.points.size() > 1) panels.push_back(std::move(panel));
  }
  write_csv(output / "renderer.csv", results);
  std::cout << "\n" << fs::proximate(output / "renderer.csv").string() << "\n";
  if (panels.empty()) return 0;
  write_figure(output / "renderer.svg", "Renderers: pictures a second against error", panels,
               2 * options.threads.size());
  std::cout << fs::proximate(output / "renderer.svg").string() << "\n";
  return 0;
}

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  CLI::App app(
      "Times renderers, ours and those of other libraries in turn, on a car from three sides. The error is "
      "the share of samples that show another face than a reference in double precision (visibility), "
      "or the relative distance from its means over 8 x 8 samples a pixel: of the picture (frame), of the "
      "gradient to one colour a face (texture-backward). Writes renderer.csv and renderer.svg.");
  benchmarks::Options options;
  app.add_flag("--quick", options.is_quick, "Distance 5 at 256 and 640 pixels only, 3 rounds of 0.05 s");
  app.add_option("--case", options.case_pattern, "Only cases whose name this regular expression finds")
      ->check(benchmarks::complaint_about_pattern);
  app.add_option("--threads", options.threads, "Numbers of threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  auto* distances = app.add_option("--distances", options.distances, "Of the camera")
                        ->check(CLI::Range(1.5, 1000.0))
                        ->capture_default_str();
  auto* sizes = app.add_option("--sizes", options.sizes, "Of the picture in pixels")
                    ->check(CLI::Range(1, 4096))
                    ->capture_default_str();
  auto* rounds = app.add_option("--rounds", options.schedule.rounds, "Turns of each variant")
                     ->check(CLI::Range(1, 1000000))
                     ->capture_default_str();
  auto* seconds = app.add_option("--seconds", options.schedule.seconds, "Of a turn, at least")
                      ->check(CLI::Range(0.0, 3600.0))
                      ->capture_default_str();
  app.add_option("--mesh", options.mesh, "The car, an OBJ file; a procedural one if it does not exist");
  app.add_option("--output", options.output, "Folder of the results; the program's own if not given");
  options.schedule = {5, 0.1};
  return examples::run_program(app, argc, argv, [&] {
    if (options.is_quick && rounds->count() == 0) options.schedule.rounds = 3;
    if (options.is_quick && seconds->count() == 0) options.schedule.seconds = 0.05;
    if (options.is_quick && distances->count() == 0) options.distances = {5};
    if (options.is_quick && sizes->count() == 0) options.sizes = {256, 640};
    std::signal(SIGPIPE, SIG_IGN);
    return benchmarks::run(options);
  });
}
