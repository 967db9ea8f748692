// detector: speed and error of YOLO-V3 networks, ours beside oneDNN, libtorch, OpenCV and Darknet
#include <CLI/CLI.hpp>
#include <algorithm>
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
  std::string darknet_cfgs = "/usr/share/darknet/cfg";
  std::string detectors = TAPESTRY_SHARED "/data/detectors";
  std::string cfg{};
  std::string weights{};
  std::size_t size = 416;
  std::string output{};
  Schedule schedule{};
};

/// A network at one size; without weights it gets random ones.
struct Source {
  std::string name;
  fs::path cfg;
  fs::path weights;
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
  const std::regex pattern(options.case_pattern);
  for (const char* task : {"forward", "forward+gradient"}) {
    const std::string name = source.name + "-" + std::to_string(source.size) + " " + task;
    if (std::regex_search(name, pattern)) chosen.push_back(name);
  }
  return chosen;
}

/// Whether the network's files are there; says so if not. Files that the caller named are left to their
/// readers.
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
  Panel panel{comparison.case_name,
              std::to_string(comparison.threads) + (comparison.threads == 1 ? " thread" : " threads")};
  for (const Result& result : comparison.results) {
    if (!result.seconds || !(result.error > 0)) continue;
    const bool peer = is_peer(result.variant);
    panel.points.push_back({peer ? result.variant.substr(5) : result.variant, *result.error,
                            comparison.gflop / *result.seconds, peer});
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

int run(const Options& options) {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path output = options.output.empty() ? programs : fs::path(options.output);
  const Folders folders{programs, output / "detector-files"};
  fs::create_directories(folders.work);
  std::vector<Result> results;
  std::vector<Panel> panels;
  std::size_t columns = 1;
  for (const Source& source : sources(options)) {
    const auto cases = chosen_cases(source, options);
    if (cases.empty() || !is_present(source, options)) continue;
    for (const Comparison& comparison : compare(source, cases, options, folders)) {
      results.insert(results.end(), comparison.results.begin(), comparison.results.end());
      panels.push_back(panel_of(comparison));
    }
    columns = std::max(columns, cases.size() * options.threads.size());
  }
  if (results.empty()) throw Error(ErrorKind::usage, "no case to measure");
  write_csv(output / "detector.csv", results);
  write_figure(output / "detector.svg", "Detectors: GFLOP/s (as if done directly) against error", panels,
               columns);
  std::cout << "\n"
            << fs::proximate(output / "detector.csv").string() << "\n"
            << fs::proximate(output / "detector.svg").string() << "\n";
  return 0;
}

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  CLI::App app(
      "Times detectors, ours and those of other libraries in turn, and compares their answers with "
      "double precision. Writes detector.csv and detector.svg.");
  benchmarks::Options options;
  app.add_flag("--quick", options.is_quick, "yolov3-tiny only, 3 rounds of 0.1 s");
  app.add_option("--case", options.case_pattern, "Only cases whose name this regular expression finds")
      ->check(benchmarks::complaint_about_pattern);
  app.add_option("--threads", options.threads, "Numbers of threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  auto* rounds = app.add_option("--rounds", options.schedule.rounds, "Turns of each variant")
                     ->check(CLI::Range(1, 1000000))
                     ->capture_default_str();
  auto* seconds = app.add_option("--seconds", options.schedule.seconds, "Of a turn, at least")
                      ->check(CLI::Range(0.0, 3600.0))
                      ->capture_default_str();
  app.add_option("--darknet-cfgs", options.darknet_cfgs, "Folder with yolov3.cfg and yolov3-tiny.cfg")
      ->capture_default_str();
  app.add_option("--detectors", options.detectors,
                 "Folder with cfg and weights of the small trained networks");
  app.add_option("--cfg", options.cfg, "Measure this Darknet cfg file instead");
  app.add_option("--weights", options.weights, "Its weights; random ones if not given");
  app.add_option("--size", options.size, "Its input's width and height, in pixels")->capture_default_str();
  app.add_option("--output", options.output, "Folder of the results; the program's own if not given");
  return examples::run_program(app, argc, argv, [&] {
    if (options.is_quick && rounds->count() == 0) options.schedule.rounds = 3;
    if (options.is_quick && seconds->count() == 0) options.schedule.seconds = 0.1;
    std::signal(SIGPIPE, SIG_IGN);
    return benchmarks::run(options);
  });
}
