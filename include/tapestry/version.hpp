#pragma once

/// The one home of the version: CMake reads these three numbers.
#define TAPESTRY_VERSION_MAJOR 0
#define TAPESTRY_VERSION_MINOR 1
#define TAPESTRY_VERSION_PATCH 0
#define TAPESTRY_VERSION_TEXT "0.1.0"
