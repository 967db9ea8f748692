#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace tapestry::shell {

/// The name of a class; without a name, its number behind `before`.
inline std::string class_name(std::size_t class_index, const std::vector<std::string>& names,
                              const char* before = "") {
  return class_index < names.size() ? names[class_index] : before + std::to_string(class_index);
}

}  // namespace tapestry::shell
