#pragma once
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <string>
#include <tapestry/core/in_quotes.hpp>

namespace tapestry::shell {

/// What a program tells: with --quiet its results, warnings and errors; usually also how far it is and what
/// it has written; with --verbose every step of the way, and at the end what it cost.
enum class Verbosity { quiet, usual, verbose };

/// That of this process, which the command line sets before anything is told.
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

/// Prints a line on what was done, not with --quiet.
inline void remark(const std::string& line) {
  if (verbosity() != Verbosity::quiet) std::cout << printable(line) << '\n';
}

/// Most memory the process has held so far, MiB.
inline double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// With --verbose prints on the error stream what the process took.
inline void tell_process_cost(double seconds) {
  if (verbosity() != Verbosity::verbose) return;
  std::fprintf(stderr, "%.2f s, %.0f MiB at most\n", seconds, peak_mib());
}

}  // namespace tapestry::shell
