#pragma once
#include <cstddef>
#include <string>

namespace tapestry::test {
/// A safetensors file of this header, in JSON, and these bytes behind it; neither need be sound.
inline std::string safetensors_bytes(const std::string& header, const std::string& numbers = "") {
  std::string bytes;
  for (std::size_t i = 0; i < 8; ++i) bytes += static_cast<char>(header.size() >> (8 * i) & 0xFFU);
  return bytes + header + numbers;
}
}  // namespace tapestry::test
