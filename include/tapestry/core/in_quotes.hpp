#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace tapestry {

/// The text with a '?' for each control character, of which a terminal would take orders: those of ASCII, and
/// U+0080 to U+009F in UTF-8.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string clean;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
    const bool is_wide = byte(i) == 0xC2 && i + 1 < text.size() && byte(i + 1) >= 0x80 && byte(i + 1) < 0xA0;
    clean += is_wide || byte(i) < 0x20 || byte(i) == 0x7F ? '?' : text[i];
    if (is_wide) ++i;
  }
  return clean;
}

/// A word of a file or a command line in quotes, for messages: at most 40 bytes of it, printable().
[[nodiscard]] inline std::string in_quotes(std::string_view word) {
  std::string quoted(1, '\'');  // appended to, for g++ 12 warns of what it makes of "'" + string
  quoted += printable(word.substr(0, 40));
  return quoted += word.size() > 40 ? "…'" : "'";
}

}  // namespace tapestry
