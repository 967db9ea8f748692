#pragma once
#include <array>
#include <set>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/detail/exported_names.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {
namespace detail {
/// Appends a character in UTF-8. \param code  of Unicode, at most 0x10FFFF
inline void append_utf8(std::uint32_t code, std::string& text) {
  constexpr std::array<std::uint32_t, 4> leads{0, 0xC0, 0xE0, 0xF0};
  const std::uint32_t following = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
  text += static_cast<char>(leads[following] | code >> 6 * following);
  for (std::uint32_t i = following; i-- > 0;) text += static_cast<char>(0x80U | (code >> 6 * i & 0x3FU));
}

/// Reads a dict or a list of Python from its beginning to its end.
class NamesLiteral {
 public:
  NamesLiteral(std::string_view text, std::size_t class_count) : text_(text), names_(class_count) {}

  [[nodiscard]] std::vector<std::string> read() {
    const bool is_dict = takes('{');
    if (!is_dict && !takes('[')) fail("expected { or [");
    const char close = is_dict ? '}' : ']';
    for (std::size_t place = 0; !takes(close); ++place) {
      add(is_dict ? number() : place);
      if (takes(',')) continue;
      if (!takes(close)) fail(std::string("expected , or ") + close);
      break;
    }
    skip_blanks();
    if (at_ < text_.size()) fail("expected nothing more");
    if (used_.empty()) fail("no names");
    return std::move(names_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw DomainError({what, " at byte ", at_}); }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }

  /// Whether this character is next, behind blanks; then it is passed.
  bool takes(char expected) {
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != expected) return false;
    ++at_;
    return true;
  }

  [[nodiscard]] std::size_t number() {
    skip_blanks();
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (error != std::errc()) fail("expected the number of a class");
    at_ = static_cast<std::size_t>(end - text_.data());
    if (!takes(':')) fail("expected :");
    return number;
  }

  void add(std::size_t number) {
    if (number >= names_.size())
      fail("a name for class " + std::to_string(number) + ", but there are " + std::to_string(names_.size()) +
           " classes");
    std::string name = word();
    if (name.empty() || name.size() > 1000 || utf8_prefix(name) != name.size() || printable(name) != name)
      fail("class " + std::to_string(number) + " is named " + in_quotes(name));
    if (!names_[number].empty()) fail("class " + std::to_string(number) + " is named twice");
    if (!used_.insert(name).second) fail("name " + in_quotes(name) + " is repeated");
    names_[number] = std::move(name);
  }

  [[nodiscard]] std::string word() {
    const char quote = takes('\'') ? '\'' : '"';
    if (quote == '"' && !takes('"')) fail("expected a text in quotes");
    std::string word;
    while (at_ < text_.size() && text_[at_] != quote) {
      if (text_[at_] == '\\')
        append_escaped(word);
      else
        word += text_[at_++];
    }
    if (at_ == text_.size()) fail("a text without end");
    ++at_;
    return word;
  }

  void append_escaped(std::string& word) {
    const char kind = at_ + 1 < text_.size() ? text_[at_ + 1] : '\0';
    const std::size_t digits = kind == 'x' ? 2 : kind == 'u' ? 4 : kind == 'U' ? 8 : 0;
    if (digits == 0) {
      if (kind != '\\' && kind != '\'' && kind != '"') fail("an escape that no name needs");
      word += kind;
      at_ += 2;
      return;
    }
    const std::string_view hex = text_.substr(at_ + 2, digits);
    std::uint32_t code = 0;
    const auto [end, error] = std::from_chars(hex.data(), hex.data() + hex.size(), code, 16);
    if (hex.size() != digits || end != hex.data() + digits || error != std::errc() || code > 0x10FFFF)
      fail("an escape that is no character");
    append_utf8(code, word);
    at_ += 2 + digits;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<std::string> names_;
  std::set<std::string> used_{};
};
}  // namespace detail

std::vector<std::string> parse_exported_names(std::string_view text, std::size_t class_count) {
  return detail::NamesLiteral(text, class_count).read();
}
}  // namespace tapestry::io
