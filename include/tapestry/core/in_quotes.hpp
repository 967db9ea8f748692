#pragma once
#include <string>
#include <string_view>

namespace tapestry {

/// A word of a file or a command line in quotes, for messages: at most 40 bytes of it, control characters as
/// '?'.
[[nodiscard]] inline std::string in_quotes(std::string_view word) {
  std::string text = "'";
  for (const char letter : word.substr(0, 40))
    text += static_cast<unsigned char>(letter) < 0x20 || letter == '\x7f' ? '?' : letter;
  return text + (word.size() > 40 ? "…'" : "'");
}

}  // namespace tapestry
