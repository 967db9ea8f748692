#pragma once
#include <algorithm>
#include <charconv>
#include <ranges>
#include <system_error>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {
/// Walks over the lines of a text held in memory. A byte order mark is skipped, each of LF, CRLF and CR ends
/// a line, and the last line needs no end. Lines with zero bytes or beyond a limit are refused.
class TextLines {
 public:
  /// \param path   for messages; text and path must outlive this object
  TextLines(std::string_view text, const std::string& path, std::size_t line_limit = std::size_t{1} << 20U)
      : text_(text), path_(path), line_limit_(line_limit) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  }

  /// Moves to the next line; false after the last.
  [[nodiscard]] bool next();

  /// Moves to the next line and joins lines that follow a line ending with a backslash, unless it begins with
  /// #: a comment may end with a folder's name. number() is that of the first line.
  [[nodiscard]] bool next_joined();

  [[nodiscard]] std::string_view line() const { return line_; }
  /// Number of the line, from 1 on.
  [[nodiscard]] std::size_t number() const { return number_; }

  /// The next word of the line; empty at its end.
  std::string_view word();

  /// The rest of the line, without blanks around it.
  [[nodiscard]] std::string_view rest_of_line() const;

  /// Throws FileError about the current line.
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    fail_at(number_, what, expected, found, kind);
  }
  /// Throws FileError about a given line.
  [[noreturn]] void fail_at(std::size_t line, const std::string& what, const std::string& expected = "",
                            const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] bool next_piece();

  void require_length(std::size_t bytes) const;

  std::string_view text_;
  std::size_t at_ = 0;         // of the next line
  std::size_t line_feed_ = 0;  // the first from at_ on, where known
  const std::string& path_;
  std::size_t line_limit_;
  std::string_view line_;
  std::string_view left_;
  std::string joined_;
  std::size_t number_ = 0;
  std::size_t piece_number_ = 0;
};

/// Oddities in the lines of a text that are no reason to refuse it. Each kind becomes one warning, with the
/// line of the first and their count, so that a broken file fills neither a screen nor memory.
class LineOddities {
 public:
  /// Adds one on the current line.
  /// \param kind  must outlive this object; % in it stands for `name` in quotes
  void add(const char* kind, const TextLines& lines, std::string_view name = {}) {
    add(kind, lines.number(), name);
  }
  /// Adds one on a given line.
  void add(const char* kind, std::size_t line, std::string_view name = {});

  /// Appends a line for each kind, in the order of first occurrence, up to 100 warnings in all.
  void append_to(std::vector<std::string>& warnings, const std::string& path) const;

 private:
  struct Kind {
    const char* text;
    std::size_t line;
    std::string name;  // of the first
    std::size_t count;
  };
  std::vector<Kind> kinds_;
};

/// The word in lower case, for keywords of at most 8 letters; longer ones as they are.
[[nodiscard]] std::string lower_case_keyword(std::string_view word);

/// Whether the whole word is a number; independent of any locale. Numbers too small become 0, too large ones
/// and "nan" or "inf" are refused.
[[nodiscard]] bool parse_number(std::string_view word, double& value);

/// Whether the whole word is a whole number in the range of Integer.
template <class Integer>
[[nodiscard]] bool parse_integer(std::string_view word, Integer& value) {
  if (word.starts_with('+') && !word.substr(1).starts_with('-')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && end == word.data() + word.size() && error == std::errc();
}

namespace detail {
/// Length in bytes of the well-formed sequence at the beginning of `text`; 0 if there is none. Source: The
/// Unicode Standard 15.0, table 3-7; it leaves out overlong forms and surrogates.
[[nodiscard]] inline std::size_t utf8_sequence(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (text.size() < length) return 0;
  const unsigned least = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned most = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < least || byte(1) > most) return 0;
  for (std::size_t i = 2; i < length; ++i)
    if (byte(i) < 0x80 || byte(i) > 0xBF) return 0;
  return length;
}
}  // namespace detail

/// Length of the beginning of `text` that is well-formed UTF-8: all of it, or up to the first fault.
[[nodiscard]] inline std::size_t utf8_prefix(std::string_view text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t length = detail::utf8_sequence(text.substr(at));
    if (length == 0) break;
    at += length;
  }
  return at;
}

/// Whether a text of words with single spaces between them holds this word.
[[nodiscard]] inline bool is_word_of(std::string_view words, std::string_view word) {
  if (word.find(' ') != std::string_view::npos) return false;
  for (std::size_t at = words.find(word); at != std::string_view::npos; at = words.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || words[at - 1] == ' ') && (end == words.size() || words[end] == ' ')) return true;
  }
  return false;
}

/// Number of insertions, deletions, replacements and exchanges of neighbours that turn one word into the
/// other, with no part changed twice (optimal string alignment).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known word closest to `word`, the first of several; empty if none is near, that is, if more than a
/// third of the longer word would change.
[[nodiscard]] inline std::string nearest_word(std::string_view word,
                                              const std::ranges::forward_range auto& known) {
  std::string nearest;
  std::size_t best = 0;
  for (const std::string_view candidate : known) {
    const auto [shorter, longer] = std::minmax({word.size(), candidate.size()});
    if (3 * (longer - shorter) > longer) continue;  // needs at least as many insertions
    const std::size_t distance = edit_distance(word, candidate);
    if (3 * distance > longer) continue;
    if (nearest.empty() || distance < best) {
      nearest = candidate;
      best = distance;
    }
  }
  return nearest;
}
}  // namespace tapestry::io
