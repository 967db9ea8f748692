// detector: speed and error of YOLO-V3 networks, ours beside oneDNN, libtorch, OpenCV and Darknet

#include "comparison.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

struct Options : DriverOptions {
  std::vector<int> threads{1, 2};
  std::string darknet_cfgs = "/usr/share/darknet/cfg";
  std::string detectors = TAPESTRY_SHARED "/data/detectors";
  std::string cfg{}, weights{};
  std::size_t size = 416;
};

/// A network at one size; without weights it gets random ones.
struct Source {
  std::string name;
  fs::path cfg, weights;
  std::size_t size;
};

[[nodiscard]] std::vector<Source> sources(const Options& options) {
  if (!options.cfg.empty())
    return {{fs::path(options.cfg).stem(), options.cfg, options.weights, options.size}};
  const fs::path cfgs = options.darknet_cfgs;
  const Source tiny{"yolov3-tiny", cfgs / "yolov3-tiny.cfg", "", 416};
  if (options.is_quick) return {tiny};
  const auto trained = [&](const std::string& name) {
    const fs::path folder = options.detectors;
    return Source{name, folder / (name + ".cfg"), folder / (name + ".weights"), 416};
  };
  return {{"yolov3", cfgs / "yolov3.cfg", "", 416},
          {"yolov3", cfgs / "yolov3.cfg", "", 608},
          tiny,
          trained("yolo-fastest-1.1-xl"),
          trained("mobilenetv2-yolov3-nano")};
}

[[nodiscard]] std::vector<std::string> chosen_cases(const Source& source, const Options& options) {
  std::vector<std::string> chosen;
  for (const char* task : {"forward", "forward+gradient"}) {
    const std::string name = source.name + "-" + std::to_string(source.size) + " " + task;
    if (options.takes(name)) chosen.push_back(name);
  }
  return chosen;
}

/// Whether the network's files are there; prints a message if not. Files that the caller named are left to
/// their readers.
[[nodiscard]] bool is_present(const Source& source, const Options& options) {
  if (!options.cfg.empty()) return true;
  for (const fs::path& path : {source.cfg, source.weights}) {
    if (path.empty() || fs::exists(path)) continue;
    std::cout << "\n"
              << source.name << "-" << source.size << ": skipped, there is no " << path.string() << "\n";
    return false;
  }
  return true;
}

/// Measures everything of a network before the reference takes memory.
[[nodiscard]] std::vector<Comparison> compare(const Source& source, const std::vector<std::string>& cases,
                                              const Options& options, const Folders& folders) {
  const std::string stem = folders.work / (source.name + "-" + std::to_string(source.size));
  const NetworkFiles files = write_network_files(source.cfg, source.weights, source.size, stem);
  const Problem problem = make_problem(files.cfg, source.size);
  std::vector<Comparison> comparisons;
  for (const std::string& case_name : cases) {
    const bool wants_gradient = case_name.find('+') != std::string::npos;
    for (const int threads : options.threads) {
      comparisons.push_back(make_comparison(case_name, wants_gradient, threads, direct_gflop(problem)));
      measure(comparisons.back(), files, source.size, folders, options.schedule);
    }
  }
  Reference reference(problem, files.weights);
  for (Comparison& comparison : comparisons) {
    score(comparison, problem, reference, folders);
    print(comparison);
  }
  return comparisons;
}

[[nodiscard]] Panel panel_of(const Comparison& comparison) {
  Panel panel{comparison.case_name, thread_title(comparison.threads)};
  for (const Contestant& contestant : comparison.contestants)
    if (const Result& result = contestant.result; result.seconds && result.error > 0)
      panel.points.push_back(point_of(result, 0, comparison.gflop / *result.seconds));
  return panel;
}

void run(const Options& options) {
  const Folders folders = make_folders("detector", options.output);
  std::vector<Result> results;
  std::vector<Panel> panels;
  std::size_t columns = 1;
  for (const Source& source : sources(options)) {
    const auto cases = chosen_cases(source, options);
    if (cases.empty() || !is_present(source, options)) continue;
    for (const Comparison& comparison : compare(source, cases, options, folders)) {
      add_results(comparison.contestants, results);
      panels.push_back(panel_of(comparison));
    }
    columns = std::max(columns, cases.size() * options.threads.size());
  }
  write_results(folders, "detector", "Detectors: GFLOP/s (as if done directly) against error", results,
                panels, columns);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = tapestry::shell::command_line(
      "Times detectors, ours and those of other libraries in turn, and compares their answers with "
      "double precision. Writes detector.csv and detector.svg.");
  benchmarks::Options options;
  benchmarks::add_threads_option(app, options.threads);
  app.add_option("--darknet-cfgs", options.darknet_cfgs, "Folder with yolov3.cfg and yolov3-tiny.cfg");
  app.add_option("--detectors", options.detectors,
                 "Folder with cfg and weights of the small trained networks");
  app.add_option("--cfg", options.cfg, "Measure this Darknet cfg file instead");
  app.add_option("--weights", options.weights, "Its weights; random ones if not given");
  app.add_option("--size", options.size, "Its input's width and height, in pixels");
  benchmarks::add_driver_options(app, options, "yolov3-tiny only, 3 rounds of 0.1 s", {3, 0.1});
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options); });
}
