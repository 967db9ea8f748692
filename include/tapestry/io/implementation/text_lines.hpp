#pragma once
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/error.hpp>
#include <tapestry/io/decimal_from_chars.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io {

bool TextLines::next() {
  if (!next_piece()) return false;
  number_ = piece_number_;
  return true;
}

bool TextLines::next_joined() {
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

std::string_view TextLines::word() {
  const std::string_view from = rest_of_line();
  const std::string_view found = from.substr(0, from.find_first_of(" \t\v\f\r"));
  left_.remove_prefix(static_cast<std::size_t>(found.data() - left_.data()) + found.size());
  return found;
}

std::string_view TextLines::rest_of_line() const {
  const std::size_t first = left_.find_first_not_of(" \t\v\f\r");
  if (first == std::string_view::npos) return left_.substr(left_.size());
  return left_.substr(first, left_.find_last_not_of(" \t\v\f\r") - first + 1);
}

void TextLines::fail_at(std::size_t line, const std::string& what, const std::string& expected,
                        const std::string& found, ErrorKind kind) const {
  throw FileError(kind, {.path = path_,
                         .position = line == 0 ? std::string() : std::to_string(line),
                         .what = what,
                         .expected = expected,
                         .found = found});
}

void TextLines::warn(std::vector<std::string>& warnings, const std::string& what) const {
  constexpr std::size_t most = 100;
  if (warnings.size() < most) warnings.push_back(path_ + ":" + std::to_string(number_) + ": " + what);
}

bool TextLines::next_piece() {
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

void TextLines::require_length(std::size_t bytes) const {
  if (bytes > line_limit_)
    fail_at(piece_number_, "line is too long", "at most " + std::to_string(line_limit_) + " bytes",
            std::to_string(bytes), ErrorKind::limit);
}

bool parse_number(std::string_view word, double& value) {
  if (word.starts_with('+') && !word.substr(1).starts_with('-')) word.remove_prefix(1);
  const auto [end, error] = decimal_from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return false;
  if (error == std::errc::result_out_of_range) {
    value = 0;
    return word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
  }
  return error == std::errc() && value - value == 0;
}

}  // namespace tapestry::io
