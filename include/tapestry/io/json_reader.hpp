#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/utf8.hpp>
#include <utility>

namespace tapestry::io {

/// Reads JSON whose shape is known beforehand, front to back, into nothing but what the caller keeps.
///
/// The caller asks for what must come next, an object, an array, a string or a count, and anything else is
/// refused. So there is no tree in memory and no recursion that a file could drive: text nested deeper than
/// the caller asks is refused at the first bracket too many. Every byte is looked at; UTF-8 must be
/// well-formed and the keys of an object differ. Source: RFC 8259. Of its values, true, false, null and
/// numbers other than counts are never asked for.
class JsonReader {
 public:
  static constexpr std::size_t largest_member_count = std::size_t(1) << 17U;  ///< of one object

  /// \param text    must outlive this object
  /// \param path    the file's name, for messages
  /// \param offset  byte of the file where the text begins
  /// \throws FileError (malformed) at the first byte that is not UTF-8, as every function here at what it
  ///         did not expect
  JsonReader(std::string_view text, std::string path, std::uint64_t offset = 0)
      : text_(text), path_(std::move(path)), offset_(offset) {
    at_ = utf8_prefix(text_);
    if (at_ < text_.size())
      fail("not UTF-8", "well-formed text", "byte " + std::to_string(static_cast<unsigned char>(text_[at_])));
    at_ = 0;
  }

  /// Byte of the file that is read next, blanks skipped.
  [[nodiscard]] std::uint64_t position() {
    skip_blanks();
    return offset_ + at_;
  }

  /// Reads an object, calling member(key) where each value begins, which must read it.
  /// \throws FileError also (limit) above 131,072 members
  template <class Member>
  void object(Member member) {
    std::set<std::string> keys;
    list('{', '}', [&] {
      const std::size_t key_at = at_;
      const auto [key, is_new] = keys.insert(string());
      if (!is_new || keys.size() > largest_member_count) {
        at_ = key_at;
        if (is_new) fail("too many members in an object", "at most 131072", "more", ErrorKind::limit);
        fail("key given twice", "each key once", in_quotes(*key));
      }
      expect(':');
      member(*key);
    });
  }

  /// Reads an array, calling element() where each begins, which must read it.
  template <class Element>
  void array(Element element) {
    list('[', ']', element);
  }

  [[nodiscard]] std::string string() {
    expect('"', "a string");
    std::string value;
    while (true) {
      if (at_ == text_.size()) fail("string without its closing quote", "'\"'", "the end");
      const char c = text_[at_];
      if (static_cast<unsigned char>(c) < 0x20)
        fail("control character in a string", "an escape", "byte " + std::to_string(c));
      ++at_;
      if (c == '"') return value;
      if (c == '\\')
        append_escaped(value);
      else
        value += c;
    }
  }

  /// A whole number from 0 to 2⁶⁴ − 1, without sign, fraction or exponent.
  [[nodiscard]] std::uint64_t count() {
    skip_blanks();
    const std::size_t begin = at_;
    std::uint64_t value = 0;
    bool fits = true;
    for (; at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; ++at_)
      fits = fits && !__builtin_mul_overflow(value, std::uint64_t(10), &value) &&
             !__builtin_add_overflow(value, static_cast<std::uint64_t>(text_[at_] - '0'), &value);
    const std::string_view digits = text_.substr(begin, at_ - begin);
    const bool goes_on =
        at_ < text_.size() && std::string_view("+-.eE").find(text_[at_]) != std::string_view::npos;
    if (!digits.empty() && fits && !goes_on && (digits.size() == 1 || digits[0] != '0')) return value;
    at_ = begin;
    fail("unexpected value", "a whole number from 0 to 18446744073709551615", next_text());
  }

  /// Only blanks may be left.
  void end() {
    skip_blanks();
    if (at_ < text_.size()) fail("text after the last value", "the end", next_text());
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {path_, "@" + std::to_string(offset_ + at_), what, expected, found});
  }

  [[nodiscard]] std::string next_text() const {
    return at_ == text_.size() ? "the end" : in_quotes(text_.substr(at_, 20));
  }

  void skip_blanks() {
    at_ = text_.find_first_not_of(" \t\r\n", at_);
    if (at_ == std::string_view::npos) at_ = text_.size();
  }

  [[nodiscard]] bool accept(char c) {
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c, const std::string& name = "") {
    if (!accept(c)) fail("unexpected text", name.empty() ? std::string("'") + c + "'" : name, next_text());
  }

  template <class Item>
  void list(char opening, char closing, Item item) {
    expect(opening);
    if (accept(closing)) return;
    do {
      skip_blanks();
      item();
    } while (accept(','));
    expect(closing, std::string("',' or '") + closing + "'");
  }

  [[nodiscard]] unsigned four_hex_digits() {
    unsigned value = 0;
    for (int i = 0; i < 4; ++i, ++at_) {
      const std::size_t digit =
          at_ < text_.size() ? std::string_view("0123456789abcdefABCDEF").find(text_[at_]) : 22;
      if (digit >= 22) fail("unexpected text", "four hexadecimal digits after \\u", next_text());
      value = 16 * value + static_cast<unsigned>(digit < 16 ? digit : digit - 6);
    }
    return value;
  }

  /// Reads what follows a backslash; two halves of a surrogate pair make one code point.
  void append_escaped(std::string& value) {
    constexpr std::string_view letters = "\"\\/bfnrt";
    constexpr std::string_view meanings = "\"\\/\b\f\n\r\t";
    const std::size_t begin = at_ - 1;
    const char letter = at_ < text_.size() ? text_[at_] : '\0';
    const std::size_t known = letters.find(letter);
    if (known != std::string_view::npos) {
      value += meanings[known];
      ++at_;
      return;
    }
    if (letter != 'u') fail("unknown escape in a string", "one of \"\\/bfnrtu", next_text());
    ++at_;
    unsigned code_point = four_hex_digits();
    const bool is_high = code_point >= 0xD800 && code_point < 0xDC00;
    if (is_high && text_.substr(at_, 2) == "\\u") {
      at_ += 2;
      const unsigned low = four_hex_digits();
      code_point =
          low >= 0xDC00 && low < 0xE000 ? 0x10000 + ((code_point - 0xD800) << 10U) + (low - 0xDC00) : 0xD800;
    }
    if (code_point >= 0xD800 && code_point < 0xE000) {
      at_ = begin;
      fail("half of a surrogate pair in a string");
    }
    append_utf8(value, code_point);
  }

  std::string_view text_;
  std::string path_;
  std::uint64_t offset_;
  std::size_t at_ = 0;
};

/// The text as a JSON string with its quotes; it must be UTF-8.
[[nodiscard]] inline std::string json_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') {
      quoted += "\\n";
    } else if (c == '"' || c == '\\') {
      (quoted += '\\') += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      ((quoted += "\\u00") += "0123456789abcdef"[byte >> 4U]) += "0123456789abcdef"[byte & 15U];
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace tapestry::io
