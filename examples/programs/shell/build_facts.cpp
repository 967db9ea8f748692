#include "build_facts.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <tapestry/core/instruction_set.hpp>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#ifndef TAPESTRY_COMMIT  // CMake defines it
#define TAPESTRY_COMMIT TAPESTRY_VERSION_TEXT
#endif

namespace tapestry::shell {
namespace {

/// Brand name of the processor; its kind if there is none.
std::string processor_name() {
#if defined(__x86_64__)
  constexpr unsigned first = 0x80000002U, last = 0x80000004U;  // 16 letters each
  std::array<unsigned, 12> words{};
  if (static_cast<unsigned>(__get_cpuid_max(0x80000000U, nullptr)) >= last) {  // an int by clang
    for (unsigned leaf = first, i = 0; leaf <= last; ++leaf, i += 4)
      __get_cpuid(leaf, &words[i], &words[i + 1], &words[i + 2], &words[i + 3]);
    std::array<char, sizeof words + 1> letters{};
    std::memcpy(letters.data(), words.data(), sizeof words);
    const std::string_view name(letters.data());
    const auto begin = name.find_first_not_of(' ');
    if (begin != std::string_view::npos)
      return std::string(name.substr(begin, name.find_last_not_of(' ') + 1 - begin));
  }
#endif
  ::utsname system{};
  return ::uname(&system) == 0 ? system.machine : "unknown";
}

}  // namespace

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
