#include "build_facts.hpp"

#include <algorithm>
#include <tapestry/core/instruction_set.hpp>
#include <tapestry/core/platform.hpp>

#ifndef TAPESTRY_COMMIT  // CMake defines it
#define TAPESTRY_COMMIT TAPESTRY_VERSION_TEXT
#endif

namespace tapestry::shell {
using platform::processor_name;

std::vector<std::pair<std::string, std::string>> computed_by() {
  return {{"version", TAPESTRY_VERSION_TEXT},
          {"commit", TAPESTRY_COMMIT},
          {"compiler", __VERSION__},
          {"instruction_set", std::string(name_of(instruction_set()))},
          {"processor", processor_name()}};
}

std::string computed_by_text() {
  std::string commit = TAPESTRY_COMMIT;
  if (const auto mark = std::min(commit.find('-'), commit.size()); mark > 12) commit.erase(12, mark - 12);
  return "Tapestry " TAPESTRY_VERSION_TEXT " (" + (commit == TAPESTRY_VERSION_TEXT ? "" : commit + ", ") +
         std::string(name_of(instruction_set())) + " on " + processor_name() + ")";
}
}  // namespace tapestry::shell
