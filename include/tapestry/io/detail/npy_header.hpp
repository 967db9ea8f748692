#pragma once
#include <array>
#include <charconv>
#include <span>
#include <tapestry/core/array_limit.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {
/// Element types of .npy files that Tapestry reads, named as NumPy names them without the byte order.
enum class DType { b1, u1, u2, u4, u8, i1, i2, i4, i8, f4, f8 };

/// Name of a type, such as "f4".
[[nodiscard]] constexpr std::string_view type_name(DType type) {
  constexpr std::array<std::string_view, 11> names{"b1", "u1", "u2", "u4", "u8", "i1",
                                                   "i2", "i4", "i8", "f4", "f8"};
  return names[static_cast<std::size_t>(type)];
}

/// Bytes of one element.
[[nodiscard]] constexpr std::size_t item_size(DType type) {
  return static_cast<std::size_t>(type_name(type)[1] - '0');
}

/// "(608, 608, 3)"
[[nodiscard]] inline std::string shape_text(std::span<const std::size_t> shape) {
  std::string text = "(";
  for (std::size_t axis = 0; axis < shape.size(); ++axis)
    text += (axis > 0 ? ", " : "") + std::to_string(shape[axis]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

/// Header of an .npy file. xt::load_npy() is not used, because it accepts shapes whose product wraps, and
/// files shorter than their shape, whose missing elements it leaves undefined.
struct NpyHeader {
  DType type = DType::u1;
  bool big_endian = false;
  bool column_major = false;
  std::vector<std::size_t> shape;
  std::size_t element_count = 0;
  std::size_t size = 0;  ///< bytes before the payload
};

namespace detail {
/// Reader of the Python dictionary in an .npy header: the three known keys only.
class NpyHeaderText {
 public:
  NpyHeaderText(std::string_view text, std::size_t offset, const std::string& origin)
      : text_(text), offset_(offset), origin_(origin) {}

  NpyHeader parse() {
    std::array<bool, 3> seen{};
    expect('{');
    while (!accept('}')) {
      const std::string_view key = quoted();
      const std::size_t which = key == "descr" ? 0 : key == "fortran_order" ? 1 : key == "shape" ? 2 : 3;
      if (which == 3)
        fail("unknown key in the array header", "descr, fortran_order, shape", std::string(key));
      if (std::exchange(seen[which], true)) fail("repeated key in the array header", "", std::string(key));
      expect(':');
      if (which == 0) descr();
      if (which == 1) order();
      if (which == 2) shape();
      if (!accept(',') && peek() != '}') fail("array header is not a dictionary", "',' or '}'", found());
    }
    if (!(seen[0] && seen[1] && seen[2]))
      fail("array header lacks a key", "descr, fortran_order and shape", "");
    if (peek() != '\0') fail("text after the array header's dictionary", "", found());
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected, const std::string& found,
                         ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {origin_, "@" + std::to_string(offset_ + at_), what, expected, found});
  }

  /// The next character that is not a blank, '\0' at the end.
  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t')) ++at_;
    return at_ < text_.size() ? (text_[at_] == '\0' ? '\1' : text_[at_]) : '\0';
  }
  std::string found() {
    const char next = peek();
    if (next == '\0') return "the end of the header";
    return next < ' ' || next == '\x7f' ? "a control character" : "'" + std::string(1, next) + "'";
  }
  bool accept(char wanted) {
    if (peek() != wanted) return false;
    ++at_;
    return true;
  }
  void expect(char wanted) {
    if (!accept(wanted))
      fail("array header is not a dictionary", "'" + std::string(1, wanted) + "'", found());
  }
  std::string_view quoted() {
    const char quote = peek();
    if (quote != '\'' && quote != '"') fail("array header is not a dictionary", "a quoted word", found());
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos || end - at_ > 32)
      fail("array header is not a dictionary", "a quoted word", "");
    const std::string_view word = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return word;
  }

  void descr() {
    constexpr const char* plain = "one of b1, u1-u8, i1-i8, f4, f8";
    if (peek() == '[') fail("array of records", plain, "a structured type", ErrorKind::mismatch);
    const std::string_view word = quoted();
    const char order = word.empty() ? '?' : word[0];
    const std::string_view name = word.substr(word.empty() ? 0 : 1);
    if (name.starts_with('O')) fail("pickled objects are never loaded", plain, std::string(word));
    if (order != '<' && order != '>' && order != '|' && order != '=')
      fail("element type has no byte order", "'<', '>' or '|'", std::string(word));
    header_.big_endian = order == '>' || (order == '=' && std::endian::native == std::endian::big);
    for (int type = 0; type <= static_cast<int>(DType::f8); ++type) {
      header_.type = static_cast<DType>(type);
      if (type_name(header_.type) != name) continue;
      if (order == '|' && item_size(header_.type) > 1)
        fail("element type has no byte order", "", std::string(word));
      return;
    }
    fail("element type is not supported", plain, std::string(word), ErrorKind::mismatch);
  }

  void order() {
    peek();
    header_.column_major = text_.substr(at_, 4) == "True";
    if (!header_.column_major && text_.substr(at_, 5) != "False")
      fail("fortran_order is not a truth value", "True or False", found());
    at_ += header_.column_major ? 4 : 5;
  }

  void shape() {
    expect('(');
    std::uint64_t product = 1;
    bool empty = false;
    while (!accept(')')) {
      peek();
      std::uint64_t extent = 0;
      const char* const first = text_.data() + at_;
      const auto [end, error] = std::from_chars(first, text_.data() + text_.size(), extent);
      if (error == std::errc::result_out_of_range) too_large();
      if (error != std::errc()) fail("array extent is not a whole number", "0 or more", found());
      at_ += static_cast<std::size_t>(end - first);
      if (header_.shape.size() == 32) fail("array has too many axes", "at most 32", "more");
      header_.shape.push_back(static_cast<std::size_t>(extent));
      empty = empty || extent == 0;
      const std::uint64_t factor = extent == 0 ? 1 : extent;
      if (product > array_limit / factor) too_large();
      product *= factor;
      if (!accept(',') && peek() != ')') fail("array shape is not a tuple", "',' or ')'", found());
    }
    header_.element_count = empty ? 0 : static_cast<std::size_t>(product);
  }
  [[noreturn]] void too_large() const {
    fail("array shape is larger than memory can hold", "at most " + std::to_string(array_limit) + " elements",
         "more", ErrorKind::limit);
  }

  std::string_view text_;
  std::size_t offset_;
  const std::string& origin_;
  std::size_t at_ = 0;
  NpyHeader header_{};
};
}  // namespace detail

