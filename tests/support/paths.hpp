#pragma once
#include <string>

namespace tapestry::test {
/// Path of a file of this repository; `name` begins with its top folder.
std::string in_sources(const std::string& name);

/// Path of a file of the real data, which may be absent; `name` begins with a folder of TAPESTRY_SHARED.
std::string in_shared(const std::string& name);
}  // namespace tapestry::test
