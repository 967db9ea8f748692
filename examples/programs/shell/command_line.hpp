#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tapestry::shell {
// Compiled once for all programs, because CLI11 takes long to compile.

/// The command line of a program, without options yet. An option's value when it is added is its default.
struct CommandLine : CLI::App {
  /// \param description  first text of --help
  explicit CommandLine(std::string description);
};

CommandLine command_line(std::string description);

/// Adds --threads, which limits the threads of this process as it is parsed.
void add_threads_option(CLI::App& app, const std::string& help = "threads; 0: all cores");

/// Parses the command line. Returns a negative number to continue, else the exit code to leave with (0 after
/// --help, 2 after a mistake, for which the message names the nearest option).
int parse_arguments(CLI::App& app, int argc, char** argv);

/// The options that were given, here or in the file of --config, with their values, as words of a command
/// line. `except` lists long options to leave out.
std::vector<std::string> given_options(const CLI::App& app, const std::vector<std::string>& except);

/// The words of a command line, each quoted for a shell if necessary; the text is printable().
std::string shell_line(const std::vector<std::string>& words);
}  // namespace tapestry::shell
