#pragma once
#include <algorithm>
#include <type_traits>
#include "formatted.hpp"

namespace tapestry::shell {
/// Whether a spreadsheet would compute this text: its first character, also as wide as Chinese ones, begins a
/// formula. Source: OWASP, "CSV Injection".
inline bool begins_formula(std::string_view text) {
  constexpr std::array<std::string_view, 11> beginnings{"=",  "+",  "-",  "@",  "\t", "\r",
                                                        "\n", "＝", "＋", "－", "＠"};
  return std::ranges::any_of(beginnings, [&](std::string_view first) { return text.starts_with(first); });
}

/// A text as a field of a CSV in quotes, those within it doubled (RFC 4180, section 2). An apostrophe
/// precedes text that begins like a formula: spreadsheets then read it as text.
inline std::string csv_quoted(std::string_view text) {
  std::string field(begins_formula(text) ? "\"'" : "\"");
  for (const char c : text) field.append(c == '"' ? 2 : 1, c);
  return field += '"';
}

/// A text as a field of a CSV, quoted if it would otherwise end early, also where semicolons or tabs separate
/// fields, or begin a formula.
inline std::string csv_field(std::string_view text) {
  const bool is_plain = text.find_first_of(",;\t\"\r\n") == std::string_view::npos && !begins_formula(text);
  return is_plain ? std::string(text) : csv_quoted(text);
}

/// Fields of a CSV with commas between them: text as it stands, whole numbers, others in nine digits, and
/// each element of a list.
template <class... Fields>
std::string csv_line(const Fields&... fields) {
  std::string line;
  const auto add = [&]<class Field>(const auto& self, const Field& field) {
    if constexpr (std::is_convertible_v<Field, std::string_view>) {
      line.append(",").append(field);
    } else if constexpr (std::is_integral_v<Field>) {
      line.append(",").append(std::to_string(field));
    } else if constexpr (std::is_floating_point_v<Field>) {
      line += formatted(",%.9g", field);
    } else {
      for (const auto& element : field) self(self, element);
    }
  };
  (add(add, fields), ...);
  return line.substr(1);
}
}  // namespace tapestry::shell
