#pragma once
#include <cctype>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tapestry::test {

/// Any JSON value; enough to look into files that tests have written. Throws std::runtime_error at what is no
/// JSON; escapes in strings are not resolved.
struct JsonValue {
  std::map<std::string, JsonValue> members;
  std::vector<JsonValue> elements;
  std::string text;   ///< of a string
  double number = 0;  ///< of a number; 1 or 0 of true and false

  [[nodiscard]] const JsonValue& operator[](const std::string& key) const { return members.at(key); }
  [[nodiscard]] const JsonValue& operator[](std::size_t index) const { return elements.at(index); }
  [[nodiscard]] bool has(const std::string& key) const { return members.count(key) > 0; }
  [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(number); }
};

class JsonParser {
 public:
  static JsonValue parse(std::string_view text) {
    JsonParser parser(text);
    JsonValue value = parser.value();
    parser.skip_blanks();
    if (parser.at_ != text.size()) throw std::runtime_error("text after the JSON value");
    return value;
  }

 private:
  explicit JsonParser(std::string_view text) : text_(text) {}

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  [[nodiscard]] char peek() {
    skip_blanks();
    if (at_ == text_.size()) throw std::runtime_error("JSON ends early");
    return text_[at_];
  }
  bool accept(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) throw std::runtime_error(std::string("JSON lacks ") + c);
  }

  std::string string() {
    expect('"');
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    if (at_ >= text_.size()) throw std::runtime_error("JSON string without end");
    return std::string(text_.substr(begin, at_++ - begin));
  }

  JsonValue value() {
    JsonValue result;
    if (peek() == '{') {
      expect('{');
      if (accept('}')) return result;
      do {
        std::string key = string();
        expect(':');
        result.members.emplace(std::move(key), value());
      } while (accept(','));
      expect('}');
    } else if (peek() == '[') {
      expect('[');
      if (accept(']')) return result;
      do result.elements.push_back(value());
      while (accept(','));
      expect(']');
    } else if (peek() == '"') {
      result.text = string();
    } else if (text_.substr(at_, 4) == "true") {
      result.number = 1;
      at_ += 4;
    } else {
      const std::string rest(text_.substr(at_, 40));
      char* end = nullptr;
      result.number = std::strtod(rest.c_str(), &end);
      if (end == rest.c_str()) throw std::runtime_error("no JSON value at " + rest);
      at_ += static_cast<std::size_t>(end - rest.c_str());
    }
    return result;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace tapestry::test
