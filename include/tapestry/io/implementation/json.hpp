#pragma once
#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/json.hpp>
#include <vector>

/// \file
/// The compiled part of the reader of JSON texts: nlohmann's parser is instantiated here alone.

namespace tapestry::io {
namespace detail {
/// An iterator over a text that counts in `*read` how far a parser is.
struct CountedCharacter {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char& operator*() const { return *at; }
  CountedCharacter& operator++() {
    ++at;
    ++*read;
    return *this;
  }
  bool operator==(const CountedCharacter& other) const { return at == other.at; }

  const char* at;
  std::size_t* read;
};

/// Reads a text once, and checks at each event of the parser what the parser itself accepts: duplicate keys,
/// and unlimited nesting, which could overflow the stack of recursive code.
class JsonReader {
 public:
  JsonReader(std::string_view text, std::string path, std::uint64_t offset, std::size_t deepest)
      : text_(text), path_(std::move(path)), offset_(offset), deepest_(deepest) {}

  [[nodiscard]] JsonText read() {
    if (const std::size_t zero = text_.find('\0'); zero != text_.npos)  // nlohmann ends the text there
      fail(zero, "zero byte in JSON");
    try {
      auto value = nlohmann::json::parse(
          CountedCharacter{text_.data(), &read_}, CountedCharacter{text_.data() + text_.size(), nullptr},
          [this](int, nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
            return take(event, parsed);
          });
      return {std::move(value), std::move(positions_)};
    } catch (const nlohmann::json::parse_error& error) {
      refuse(std::min(error.byte, text_.size() + 1) - 1, error.what());
    } catch (const nlohmann::json::out_of_range& error) {  // a number, whose position is not known
      refuse(text_.find_first_not_of(" \t\r\n,:[{", token_end_), error.what());
    }
  }

 private:
  /// Line and column of a byte, both from 1 and the column in characters; within another file, its byte.
  /// Counts on from the byte of the call before, which lies no further on.
  std::string place(std::size_t at) {
    if (offset_ != 0) return "@" + std::to_string(offset_ + at);
    for (; counted_ < at; ++counted_) {
      if (text_[counted_] == '\n') ++line_, column_ = 0;
      if ((static_cast<unsigned char>(text_[counted_]) & 0xC0U) != 0x80U)
        ++column_;  // a character's first byte
    }
    return std::to_string(line_) + ":" + std::to_string(column_);
  }

  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) {
    throw FileError(kind, {path_, place(at), what, expected, found});
  }

  /// The expectation that nlohmann's message implies.
  /// \param message  [...] parse error at line 1, column 9: syntax error while parsing object key - ...
  static std::string expected_by(std::string_view message) {
    if (message.ends_with("end of input")) return "the end";
    constexpr std::array<std::pair<std::string_view, const char*>, 13> words{
        {{"closing quote", "a closing quote"},
         {"must be escaped", "an escape for a control character, such as \\n"},
         {"after backslash", "one of \" \\ / b f n r t u behind the backslash"},
         {"hex digits", "four hexadecimal digits behind \\u"},
         {"surrogate", "\\u of both halves of a surrogate pair"},
         {"UTF-8", "UTF-8"},
         {"invalid number", "a number such as -1.5e3"},
         {"number overflow", "a number of at most 1.79e308"},
         {"object key", "a key in double quotes"},
         {"object separator", "':' behind the key"},
         {"parsing object", "',' or '}'"},
         {"parsing array", "',' or ']'"},
         {"", "a value"}}};
    const auto own = message.substr(0, message.find("; last read"));  // without the file's text
    const auto fits = [&](const auto& row) { return own.find(row.first) != own.npos; };
    return std::ranges::find_if(words, fits)->second;
  }

  [[noreturn]] void refuse(std::size_t at, std::string_view message) {
    if (message.find("invalid literal") != message.npos || message.find("invalid number") != message.npos)
      while (at > token_end_ && std::string_view(" \t\r\n,:[]{}").find(text_[at - 1]) == message.npos) --at;
    fail(at, "not valid JSON", expected_by(message),
         at == text_.size() ? "the end" : in_quotes(text_.substr(at, 20)));
  }

  bool take(nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::key)
      take_key(parsed.get_ref<const std::string&>());
    else if (event == Event::value)
      begin_value(parsed.is_number() ? 1 : 0);
    else if (event == Event::object_start || event == Event::array_start)
      open();
    else
      close();
    return true;
  }

  void take_key(const std::string& name) {
    const std::size_t begin = next_token(0);
    auto& keys = keys_.back();
    if (keys.size() == largest_member_count)
      fail(begin, "too many members in an object", "at most 131072", "more", ErrorKind::limit);
    if (!keys.insert(name).second) fail(begin, "key given twice", "each key once", in_quotes(name));
    if (keys_.size() == 1) member_ = name;
  }

  /// Position of the token read last.
  /// \param ahead characters that the parser has read beyond it: one after a number
  std::size_t next_token(std::size_t ahead) {
    const std::size_t begin = text_.find_first_not_of(" \t\r\n,:", token_end_);
    token_end_ = read_ - ahead;
    return begin;
  }

  std::size_t begin_value(std::size_t ahead) {
    const std::size_t begin = next_token(ahead);
    if (keys_.size() == 1 && !keys_[0].empty()) positions_.emplace(member_, place(begin));
    return begin;
  }
  void open() {
    const std::size_t begin = begin_value(0);
    if (keys_.size() == deepest_)
      fail(begin, "JSON nested too deep", "at most " + std::to_string(deepest_) + " levels", "more");
    keys_.emplace_back();
  }
  void close() {
    (void)next_token(0);
    keys_.pop_back();
  }

  std::string_view text_;
  std::string path_;
  std::uint64_t offset_;
  std::size_t deepest_;
  std::size_t read_ = 0, token_end_ = 0;
  std::size_t counted_ = 0, line_ = 1, column_ = 1;  ///< of place()
  std::vector<std::set<std::string>> keys_;          ///< one for each open object, empty for an open array
  std::string member_;
  std::map<std::string, std::string> positions_;
};
}  // namespace detail

JsonText read_json(std::string_view text, const std::string& path, std::uint64_t offset,
                   std::size_t deepest) {
  return detail::JsonReader(text, path, offset, deepest).read();
}
}  // namespace tapestry::io
