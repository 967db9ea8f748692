#pragma once
#include <array>
#include <cerrno>
#include <cstdio>
#include <tapestry/core/platform.hpp>

/// \file
/// Functions of core/platform.hpp that do nothing outside POSIX. There programs always have standard streams,
/// and no other process shares their work.
namespace tapestry::platform {

void keep_freed_memory() {}
void open_standard_streams() {}
int silence_standard_streams() { return 2; }
void print_to(int, const std::string& text) { std::fputs(text.c_str(), stderr); }

}  // namespace tapestry::platform
