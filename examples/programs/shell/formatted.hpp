#pragma once
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

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

/// Rewords a fault of a JSON value, from what() of the JSON library's exceptions; empty for other text.
inline std::string json_fault(const std::string& what) {
  constexpr std::string_view prefix = "[json.exception.";
  if (!what.starts_with(prefix)) return {};
  const std::string words = what.substr(std::min(what.find("] ") + 2, what.size()));
  if (const auto key = words.find("key '"); key != std::string::npos)
    return "no member " + words.substr(key + 4, words.rfind('\'') - key - 3);
  const auto type = words.find("type must be "), found = words.find(", but is ");
  if (type != std::string::npos && found != std::string::npos)
    return "expected " + words.substr(type + 13, found - type - 13) + ", found " + words.substr(found + 9);
  return "a value of another kind, or too few of them";
}

/// The name of a class; without a name, its number behind `before`.
inline std::string class_name(std::size_t class_index, const std::vector<std::string>& names,
                              const char* before = "") {
  return class_index < names.size() ? names[class_index] : before + std::to_string(class_index);
}
}  // namespace tapestry::shell
