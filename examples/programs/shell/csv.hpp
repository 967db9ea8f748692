#pragma once
#include <string>
#include <string_view>

namespace tapestry::shell {

/// A field of a CSV in quotes, those within it doubled (RFC 4180, section 2).
inline std::string csv_quoted(std::string_view text) {
  std::string field(1, '"');
  for (const char c : text) field.append(c == '"' ? 2 : 1, c);
  return field += '"';
}

/// A field of a CSV, quoted if it would otherwise end early.
inline std::string csv_field(std::string_view text) {
  return text.find_first_of(",\"\r\n") == std::string_view::npos ? std::string(text) : csv_quoted(text);
}

}  // namespace tapestry::shell
