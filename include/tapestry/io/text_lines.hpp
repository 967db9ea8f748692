#pragma once
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// Walks over the lines of a text held in memory: a byte order mark is skipped, LF and CRLF both end a line,
/// and the last one needs no end. Lines with zero bytes or beyond a limit are refused.
class TextLines {
 public:
  /// \param path   for messages; text and path must outlive this object
  TextLines(std::string_view text, const std::string& path, std::size_t line_limit = std::size_t{1} << 20U)
      : rest_(text), path_(path), line_limit_(line_limit) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  /// Moves to the next line; false after the last.
  [[nodiscard]] bool next();

  /// Moves to the next line, to which those belong that come after one ending with a backslash, unless it
  /// begins with #: a comment may end with a folder's name. number() is that of the first.
  [[nodiscard]] bool next_joined();

  [[nodiscard]] std::string_view line() const { return line_; }
  /// Of the line, from 1 on.
  [[nodiscard]] std::size_t number() const { return number_; }

  /// The next word of the line; empty at its end.
  std::string_view word();

  /// What is left of the line, without blanks around it.
  [[nodiscard]] std::string_view rest_of_line() const;

  /// Throws FileError at the present line.
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    fail_at(number_, what, expected, found, kind);
  }
  /// Throws a FileError about that line.
  [[noreturn]] void fail_at(std::size_t line, const std::string& what, const std::string& expected = "",
                            const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const;

  /// Adds a remark about the present line, unless there are 100 already: a broken file could fill memory with
  /// them.
  void warn(std::vector<std::string>& warnings, const std::string& what) const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] bool next_piece();

  void require_length(std::size_t bytes) const;

  std::string_view rest_;
  const std::string& path_;
  std::size_t line_limit_;
  std::string_view line_;
  std::string_view left_;
  std::string joined_;
  std::size_t number_ = 0;
  std::size_t piece_number_ = 0;
};

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

}  // namespace tapestry::io
