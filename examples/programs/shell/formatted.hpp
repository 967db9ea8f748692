#pragma once
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>

namespace tapestry::shell {

/// Formats numbers and words of C like printf().
template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, format, values...);
  return text;
}

/// Without the sign of a zero.
inline std::string fixed(double value, int digits) {
  const std::string text = formatted("%.*f", digits, value);
  return text.find_first_not_of("-0.") == std::string::npos ? formatted("%.*f", digits, 0.0) : text;
}

inline std::string interval_text(const std::array<double, 2>& ends, double unit = 100, int digits = 1) {
  return "[" + fixed(unit * ends[0], digits) + ", " + fixed(unit * ends[1], digits) + "]";
}

}  // namespace tapestry::shell
