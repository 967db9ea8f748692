// job: whole runs of `camouflage` as users start it, on one thread and on more, beside as many runs of one
// thread at once

#include <map>

#include "../support/driver.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

struct Options : DriverOptions {
  std::vector<int> threads{};
  std::string against{};
  std::string cfg{}, weights{};
  int scenes = 40;
  int epochs = 0;  ///< 0: each case's own
};

/// A detector that the paint is made against.
struct Case {
  std::string name;
  std::vector<std::string> arguments;  ///< of camouflage
  int epochs;
};

[[nodiscard]] std::vector<Case> cases_of(const Options& options) {
  std::vector<Case> cases;
  if (!options.weights.empty()) {
    Case own{fs::path(options.weights).stem(), {"--weights", options.weights}, 1};
    if (!options.cfg.empty()) own.arguments.insert(own.arguments.end(), {"--cfg", options.cfg});
    return {own};
  }
  cases.push_back({"bundled", {}, options.is_quick ? 4 : 60});
  const fs::path nano = fs::path(TAPESTRY_SHARED) / "data/detectors/yolox_nano.onnx";
  if (!options.is_quick && fs::exists(nano)) cases.push_back({"yolox_nano", {"--weights", nano.string()}, 4});
  std::erase_if(cases, [&](const Case& one) { return !options.takes(one.name); });
  return cases;
}

/// Runs of one program at once.
struct Variant {
  std::string name, program;
  int threads = 1;  ///< of each
  int processes = 1;
};

[[nodiscard]] std::vector<Variant> variants_of(const Options& options, const std::string& program) {
  std::vector<Variant> variants;
  for (const int threads : options.threads) {
    variants.push_back({"threads", program, threads, 1});
    if (threads > 1) variants.push_back({"processes", program, 1, threads});
    if (!options.against.empty()) variants.push_back({"against", options.against, threads, 1});
  }
  return variants;
}

/// What the runs of a variant gave, a value a round.
struct Measured {
  std::vector<double> rates{};  ///< images a second of the steps, of all processes together
  std::vector<double> seconds{}, kernel_shares{}, switches{};
  double peak_memory_mib = 0;
  std::string texture{};  ///< bytes of the first run's file
};

/// The last rate that a run printed. \throws Error with its last line if there is none
[[nodiscard]] double rate_in(const fs::path& log) {
  const std::string text = io::read_text_file(log.string());
  const std::regex rate("([0-9.]+) images/s");
  std::string last;
  for (std::sregex_iterator found(text.begin(), text.end(), rate), end; found != end; ++found)
    last = (*found)[1];
  if (last.empty()) throw Error(ErrorKind::malformed, "no images/s in " + log.string());
  return std::stod(last);
}

void measure(const Variant& variant, const Case& one, const Options& options, const fs::path& work,
             Measured& measured) {
  std::vector<Process> processes;
  std::vector<fs::path> folders;
  for (int i = 0; i < variant.processes; ++i) {
    folders.push_back(work / ("run-" + std::to_string(i)));
    fs::remove_all(folders.back());
    std::vector<std::string> command{variant.program,
                                     "--output",
                                     folders.back().string(),
                                     "--scenes",
                                     std::to_string(options.scenes),
                                     "--epochs",
                                     std::to_string(options.epochs > 0 ? options.epochs : one.epochs)};
    command.insert(command.end(), one.arguments.begin(), one.arguments.end());
    processes.emplace_back(command, std::vector{"TAPESTRY_THREADS=" + std::to_string(variant.threads)},
                           work / ("log-" + std::to_string(i)));
  }
  double rate = 0, seconds = 0, memory = 0, system = 0, processor = 0, switches = 0;
  for (std::size_t i = 0; i < processes.size(); ++i) {
    const ProcessCost cost = processes[i].wait();
    const fs::path log = work / ("log-" + std::to_string(i));
    if (!cost.succeeded) throw Error(ErrorKind::malformed, variant.program + " failed; see " + log.string());
    rate += rate_in(log);
    seconds = std::max(seconds, cost.seconds);
    memory += cost.peak_memory_mib;
    system += cost.system_seconds;
    processor += cost.user_seconds + cost.system_seconds;
    switches += cost.switches;
  }
  measured.rates.push_back(rate);
  measured.seconds.push_back(seconds);
  measured.kernel_shares.push_back(system / processor);
  measured.switches.push_back(switches);
  measured.peak_memory_mib = std::max(measured.peak_memory_mib, memory);
  if (measured.texture.empty())
    measured.texture = io::read_text_file((folders.front() / "texture.npz").string());
}

