// readers: time and memory of every reader of files, for files of 1, 2, 4 and 8 MB of kinds that are bad for
// it
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "../../examples/programs/shell/program.hpp"
#include "../../tests/support/temporary_folder.hpp"
#include "../support/serve.hpp"
#include "kind.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::benchmarks;

constexpr std::array<std::size_t, 4> sizes_mb{1, 2, 4, 8};

std::vector<Kind> all_kinds() {
  std::vector<Kind> all;
  for (const auto& kinds : {picture_kinds(), array_kinds(), mesh_kinds(), detector_kinds(), text_kinds()})
    all.insert(all.end(), kinds.begin(), kinds.end());
  return all;
}

const Kind& kind_by_name(const std::vector<Kind>& kinds, const std::string& name) {
  const auto found = std::ranges::find(kinds, name, &Kind::name);
  if (found == kinds.end()) throw Error(ErrorKind::usage, "no kind " + name);
  return *found;
}

/// Reads a file once, or none for "-", and prints the most memory that it took, in MiB.
void tell_memory(const std::string& name, const std::string& path) {
  try {
    if (path != "-") kind_by_name(all_kinds(), name).read(path);
  } catch (const FileError&) {
  }
  std::printf("%.3f\n", peak_memory_mib());
}

/// What a process of its own prints for tell_memory().
double told_memory(const std::string& name, const std::string& path) {
  const std::string command =
      std::string("/proc/") + std::to_string(::getpid()) + "/exe --memory '" + name + "' '" + path + "'";
  std::FILE* const output = ::popen(command.c_str(), "r");
  double mib = 0;
  const bool is_told = output != nullptr && std::fscanf(output, "%lf", &mib) == 1;
  if (output == nullptr || ::pclose(output) != 0 || !is_told)
    throw Error(ErrorKind::numeric, "the process that reads " + name + " ended without an answer");
  return mib;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Of the processor: what else runs does not count.
double seconds_of(const Kind& kind, const std::string& path, std::string& refusal) {
  const std::clock_t start = std::clock();
  try {
    kind.read(path);
  } catch (const FileError& error) {
    refusal = error.details().what;
  }
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Prints a row: milliseconds of each size, the largest of their ratios, and memory in times of the file.
void measure(const Kind& kind, int rounds) {
  const test::TemporaryFolder folder;
  std::vector<std::string> paths;
  for (const std::size_t mb : sizes_mb)
    if (mb <= kind.largest_mb) paths.push_back(folder.write(std::to_string(mb), kind.make(mb * 1000000)));
  std::vector<std::vector<double>> seconds(paths.size());
  std::string refusal;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < paths.size(); ++i) seconds[i].push_back(seconds_of(kind, paths[i], refusal));
  std::printf("%-24s", kind.name.c_str());
  for (const auto& times : seconds) std::printf(" %9.2f", 1e3 * median(times));
  for (std::size_t i = paths.size(); i < sizes_mb.size(); ++i) std::printf(" %9s", "-");
  double most = 0;
  for (std::size_t i = 1; i < paths.size(); ++i) {
    std::vector<double> ratios;
    for (std::size_t round = 0; round < seconds[i].size(); ++round)
      ratios.push_back(seconds[i][round] / seconds[i - 1][round]);
    most = std::max(most, median(ratios));
  }
  const double mib = told_memory(kind.name, paths.back()) - told_memory(kind.name, "-");
  const double file_mib = static_cast<double>(std::filesystem::file_size(paths.back())) / (1U << 20U);
  std::printf(" %8.2f%s %7.1f  %s\n", most, most > 2.3 ? "*" : " ", mib / file_mib,
              refusal.substr(0, 40).c_str());
  std::fflush(stdout);
}
}  // namespace

int main(int argc, char** argv) {
  auto app =
      shell::command_line("Times every reader on files of 1, 2, 4 and 8 MB of kinds that are bad for it.");
  std::string pattern;
  int rounds = 5;
  std::vector<std::string> memory;
  app.add_option("--case", pattern, "Only kinds whose name this regular expression finds");
  app.add_option("--rounds", rounds, "Turns of each size")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--memory", memory,
                 "A kind and a file: only print the memory, in MiB, that reading it takes")
      ->expected(2);
  return shell::run_program(app, argc, argv, [&] {
    if (!memory.empty()) {
      tell_memory(memory[0], memory[1]);
      return 0;
    }
    std::printf("%-24s %9s %9s %9s %9s %9s %7s\n", "milliseconds", "1 MB", "2 MB", "4 MB", "8 MB", "doubling",
                "memory");
    const std::regex wanted(pattern);
    for (const Kind& kind : all_kinds())
      if (std::regex_search(kind.name, wanted)) measure(kind, rounds);
    std::printf(
        "doubling: the largest ratio of neighbours, medians of %d turns; * above 2.3. memory: the most for "
        "the "
        "largest file, in its sizes.\n",
        rounds);
    return 0;
  });
}
