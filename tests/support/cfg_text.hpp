#pragma once
#include <fstream>
#include <iterator>
#include <stdexcept>
#include "paths.hpp"

namespace tapestry::test {
/// The text of tests/detect/cfg/<name>.cfg, which states its purpose at its top.
inline std::string cfg_text(const std::string& name) {
  std::ifstream file(in_sources("tests/detect/cfg/") + name + ".cfg");
  if (!file) throw std::runtime_error("tests/detect/cfg/" + name + ".cfg is missing");
  return {std::istreambuf_iterator<char>(file), {}};
}
}  // namespace tapestry::test