/// Reads the header of an .npy file held in memory; format versions 1 to 3.
/// Source: NumPy enhancement proposal 1 (the .npy format).
[[nodiscard]] inline NpyHeader parse_npy_header(std::string_view text, const std::string& origin) {
  constexpr std::string_view magic = "\x93NUMPY";
  const auto fail = [&](std::size_t at, const char* what, const std::string& expected,
                        const std::string& found) {
    throw malformed_file({origin, "@" + std::to_string(at), what, expected, found});
  };
  const auto byte = [&](std::size_t at) { return std::size_t{static_cast<unsigned char>(text[at])}; };
  if (!text.starts_with(magic)) fail(0, "not an .npy array", "the magic \\x93NUMPY", "other bytes");
  if (text.size() < 10) fail(6, "array header is cut", "10 bytes", std::to_string(text.size()));
  const std::size_t version = byte(6);
  if (version < 1 || version > 3) fail(6, "unknown .npy version", "1, 2 or 3", std::to_string(version));
  const std::size_t start = version == 1 ? 10 : 12;
  if (text.size() < start) fail(8, "array header is cut", "12 bytes", std::to_string(text.size()));
  std::size_t length = byte(8) + 256 * byte(9);
  if (version > 1) length += (byte(10) + 256 * byte(11)) << 16U;
  if (length > 65535) fail(8, "array header is too long", "at most 65535 bytes", std::to_string(length));
  if (length > text.size() - start)
    fail(8, "array header is longer than the file", std::to_string(length) + " bytes",
         std::to_string(text.size() - start));
  NpyHeader header = detail::NpyHeaderText(text.substr(start, length), start, origin).parse();
  header.size = start + length;
  return header;
}

/// Header of a version 1 file, padded so that the payload starts at a multiple of 64.
[[nodiscard]] inline std::string npy_header_text(DType type, std::span<const std::size_t> shape) {
  const char order = item_size(type) == 1 ? '|' : std::endian::native == std::endian::little ? '<' : '>';
  std::string dictionary = "{'descr': '" + std::string(1, order) + std::string(type_name(type)) +
                           "', 'fortran_order': False, 'shape': " + shape_text(shape) + ", }";
  dictionary.append((64 - (10 + dictionary.size() + 1) % 64) % 64, ' ');
  dictionary += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(dictionary.size() & 0xFFU);
  header += static_cast<char>(dictionary.size() >> 8U);
  return header + dictionary;
}
}  // namespace tapestry::io
