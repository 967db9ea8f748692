#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tapestry::shell {

// Compiled once for all programs, for CLI11 takes a compiler long.

/// The command line of a program, still without options.
/// \param description  what --help begins with
CLI::App command_line(std::string description);

/// Parses the command line. Returns a negative number to go on, else the exit code to leave with
/// (0 after --help, 2 after a mistake, whose message names the nearest option).
int parse_arguments(CLI::App& app, int argc, char** argv);

/// The options that were given, here or in the file of --config, with their values, as words of a command
/// line; `except` names the long options that are left out.
std::vector<std::string> given_options(const CLI::App& app, const std::vector<std::string>& except);

/// The words of a command line, each quoted for a shell where it needs it; what it prints is
/// printable().
std::string shell_line(const std::vector<std::string>& words);

}  // namespace tapestry::shell
