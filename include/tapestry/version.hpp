#pragma once
#if __cplusplus < 202002L
#error "Tapestry needs C++20: compile with -std=c++20"
#include <of-C++20>  // there is none: a compiler ends here, and not after thousands of other errors
#endif

/// The only place of the version: CMake reads these three numbers.
#define TAPESTRY_VERSION_MAJOR 0
#define TAPESTRY_VERSION_MINOR 3
#define TAPESTRY_VERSION_PATCH 0
#define TAPESTRY_VERSION_TEXT "0.3.0"
