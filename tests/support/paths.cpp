#include "paths.hpp"

// Only this file contains the sources' path: all others compile to the same in every
// folder, and ccache finds them.
namespace tapestry::test {
std::string in_sources(const std::string& name) { return TAPESTRY_SOURCE "/" + name; }
std::string in_shared(const std::string& name) { return TAPESTRY_SHARED "/" + name; }
}  // namespace tapestry::test
