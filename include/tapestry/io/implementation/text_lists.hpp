#pragma once
#include <set>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/detail/number_formats.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/text_lists.hpp>

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
  throw FileError(kind, {path_, line == 0 ? std::string() : std::to_string(line), what, expected, found});
}

bool TextLines::next_piece() {
  if (at_ == text_.size()) return false;
  if (line_feed_ <= at_) line_feed_ = std::min(text_.find('\n', at_), text_.size());
  line_ = text_.substr(at_, line_feed_ - at_);
  line_ = line_.substr(0, line_.find('\r'));
  at_ += line_.size();
  if (at_ < line_feed_) ++at_;  // CR
  if (at_ == line_feed_ && at_ < text_.size()) ++at_;
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

void LineOddities::add(const char* kind, std::size_t line, std::string_view name) {
  const auto known = std::ranges::find(kinds_, std::string_view(kind),
                                       [](const Kind& one) { return std::string_view(one.text); });
  if (known != kinds_.end())
    ++known->count;
  else
    kinds_.push_back({kind, line, std::string(name), 1});
}

void LineOddities::append_to(std::vector<std::string>& warnings, const std::string& path) const {
  constexpr std::size_t most = 100;
  for (const Kind& kind : kinds_) {
    if (warnings.size() >= most) return;
    std::string text = kind.text;
    if (const std::size_t place = text.find('%'); place != std::string::npos)
      text.replace(place, 1, in_quotes(kind.name));
    if (kind.count > 1) text += " (and " + std::to_string(kind.count - 1) + " more of this kind)";
    warnings.push_back(path + ":" + std::to_string(kind.line) + ": " + text);
  }
}

std::string lower_case_keyword(std::string_view word) {
  std::string lower(word);
  constexpr std::size_t longest = 8;
  if (word.size() <= longest)
    for (char& letter : lower)
      if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return lower;
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

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(above);
    above.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      row[j] = std::min({replaced, above[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::vector<std::string> read_class_names(const std::string& path, std::size_t class_count) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 22U);
  TextLines lines(text, path, 1000);
  std::vector<std::string> names;
  std::vector<std::size_t> lines_of;
  const auto is_before = [&names](std::size_t a, std::size_t b) { return names[a] < names[b]; };
  std::set<std::size_t, decltype(is_before)> known(is_before);  // numbers of names
  std::size_t empty_line = 0;
  while (lines.next()) {
    const std::string_view name = lines.rest_of_line();
    if (name.empty()) {
      empty_line = empty_line == 0 ? lines.number() : empty_line;
      continue;
    }
    if (empty_line != 0) lines.fail_at(empty_line, "empty line between class names", "a name");
    names.emplace_back(name);
    lines_of.push_back(lines.number());
    if (const auto [first, is_new] = known.insert(names.size() - 1); !is_new)
      lines.fail("class name " + in_quotes(name) + " is repeated", "",
                 "line " + std::to_string(lines_of[*first]), ErrorKind::mismatch);
  }
  if (names.empty()) lines.fail_at(0, "no class names", "one name a line", "none");
  if (class_count != 0 && names.size() != class_count)
    lines.fail_at(0, "number of class names does not fit the detector", std::to_string(class_count),
                  std::to_string(names.size()), ErrorKind::mismatch);
  return names;
}

FaceList read_face_list(const std::string& path, std::size_t face_count) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 28U);
  TextLines lines(text, path);
  FaceList list;
  std::size_t beyond_line = 0;
  while (lines.next()) {
    const std::string_view word = lines.word();
    if (word.empty() || word.starts_with('#')) continue;
    std::int64_t id = 0;
    if (!parse_integer(word, id))
      lines.fail("face number is not a whole number", "1 or more", in_quotes(word));
    if (!lines.rest_of_line().empty())
      lines.fail("more than one word in a line", "one face number", in_quotes(lines.rest_of_line()));
    if (id == 0)
      lines.fail("face number 0, though they count from 1; is the list counted from 0?", "1 or more", "0");
    if (id < 0) lines.fail("face number is negative", "1 or more", std::to_string(id));
    if (static_cast<std::uint64_t>(id) > face_count && beyond_line == 0) beyond_line = lines.number();
    list.ids.push_back(id);
  }
  if (list.ids.empty())
    lines.fail_at(0, "face list is empty", "1 or more numbers", "none", ErrorKind::mismatch);
  if (beyond_line != 0) {
    const auto [least, most] = std::minmax_element(list.ids.begin(), list.ids.end());
    lines.fail_at(beyond_line, "face number beyond the faces of the mesh; is the list for another mesh?",
                  "1 to " + std::to_string(face_count),
                  std::to_string(list.ids.size()) + " numbers from " + std::to_string(*least) + " to " +
                      std::to_string(*most),
                  ErrorKind::mismatch);
  }
  std::vector<std::uint8_t> seen(face_count + 1);
  const std::size_t repeated = std::erase_if(
      list.ids, [&](std::int64_t id) { return std::exchange(seen[static_cast<std::size_t>(id)], 1) != 0; });
  if (repeated > 0)
    list.warnings.push_back(path + ": " + std::to_string(repeated) + " face numbers are repeated");
  if (list.ids.size() == face_count)
    list.warnings.push_back(path + ": the list covers every face of the mesh");
  return list;
}

Array<double, 2> read_palette(const std::string& path) {
  constexpr std::size_t most = 4096;
  std::string text = read_text_file(path, std::uint64_t(1) << 20U);
  for (char& letter : text)
    if (letter == ',') letter = ' ';
  TextLines lines(text, path);
  std::vector<double> channels;
  while (lines.next()) {
    const std::string line(lines.rest_of_line());
    if (line.empty() || line.starts_with('#')) continue;
    for (int c = 0; c < 3; ++c) {
      double channel = 0;
      if (!parse_number(lines.word(), channel))
        lines.fail("not a colour", "red, green and blue, three numbers from 0 to 1", in_quotes(line));
      if (!(channel >= 0 && channel <= 1))
        lines.fail("a channel lies outside 0 to 1; are the colours those of bytes?", "numbers from 0 to 1",
                   in_quotes(line));
      channels.push_back(channel);
    }
    if (!lines.rest_of_line().empty())
      lines.fail("more than three numbers in a line", "red, green and blue", in_quotes(line));
    if (channels.size() > 3 * most)
      lines.fail("too many colours", "at most " + std::to_string(most), "", ErrorKind::limit);
  }
  if (channels.empty())
    lines.fail_at(0, "the palette is empty", "1 or more colours", "none", ErrorKind::mismatch);
  Array<double, 2> palette(Extents<2>{channels.size() / 3, 3});
  std::copy(channels.begin(), channels.end(), palette.data());
  return palette;
}
}  // namespace tapestry::io
