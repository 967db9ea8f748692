#pragma once
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/error.hpp>
#include <tapestry/io/decimal_from_chars.hpp>
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
  [[nodiscard]] bool next() {
    if (!next_piece()) return false;
    number_ = piece_number_;
    return true;
  }

  /// Moves to the next line, to which those belong that come after one ending with a backslash, unless it
  /// begins with #: a comment may end with a folder's name. number() is that of the first.
  [[nodiscard]] bool next_joined() {
    if (!next()) return false;
    if (!line_.ends_with('\\') || rest_of_line().starts_with('#')) return true;
    joined_.clear();
    bool goes_on = true;
    while (goes_on) {
      goes_on = line_.ends_with('\\');
      joined_.append(line_.substr(0, line_.size() - (goes_on ? 1 : 0))).push_back(' ');
      require_length(joined_.size());
      goes_on = goes_on && next_piece();
    }
    line_ = left_ = joined_;
    return true;
  }

  [[nodiscard]] std::string_view line() const { return line_; }
  /// Of the line, from 1 on.
  [[nodiscard]] std::size_t number() const { return number_; }

  /// The next word of the line; empty at its end.
  std::string_view word() {
    const std::string_view from = rest_of_line();
    const std::string_view found = from.substr(0, from.find_first_of(" \t\v\f\r"));
    left_.remove_prefix(static_cast<std::size_t>(found.data() - left_.data()) + found.size());
    return found;
  }

  /// What is left of the line, without blanks around it.
  [[nodiscard]] std::string_view rest_of_line() const {
    const std::size_t first = left_.find_first_not_of(" \t\v\f\r");
    if (first == std::string_view::npos) return left_.substr(left_.size());
    return left_.substr(first, left_.find_last_not_of(" \t\v\f\r") - first + 1);
  }

  /// Throws FileError at the present line.
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    fail_at(number_, what, expected, found, kind);
  }
  /// Throws a FileError about that line.
  [[noreturn]] void fail_at(std::size_t line, const std::string& what, const std::string& expected = "",
                            const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {.path = path_,
                           .position = line == 0 ? std::string() : std::to_string(line),
                           .what = what,
                           .expected = expected,
                           .found = found});
  }

  /// Adds a remark about the present line, unless there are 100 already: a broken file could fill memory with
  /// them.
  void warn(std::vector<std::string>& warnings, const std::string& what) const {
    constexpr std::size_t most = 100;
    if (warnings.size() < most) warnings.push_back(path_ + ":" + std::to_string(number_) + ": " + what);
  }

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] bool next_piece() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    ++piece_number_;
    require_length(line_.size());
    if (line_.find('\0') != std::string_view::npos) fail_at(piece_number_, "line holds a zero byte");
    left_ = line_;
    return true;
  }

  void require_length(std::size_t bytes) const {
    if (bytes > line_limit_)
      fail_at(piece_number_, "line is too long", "at most " + std::to_string(line_limit_) + " bytes",
              std::to_string(bytes), ErrorKind::limit);
  }

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
[[nodiscard]] inline bool parse_number(std::string_view word, double& value) {
  if (word.starts_with('+') && !word.substr(1).starts_with('-')) word.remove_prefix(1);
  const auto [end, error] = decimal_from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return false;
  if (error == std::errc::result_out_of_range) {
    value = 0;
    return word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
  }
  return error == std::errc() && value - value == 0;
}

/// Whether the whole word is a whole number in the range of Integer.
template <class Integer>
[[nodiscard]] bool parse_integer(std::string_view word, Integer& value) {
  if (word.starts_with('+') && !word.substr(1).starts_with('-')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && end == word.data() + word.size() && error == std::errc();
}

}  // namespace tapestry::io
