#pragma once
#include <array>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <tapestry/core/platform.hpp>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#if (defined(__unix__) || defined(__APPLE__)) && !defined(__EMSCRIPTEN__)
#include <tapestry/core/implementation/platform/posix.hpp>
#elif defined(_WIN32)
#include <tapestry/core/implementation/platform/windows.hpp>
#else
#include <tapestry/core/implementation/platform/bare.hpp>
#endif

namespace tapestry::platform {
#if !(defined(__unix__) || defined(__APPLE__)) || defined(__EMSCRIPTEN__)
// No other process shares a program's work.
int silence_standard_streams() { return 2; }
void print_to(int, const std::string& text) { std::fputs(text.c_str(), stderr); }
#endif

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
  return machine_name();
}
}  // namespace tapestry::platform
