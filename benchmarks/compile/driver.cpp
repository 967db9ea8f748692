// compile: seconds and memory that a compiler takes for programs of ours and of other libraries

#include <sstream>

#include "../support/driver.hpp"
#include "programs.hpp"

namespace tapestry::benchmarks {
namespace {
namespace fs = std::filesystem;

struct Options : DriverOptions {
  std::string compiler = "g++", level = "-O2";
  std::vector<std::string> include_folders{};
};

/// The compiler with the flags that a user's program needs, and no more.
std::vector<std::string> command_for(const Options& options, const fs::path& source) {
  std::vector<std::string> command{options.compiler, "-std=c++20", options.level, "-DTAPESTRY_ASSETS=\"\""};
  for (const auto& folder : options.include_folders) command.push_back("-I" + folder);
  std::istringstream folders(TAPESTRY_INCLUDE_FOLDERS);
  for (std::string folder; std::getline(folders, folder, ':');) command.push_back("-isystem" + folder);
#ifdef TAPESTRY_JPEG
  command.emplace_back("-DTAPESTRY_JPEG");
#endif
  command.push_back(source.string());
  return command;
}

std::size_t line_count(const fs::path& path) {
  std::ifstream file(path);
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) ++count;
  return count;
}

/// A program, and what its compilations took.
struct Row {
  Program program;
  std::size_t preprocessed_lines = 0;
  std::vector<double> seconds{}, processor_seconds{};
  double peak_memory_mib = 0;
};

/// The rows of the programs that the preprocessor accepts. \throws Error for one of ours that it refuses
std::vector<Row> preprocessed(const Options& options, const std::vector<Program>& programs,
                              const fs::path& work) {
  std::vector<Row> rows;
  for (const Program& program : programs) {
    if (!options.takes(program.name) || (options.is_quick && !program.is_quick)) continue;
    auto command = command_for(options, program.source);
    const fs::path output = work / "preprocessed";
    command.insert(command.end(), {"-E", "-P", "-o", output.string()});
    if (Process(command, {}, work / "log").wait().succeeded) {
      rows.push_back({program, line_count(output)});
    } else if (program.is_peer) {
      std::printf("%s: not installed\n", program.name.c_str());
    } else {
      throw Error(ErrorKind::malformed, program.name + ": " + last_line((work / "log").string()));
    }
  }
  return rows;
}

void compile(const Options& options, Row& row, const fs::path& work) {
  auto command = command_for(options, row.program.source);
  command.insert(command.end(), {"-c", "-o", (work / "object").string()});
  const ProcessCost cost = Process(command, {}, work / "log").wait();
  if (!cost.succeeded)
    throw Error(ErrorKind::malformed, row.program.name + ": " + last_line((work / "log").string()));
  row.seconds.push_back(cost.seconds);
  row.processor_seconds.push_back(cost.user_seconds + cost.system_seconds);
  row.peak_memory_mib = std::max(row.peak_memory_mib, cost.peak_memory_mib);
}

void print(const std::vector<Row>& rows) {
  std::printf("\n%-28s %6s %12s %9s %11s %7s %6s\n", "", "lines", "preprocessed", "seconds", "processor s",
              "spread", "MiB");
  for (const Row& row : rows) {
    const Timing seconds = timing_of(row.seconds), processor = timing_of(row.processor_seconds);
    std::printf("%-28s %6zu %12zu %9.2f %11.2f %6.0f%% %6.0f\n", row.program.name.c_str(),
                line_count(row.program.source), row.preprocessed_lines, seconds.median, processor.median,
                100 * processor.spread, row.peak_memory_mib);
  }
}

void run(const Options& options) {
  const Folders folders = make_folders("compile", options.output);
  auto rows = preprocessed(options, all_programs(TAPESTRY_SOURCE, folders.work), folders.work);
  if (rows.empty()) throw Error(ErrorKind::usage, "no case to measure");
  for (int round = 0; round < options.schedule.rounds; ++round)
    for (Row& row : rows) compile(options, row, folders.work);
  print(rows);
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry;
  auto app = shell::command_line(
      "Times a compiler on programs of ours and of other libraries, in turn. Nothing is linked.");
  benchmarks::Options options;
  options.schedule = {3, 0};
  benchmarks::add_driver_options(app, options, "Two programs of ours only", options.schedule);
  app.add_option("--compiler", options.compiler, "The compiler");
  app.add_option("--optimise", options.level, "Its flag of optimisation");
  app.add_option("--include", options.include_folders,
                 "A folder with headers of another library, such as CoDiPack's; may be given again");
  return benchmarks::run_driver(app, argc, argv, [&] { benchmarks::run(options); });
}
