#pragma once
#include <regex>
#include "../../examples/programs/shell/program.hpp"
#include "figure.hpp"
#include "numbers_file.hpp"
#include "rounds.hpp"

namespace tapestry::benchmarks {
/// Options of every driver.
struct DriverOptions {
  bool is_quick = false;
  std::string case_pattern{}, output{};
  Schedule schedule{};

  [[nodiscard]] bool takes(const std::string& name) const {
    return std::regex_search(name, std::regex(case_pattern));
  }
};

[[nodiscard]] inline std::string complaint_about_pattern(const std::string& text) {
  try {
    const std::regex pattern(text);
    return {};
  } catch (const std::regex_error& error) {
    return "'" + text + "' is not a regular expression: " + error.what();
  }
}

inline void add_threads_option(CLI::App& app, std::vector<int>& threads) {
  app.add_option("--threads", threads, "Numbers of threads")->check(CLI::Range(1, 1024));
}

/// Adds the options that every driver has. By --quick, `quick` replaces what of the schedule was not given. A
/// turn of no seconds is a whole run of a program, which no option makes longer.
/// \param quick_help  what is measured by --quick
inline void add_driver_options(CLI::App& app, DriverOptions& options, const std::string& quick_help,
                               const Schedule& quick) {
  app.add_flag("--quick", options.is_quick, quick_help);
  app.add_option("--case", options.case_pattern, "Only cases whose name this regular expression finds")
      ->check(complaint_about_pattern);
  auto* rounds = app.add_option("--rounds", options.schedule.rounds, "Turns of each variant")
                     ->check(CLI::Range(1, 1000000));
  auto* seconds = options.schedule.seconds == 0
                      ? nullptr
                      : app.add_option("--seconds", options.schedule.seconds, "Of a turn, at least")
                            ->check(CLI::Range(0.0, 3600.0));
  app.add_option("--output", options.output, "Folder of the results; the program's own if not given");
  app.callback([=, &options] {
    if (!options.is_quick) return;
    if (rounds->count() == 0) options.schedule.rounds = quick.rounds;
    if (seconds != nullptr && seconds->count() == 0) options.schedule.seconds = quick.seconds;
  });
}

/// Where programs are found, results are written and files are kept meanwhile; absolute.
struct Folders {
  std::filesystem::path programs, output, work;
};

/// Makes the folders of the benchmark `name`.
[[nodiscard]] inline Folders make_folders(const std::string& name, const std::string& output) {
  Folders folders;
  folders.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  folders.output = output.empty() ? folders.programs : std::filesystem::absolute(output);
  folders.work = folders.output / (name + "-files");
  std::filesystem::create_directories(folders.work);
  return folders;
}

[[nodiscard]] inline std::string thread_title(int threads) {
  return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

/// Adds the results of contestants to those of all cases.
inline void add_results(const std::vector<Contestant>& contestants, std::vector<Result>& results) {
  for (const Contestant& contestant : contestants) results.push_back(contestant.result);
}

/// A result in a figure.
/// \param least  where an error of 0 stands on the logarithmic axis
[[nodiscard]] inline Point point_of(const Result& result, double least, double speed) {
  const bool peer = is_peer(result.variant);
  return {peer ? result.variant.substr(5) : result.variant, std::max(*result.error, least), speed, peer};
}

/// Writes a figure, unless it would be empty, and prints its path.
inline void write_figure_beside(const Folders& folders, const std::string& name, const std::string& title,
                                const std::vector<Panel>& panels, std::size_t columns) {
  if (panels.empty()) return;
  const std::filesystem::path svg = folders.output / (name + ".svg");
  write_figure(svg, title, panels, columns);
  std::cout << std::filesystem::proximate(svg).string() << "\n";
}

/// Writes table and figure and prints their paths.
/// \throws Error if there are no results
inline void write_results(const Folders& folders, const std::string& name, const std::string& title,
                          const std::vector<Result>& results, const std::vector<Panel>& panels,
                          std::size_t columns) {
  if (results.empty()) throw Error(ErrorKind::usage, "no case to measure");
  const std::filesystem::path csv = folders.output / (name + ".csv");
  write_csv(csv, results);
  std::cout << "\n" << std::filesystem::proximate(csv).string() << "\n";
  write_figure_beside(folders, name, title, panels, columns);
}

/// The rest of a driver's main function. A worker that ends early is an answer, not a signal.
template <class Run>
int run_driver(CLI::App& app, int argc, char** argv, Run run) {
  return shell::run_program(app, argc, argv, [&] {
    std::signal(SIGPIPE, SIG_IGN);
    run();
    return 0;
  });
}
}  // namespace tapestry::benchmarks
