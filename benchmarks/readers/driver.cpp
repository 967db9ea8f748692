// readers: time and memory of every reader of files, for files of 1, 2, 4 and 8 MB of kinds that are bad for
// it
#include <malloc.h>

#include <ctime>
#include <regex>

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

/// The number that a process of its own for tell_memory() prints, or what is put around it.
double told_number(const std::string& before, const std::string& name, const std::string& path,
                   const std::string& behind) {
  const std::string command =
      before + "/proc/" + std::to_string(::getpid()) + "/exe --memory '" + name + "' '" + path + "'" + behind;
  std::FILE* const output = ::popen(command.c_str(), "r");
  double number = 0;
  const bool is_told = output != nullptr && std::fscanf(output, "%lf", &number) == 1;
  if (output == nullptr || ::pclose(output) != 0 || !is_told)
    throw Error(ErrorKind::numeric, command + " ended without an answer");
  return number;
}

double told_memory(const std::string& name, const std::string& path) {
  return told_number("", name, path, "");
}

/// Millions of instructions that valgrind counts.
double counted_instructions(const std::string& name, const std::string& path) {
  return told_number("valgrind --tool=callgrind --callgrind-out-file=/dev/null ", name, path,
                     " 2>&1 >/dev/null | sed -n 's/.*Collected : //p'") /
         1e6;
}

/// Processor time, so that other programs do not count.
double seconds_of(const Kind& kind, const std::string& path, std::string& refusal) {
  const std::clock_t start = std::clock();
  try {
    kind.read(path);
  } catch (const FileError& error) {
    refusal = error.details().what;
  }
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Whether reading takes no more memory than the reader's comment states, of files of three sizes, since
/// lists double; prints the most in sizes of the file, and in shares of what is stated.
bool keeps_to_limit(const Kind& kind) {
  const test::TemporaryFolder folder;
  const double start = told_memory(kind.name, "-");
  constexpr double mebibyte = 1U << 20U;
  double most = 0, share = 0;
  for (const double mb : {.5, .64, .8}) {
    if (mb > static_cast<double>(kind.largest_mb)) continue;
    const std::string path = folder.write("file", kind.make(static_cast<std::size_t>(mb * 1e6)));
    const double bytes = (told_memory(kind.name, path) - start) * mebibyte;
    most = std::max(most, bytes / static_cast<double>(std::filesystem::file_size(path)));
    share = std::max(share, bytes / (kind.most_memory(path) + mebibyte));
  }
  std::printf("%-24s %7.1f %7.2f%s\n", kind.name.c_str(), most, share, share > 1 ? "*" : "");
  std::fflush(stdout);
  return share <= 1;
}

struct Options {
  int rounds = 5;
  bool counts_instructions = false;
};

/// Milliseconds, the least of all turns, or millions of instructions for each file.
std::vector<double> costs(const Kind& kind, const std::vector<std::string>& paths, const Options& options,
                          std::string& refusal) {
  std::vector<double> least(paths.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < options.rounds && !options.counts_instructions; ++round)
    for (std::size_t i = 0; i < paths.size(); ++i)
      least[i] = std::min(least[i], 1e3 * seconds_of(kind, paths[i], refusal));
  if (!options.counts_instructions) return least;
  const double start = counted_instructions(kind.name, "-");
  for (std::size_t i = 0; i < paths.size(); ++i) least[i] = counted_instructions(kind.name, paths[i]) - start;
  return least;
}

/// Prints a row: the costs of each size, the largest of their ratios, and memory in times of the file.
void measure(const Kind& kind, const Options& options) {
  const test::TemporaryFolder folder;
  std::vector<std::string> paths;
  for (const std::size_t mb : sizes_mb)
    if (mb <= kind.largest_mb) paths.push_back(folder.write(std::to_string(mb), kind.make(mb * 1000000)));
  std::string refusal;
  const auto cost = costs(kind, paths, options, refusal);
  std::printf("%-24s", kind.name.c_str());
  for (const double one : cost) std::printf(" %9.2f", one);
  for (std::size_t i = paths.size(); i < sizes_mb.size(); ++i) std::printf(" %9s", "-");
  double most = 0;
  for (std::size_t i = 1; i < cost.size(); ++i) most = std::max(most, cost[i] / cost[i - 1]);
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
  Options options;
  bool has_fresh_pages = false, checks_memory = false;
  std::vector<std::string> memory;
  app.add_option("--case", pattern, "Only kinds whose name this regular expression finds");
  app.add_option("--rounds", options.rounds, "Turns of each size")->check(CLI::Range(1, 1000));
  app.add_flag("--instructions", options.counts_instructions,
               "Count instructions, with valgrind, in place of milliseconds");
  app.add_flag("--fresh-pages", has_fresh_pages,
               "Give large memory back to the system after each turn, whose pages then cost time again");
  app.add_flag("--check-memory", checks_memory,
               "Only compare the memory that files of half a megabyte and more take with what the comments "
               "state, and end "
               "with 1 where it is more");
  app.add_option("--memory", memory,
                 "A kind and a file: only print the memory, in MiB, that reading it takes")
      ->expected(2);
  return shell::run_program(app, argc, argv, [&] {
    if (!memory.empty()) {
      tell_memory(memory[0], memory[1]);
      return 0;
    }
    const std::regex wanted(pattern);
    if (checks_memory) {
      std::printf("%-24s %7s %7s\n", "", "memory", "limit");
      bool all = true;
      for (const Kind& kind : all_kinds())
        if (std::regex_search(kind.name, wanted)) all = keeps_to_limit(kind) && all;
      std::printf(
          "memory: the most, in sizes of the file. limit: in shares of what the comment states; * above "
          "it.\n");
      return all ? 0 : 1;
    }
    if (!has_fresh_pages) {
      mallopt(M_MMAP_THRESHOLD, std::numeric_limits<int>::max());
      mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
    }
    std::printf("%-24s %9s %9s %9s %9s %9s %7s\n",
                options.counts_instructions ? "million instructions" : "milliseconds", "1 MB", "2 MB", "4 MB",
                "8 MB", "doubling", "memory");
    for (const Kind& kind : all_kinds())
      if (std::regex_search(kind.name, wanted)) measure(kind, options);
    std::printf(
        "doubling: the largest ratio of neighbours; * above 2.3. Milliseconds are the least of %d turns. "
        "memory: the most for the largest file, in its sizes.\n",
        options.rounds);
    return 0;
  });
}
