#pragma once
#include <string>
#include <utility>
#include <vector>

namespace tapestry::shell {
/// Facts that the last bits of a result depend on, each with its name: version and commit of Tapestry,
/// compiler, instruction set and processor. The commit of the sources when CMake last ran, followed by
/// `-changed` if they differed from it. Without git it is the version. Compiled on its own, so that a new
/// commit recompiles nothing else.
/// \throws DomainError as instruction_set() does
std::vector<std::pair<std::string, std::string>> computed_by();

std::string computed_by_text();
}  // namespace tapestry::shell