[[nodiscard]] double median_of(std::vector<double> values) { return timing_of(std::move(values)).median; }

/// Prints a case's table. The error of a variant is 0 where its texture has the bytes of the first one's.
void report(const Case& one, const std::vector<Variant>& variants, const std::vector<Measured>& all,
            std::vector<Result>& results) {
  std::printf("\n%-12s %-10s %7s %9s %9s %8s %9s %9s %6s\n", one.name.c_str(), "", "images/s", "over 1",
              "of procs", "whole s", "kernel %", "switches", "MiB");
  const double alone = median_of(all.front().rates);
  std::map<int, double> of_processes;
  for (std::size_t v = 0; v < variants.size(); ++v)
    if (variants[v].processes > 1) of_processes[variants[v].processes] = median_of(all[v].rates);
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const auto& [name, program, threads, processes] = variants[v];
    const int count = threads * processes;
    const double rate = median_of(all[v].rates);
    const bool is_equal = all[v].texture == all.front().texture;
    std::printf("%-12s %8d %7.1f %9.2f %9s %8.1f %9.1f %9.0f %6.0f%s\n", name.c_str(), count, rate,
                rate / alone,
                processes == 1 && of_processes.count(count) > 0
                    ? formatted("%.2f", rate / of_processes[count]).c_str()
                    : "",
                median_of(all[v].seconds), 100 * median_of(all[v].kernel_shares), median_of(all[v].switches),
                all[v].peak_memory_mib, is_equal ? "" : "  other bits");
    std::vector<double> seconds_an_image;
    for (const double images : all[v].rates) seconds_an_image.push_back(1 / images);
    const Timing timing = timing_of(seconds_an_image);
    results.push_back({one.name, name, count, timing.median, is_equal ? std::optional(0.0) : std::nullopt,
                       all[v].peak_memory_mib, timing.spread});
  }
}

void run(const Options& options) {
  const Folders folders = make_folders("job", options.output);
  const fs::path program = folders.programs.parent_path() / "examples" / "camouflage";
  if (!fs::exists(program)) throw Error(ErrorKind::usage, program.string() + " was not built");
  std::vector<Result> results;
  for (const Case& one : cases_of(options)) {
    const auto variants = variants_of(options, program.string());
    std::vector<Measured> all(variants.size());
    for (int round = 0; round < options.schedule.rounds; ++round)
      for (std::size_t v = 0; v < variants.size(); ++v)
        measure(variants[v], one, options, folders.work, all[v]);
    report(one, variants, all, results);
  }
  write_results(folders, "job", "", results, {}, 0);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = shell::command_line(
      "Times whole runs of camouflage in turn: one of some threads, and as many of one thread at once, which "
      "is what "
      "the machine gives. Prints images a second of the steps, that over one thread and over the processes, "
      "seconds of "
      "the whole run, the kernel's share of the processor, times that a thread waited, and memory. Writes "
      "job.csv.");
  benchmarks::Options options;
  options.schedule = {5, 0};
  const auto all = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  for (int threads = 1; threads < all; threads *= 2) options.threads.push_back(threads);
  options.threads.push_back(all);
  benchmarks::add_threads_option(app, options.threads);
  app.add_option("--against", options.against, "The camouflage program of another build, measured in turn");
  app.add_option("--weights", options.weights, "Measure this detector instead, .weights or .onnx")
      ->check(CLI::ExistingFile);
  app.add_option("--cfg", options.cfg, "Its cfg")->check(CLI::ExistingFile);
  app.add_option("--scenes", options.scenes, "Street scenes that are drawn")->check(CLI::Range(4, 100000));
  app.add_option("--epochs", options.epochs, "Times that each is trained on; left out, each detector's own")
      ->check(CLI::Range(1, 100000));
  benchmarks::add_driver_options(app, options, "The bundled detector only, 4 epochs, once", {1, 0});
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options); });
}
