#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/core/platform.hpp>

namespace tapestry::shell {
/// Output of a program. With --quiet: results, warnings and errors. By default also progress and the names of
/// written files. With --verbose every step, and at the end time and memory.
enum class Verbosity { quiet, usual, verbose };

/// Verbosity of this process, set by the command line before anything is printed.
inline Verbosity& verbosity() {
  static Verbosity chosen = Verbosity::usual;
  return chosen;
}

inline void add_verbosity_options(CLI::App& app) {
  auto* const quiet = app.add_flag_callback(
      "--quiet", [] { verbosity() = Verbosity::quiet; }, "print results, warnings and errors only");
  app.add_flag_callback(
         "--verbose", [] { verbosity() = Verbosity::verbose; },
         "print every step of the way on a line of its own, and at the end time and memory")
      ->excludes(quiet);
}

/// A message for the terminal: one line, shortened and without control characters.
inline std::string for_terminal(std::string_view message) { return printable(shortened(message)); }

/// Like for_terminal(), for a text of several lines.
inline std::string lines_for_terminal(std::string_view text) {
  std::string lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines += printable(text.substr(0, end));
    if (end < text.size()) lines += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// Prints a line about finished work, except with --quiet.
inline void remark(const std::string& line) {
  if (verbosity() != Verbosity::quiet) std::cout << printable(line) << '\n';
}

inline double peak_mib() { return platform::process_cost().peak_mib; }

/// With --verbose prints the process's time and memory on the error stream, how often its threads waited for
/// something, and how many pages of memory the system had to find.
inline void tell_process_cost(double seconds) {
  if (verbosity() != Verbosity::verbose) return;
  const auto cost = platform::process_cost();
  std::fprintf(stderr, "%.2f s, %.0f MiB at most, %ld waits, %ld page faults\n", seconds, cost.peak_mib,
               cost.waits, cost.page_faults);
}
}  // namespace tapestry::shell
