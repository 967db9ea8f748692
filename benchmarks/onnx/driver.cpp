// onnx: speed and error of networks from ONNX files, ours beside ONNX Runtime and OpenCV

#include "../support/driver.hpp"
#include "../support/relative_distance.hpp"
#include "graph_run.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

struct Options : DriverOptions {
  std::vector<int> threads{1, 2};
  std::vector<std::string> models{TAPESTRY_SHARED "/data/detectors/yolox_nano.onnx",
                                  TAPESTRY_SHARED "/data/detectors/nanodet_m.onnx"};
  std::size_t size = 416;
  std::string onnxruntime{};
};

/// A program, what it is started with, and what it computes.
struct Variant {
  std::string name;
  bool wants_gradient;
  std::vector<std::string> command;
};

/// Full path of a program that the shell would find, or its name.
[[nodiscard]] std::string found_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  return name;
}

[[nodiscard]] std::vector<Variant> variants(const Options& options, const Folders& folders) {
  std::vector<Variant> all{{"forward", false, {folders.programs / "onnx_tapestry"}},
                           {"forward+gradient", true, {folders.programs / "onnx_tapestry"}},
                           {"peer:OpenCV", false, {folders.programs / "onnx_opencv_dnn"}}};
  if (!options.onnxruntime.empty())
    all.push_back({"peer:ONNX Runtime",
                   false,
                   {found_program("node"), TAPESTRY_SOURCE "/benchmarks/onnx/peers/onnxruntime_worker.mjs",
                    fs::absolute(options.onnxruntime)}});
  return all;
}

/// One network on so many threads.
struct Comparison {
  std::string case_name;
  int threads;
  std::vector<Contestant> contestants{};
};

[[nodiscard]] std::string answer_path(const Folders& folders, int threads, std::size_t rival) {
  return folders.work / ("answer-" + std::to_string(threads) + "-" + std::to_string(rival));
}

[[nodiscard]] Comparison measure(const std::vector<Variant>& rivals, const NetworkOptions& problem,
                                 const std::string& case_name, const Folders& folders,
                                 const Schedule& schedule) {
  std::cerr << case_name << ", threads: " << problem.threads << std::endl;
  Comparison comparison{case_name, problem.threads};
  for (const Variant& rival : rivals) {
    std::vector<std::string> command = rival.command;
    command.insert(command.end(),
                   {"--model", problem.model, "--input", problem.input, "--size",
                    std::to_string(problem.size), "--threads", std::to_string(problem.threads)});
    if (rival.wants_gradient) command.emplace_back("--gradient");
    comparison.contestants.push_back({{case_name, rival.name, problem.threads}});
    comparison.contestants.back().start(command, {"OMP_NUM_THREADS=" + std::to_string(problem.threads)},
                                        folders.work);
  }
  run_rounds(comparison.contestants, schedule);
  for (std::size_t i = 0; i < rivals.size(); ++i)
    comparison.contestants[i].finish(answer_path(folders, problem.threads, i), [] {});
  return comparison;
}

/// Fills in times and errors. A gradient's error holds what other sides of kinks and other maxima do to it,
/// too.
void score(Comparison& comparison, const std::vector<Variant>& rivals, GraphRun<double>& reference,
           const Folders& folders) {
  for (std::size_t i = 0; i < rivals.size(); ++i)
    comparison.contestants[i].attempt([&] {
      const std::string path = answer_path(folders, comparison.threads, i);
      const auto answer = read_numbers<float>(path);
      fs::remove(path);
      const auto expected = rivals[i].wants_gradient ? reference.gradient() : reference.outputs();
      comparison.contestants[i].conclude(relative_distance(answer, expected), 1e-2);
    });
}

void print(const Comparison& comparison) {
  std::printf("\n%s, %s\n", comparison.case_name.c_str(), thread_title(comparison.threads).c_str());
  std::printf("  %-20s %9s %8s %9s %6s  %s\n", "", "ms", "spread", "error", "MiB", "over our forward");
  const Result& own = comparison.contestants.front().result;
  for (const Contestant& contestant : comparison.contestants) {
    const Result& result = contestant.result;
    if (contestant.print(result.variant, 20))
      std::printf(" %9.3f %6.1f %% %9.1e %6.0f  %s\n", 1e3 * *result.seconds, 100 * *result.spread,
                  *result.error, *result.memory_mib,
                  own.seconds ? formatted("%.3f", *result.seconds / *own.seconds).c_str() : "");
  }
  std::fflush(stdout);
}

void run(const Options& options) {
  const Folders folders = make_folders("onnx", options.output);
  const auto rivals = variants(options, folders);
  std::vector<Result> results;
  std::vector<Panel> panels;
  NetworkOptions problem;
  problem.size = options.size;
  problem.input = folders.work / "picture";
  std::vector<float> picture(3 * options.size * options.size);
  Random random(1);
  for (float& value : picture) value = static_cast<float>(255 * random.uniform());
  write_numbers(problem.input, picture);
  for (const std::string& model : options.models) {
    const std::string name = fs::path(model).stem().string() + "-" + std::to_string(options.size);
    if (!options.takes(name)) continue;
    if (!fs::exists(model)) {
      std::cout << "\n" << name << ": skipped, there is no " << model << "\n";
      continue;
    }
    problem.model = fs::absolute(model);
    std::vector<Comparison> comparisons;
    for (const int threads : options.threads) {
      problem.threads = threads;
      comparisons.push_back(measure(rivals, problem, name, folders, options.schedule));
    }
    GraphRun<double> reference(problem, false);  // the file's own nodes, nothing fused
    reference.forward(nn::Mode::input_gradient);
    reference.adjoint();
    for (Comparison& comparison : comparisons) {
      score(comparison, rivals, reference, folders);
      print(comparison);
      Panel panel{name, thread_title(comparison.threads)};
      for (std::size_t i = 0; i < rivals.size(); ++i) {
        const Result& result = comparison.contestants[i].result;
        if (!result.seconds || rivals[i].wants_gradient) continue;  // more work than a forward pass
        panel.points.push_back(point_of(result, 1e-9, 1 / *result.seconds));
      }
      panels.push_back(panel);
      add_results(comparison.contestants, results);
    }
  }
  write_results(folders, "onnx", "ONNX networks, forward: pictures a second against error", results, panels,
                options.threads.size());
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = tapestry::shell::command_line(
      "Times networks from ONNX files, ours and those of other libraries in turn, and compares their "
      "answers with double precision. Writes onnx.csv and onnx.svg.");
  benchmarks::Options options;
  benchmarks::add_threads_option(app, options.threads);
  app.add_option("--model", options.models, "ONNX files of one input, a picture [1, 3, size, size]");
  app.add_option("--size", options.size, "Width and height of the picture, in pixels");
  app.add_option("--onnxruntime", options.onnxruntime,
                 "Folder node_modules with onnxruntime-node, made by `npm install onnxruntime-node`; without "
                 "it, ONNX Runtime is left out");
  benchmarks::add_driver_options(app, options, "3 rounds of 0.1 s", {3, 0.1});
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options); });
}
