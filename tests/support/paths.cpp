#include "paths.hpp"

#include <filesystem>

#include "catch.hpp"

// Only this file knows where the sources lie: all others compile to the same in every folder, and ccache
// finds them.
namespace tapestry::test {
std::string in_sources(const std::string& name) { return TAPESTRY_SOURCE "/" + name; }
std::string in_shared(const std::string& name) { return TAPESTRY_SHARED "/" + name; }

bool is_absent(const std::string& path) {
  if (std::filesystem::exists(path)) return false;
  WARN("skipped: " << path << " is absent");
  return true;
}
}  // namespace tapestry::test
