#pragma once
#include <functional>
#include <string>
#include <string_view>

namespace tapestry {
namespace detail {
/// Bytes of the character at the beginning of `text` if a terminal would obey it, else 0: control characters
/// of ASCII, U+0080 to U+009F, and those that turn the direction of writing or end a line: U+061C, U+200E,
/// U+200F, U+2028 to U+202E, U+2066 to U+2069.
/// Source: The Unicode Standard 15.0, Annex 9, section 2 (explicit directional formatting characters).
[[nodiscard]] inline std::size_t order_length(std::string_view text) {
  const auto byte = [&](std::size_t at) {
    return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
  };
  if (byte(0) < 0x20 || byte(0) == 0x7F) return 1;
  if (byte(0) == 0xC2) return byte(1) >= 0x80 && byte(1) < 0xA0 ? 2 : 0;
  if (byte(0) == 0xD8) return byte(1) == 0x9C ? 2 : 0;
  if (byte(0) != 0xE2 || (byte(1) != 0x80 && byte(1) != 0x81)) return 0;
  const unsigned last = byte(2);
  const bool turns = byte(1) == 0x80 ? last == 0x8E || last == 0x8F || (last >= 0xA8 && last <= 0xAE)
                                     : last >= 0xA6 && last <= 0xA9;
  return turns ? 3 : 0;
}
}  // namespace detail

/// The text with a '?' for each character that a terminal obeys: it could hide or turn round text beside it.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = detail::order_length(text);
    clean += length > 0 ? '?' : text.front();
    text.remove_prefix(length > 0 ? length : 1);
  }
  return clean;
}

/// Cuts a message to at most `most` bytes: its middle is replaced by the number of bytes left out. A name or
/// a value in a message may be as long as its file.
[[nodiscard]] inline std::string shortened(std::string_view text, std::size_t most = 2000) {
  if (text.size() <= most) return std::string(text);
  const auto is_inside = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80;
  };
  std::size_t first = most - most / 4, last = text.size() - most / 4;
  while (first > 0 && is_inside(first)) --first;
  while (last < text.size() && is_inside(last)) ++last;
  std::string cut(text.substr(0, first));
  cut += " … (" + std::to_string(last - first) + " bytes left out) … ";
  return cut += text.substr(last);
}

/// A word of a file or a command line in quotes, for messages: at most 40 bytes of it, printable().
[[nodiscard]] inline std::string in_quotes(std::string_view word) {
  std::string quoted(1, '\'');  // appended to, since g++ 12 warns of "'" + string
  quoted += printable(word.substr(0, 40));
  return quoted += word.size() > 40 ? "…'" : "'";
}

/// Words with ", " between them, for messages.
/// \param word_of  returns the word of an entry, or is the member that holds it
template <class Entries, class WordOf = std::identity>
[[nodiscard]] std::string listed(const Entries& entries, WordOf word_of = {}) {
  std::string list;
  for (const auto& entry : entries) (list += list.empty() ? "" : ", ") += std::invoke(word_of, entry);
  return list;
}
}  // namespace tapestry
