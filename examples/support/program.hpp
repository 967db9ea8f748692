#pragma once
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>
#include <limits>
#include <new>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/nearest_word.hpp>
#include <vector>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace tapestry::examples {

inline constexpr int exit_internal_fault = 1;

/// Parses the command line. Returns a negative number to go on, else the exit code to leave with
/// (0 after --help, 2 after a mistake, whose message names the nearest option).
inline int parse_arguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return -1;
  } catch (const CLI::ExtrasError&) {
    std::vector<std::string> known;
    for (const auto* option : app.get_options()) {
      for (const auto& name : option->get_lnames()) known.push_back("--" + name);
      for (const auto& name : option->get_snames()) known.push_back("-" + name);
    }
    const auto extras = app.remaining();
    const std::string unknown = extras.empty() ? std::string() : extras.front();
    const std::string word = unknown.substr(0, unknown.find('='));
    const std::string nearest = nearest_word(word, known);
    std::cerr << "error: unknown option " << word;
    if (!nearest.empty()) std::cerr << "; did you mean " << nearest << "?";
    std::cerr << "\nsee --help\n";
    return static_cast<int>(ErrorKind::usage);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "error: " << error.what() << "\nsee --help\n";
    return static_cast<int>(ErrorKind::usage);
  }
}

/// Keeps memory that was freed for the next step instead of handing it back to the system, which would have
/// to clear every page again: without it a third of a training step goes there.
inline void keep_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 << 20);
#endif
}

/// 2 usage, 3 unreadable or malformed input, 4 inputs that do not fit each other, 5 cannot write, 6 numeric
/// failure, 7 output folder in use. Beyond a limit counts as malformed.
[[nodiscard]] inline int exit_code_of(ErrorKind kind) {
  return static_cast<int>(kind == ErrorKind::limit ? ErrorKind::malformed : kind);
}

/// Runs a program's body and turns what it throws into one line on the error stream and an exit code.
template <class Body>
int run_program(Body body) {
  try {
    return body();
  } catch (const Error& error) {
    std::cerr << "error: " << error.what() << '\n';
    return exit_code_of(error.kind());
  } catch (const std::bad_alloc&) {
    std::cerr << "error: out of memory\n";
    return exit_internal_fault;
  } catch (const std::exception& error) {
    std::cerr << "error: internal fault: " << error.what() << '\n';
    return exit_internal_fault;
  }
}

}  // namespace tapestry::examples
