#pragma once
#include <algorithm>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/io/detail/number_formats.hpp>

namespace tapestry::io::detail {
using detect::cfg_error;

struct CfgOption {
  std::string_view key;
  std::string_view value;
  std::size_t line;    ///< from 1
  std::size_t column;  ///< of the value, from 1
  bool asked_for = false;
};

/// One `[name]` with the options below it.
struct CfgSection {
  std::string_view name;
  std::size_t line;
  std::vector<CfgOption> options;
};

inline constexpr std::size_t longest_cfg_line = 65536;
inline constexpr std::size_t largest_cfg_layer_count = 2048;

[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\v\f";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string_view::npos)
    return text.substr(text.size());  // empty, at the place of the missing value
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

inline void add_cfg_option(const std::string& path, std::string_view whole_line, std::string_view line,
                           std::size_t line_number, CfgSection& section) {
  const auto equals = line.find('=');
  if (equals == std::string_view::npos)
    throw cfg_error(path, line_number, "not an option", "key=value or [section]", in_quotes(line));
  std::string_view value = trimmed(line.substr(equals + 1));
  for (const std::string_view comment : {" #", "\t#", " ;", "\t;"})
    value = trimmed(value.substr(0, value.find(comment)));
  CfgOption option{trimmed(line.substr(0, equals)), value, line_number, 0};
  option.column = static_cast<std::size_t>(option.value.data() - whole_line.data()) + 1;
  section.options.push_back(option);
}

/// Cuts the text of a cfg file into sections. Lines that begin with # or ; are comments. Behind a value, a
/// blank followed by # or ; begins a comment, too. A byte order mark, tabs and both kinds of line end are
/// accepted. The views point into `text`.
/// \throws FileError (malformed, or limit above 2,048 layers) with path and line
[[nodiscard]] inline std::vector<CfgSection> cfg_sections(std::string_view text, const std::string& path) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  std::vector<CfgSection> sections;
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::string_view whole = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), whole.size() + 1));
    if (whole.size() > longest_cfg_line) throw cfg_error(path, line_number, "line longer than 65536 bytes");
    if (whole.find('\0') != std::string_view::npos)
      throw cfg_error(path, line_number,
                      "zero byte, so this is not a text file; are cfg and weights swapped?");
    const std::string_view line = trimmed(whole);
    if (line.empty() || line[0] == '#' || line[0] == ';') continue;
    if (line[0] == '[') {
      if (line.back() != ']')
        throw cfg_error(path, line_number, "section without ']'", "[section]", in_quotes(line));
      sections.push_back({line.substr(1, line.size() - 2), line_number, {}});
      if (sections.size() > largest_cfg_layer_count + 1)
        throw cfg_error(path, line_number, "too many layers", "at most 2048", "", ErrorKind::limit);
    } else if (sections.empty()) {
      const bool is_page = line[0] == '<';
      throw cfg_error(path, line_number,
                      is_page ? "an HTML or XML page instead of a cfg" : "text before any section", "[net]",
                      in_quotes(line));
    } else {
      add_cfg_option(path, whole, line, line_number, sections.back());
    }
  }
  return sections;
}

/// Reads the options of one section with their types, and records which were read.
class SectionReader {
 public:
  SectionReader(std::string path, CfgSection& section) : path_(std::move(path)), section_(section) {}

  [[nodiscard]] std::size_t line() const { return section_.line; }
  [[nodiscard]] std::string_view name() const { return section_.name; }
  [[nodiscard]] CfgSection& section() { return section_; }

  [[nodiscard]] const CfgOption* find(std::string_view key) {
    for (CfgOption& option : section_.options) {
      if (option.key == key) {
        option.asked_for = true;
        return &option;
      }
    }
    return nullptr;
  }

  [[nodiscard]] std::string_view text(std::string_view key, std::string_view fallback) {
    const CfgOption* option = find(key);
    return option != nullptr ? option->value : fallback;
  }

  /// Integer in [low, high]. A smaller one is a malformed file, a larger one an error of kind `above`.
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t fallback, std::int64_t low,
                                     std::int64_t high, ErrorKind above = ErrorKind::limit) {
    const CfgOption* option = find(key);
    if (option == nullptr) return fallback;
    const auto value = parsed<std::int64_t>(*option, option->value, "an integer");
    if (value < low || value > high)
      throw error(*option, "option " + in_quotes(key) + " out of range",
                  std::to_string(low) + " to " + std::to_string(high), std::to_string(value),
                  value > high ? above : ErrorKind::malformed);
    return value;
  }

  [[nodiscard]] std::size_t count(std::string_view key, std::size_t fallback, std::int64_t low,
                                  std::int64_t high, ErrorKind above = ErrorKind::limit) {
    return static_cast<std::size_t>(integer(key, static_cast<std::int64_t>(fallback), low, high, above));
  }

  [[nodiscard]] double real(std::string_view key, double fallback) {
    const CfgOption* option = find(key);
    return option != nullptr ? parsed<double>(*option, option->value, "a finite number") : fallback;
  }

  /// Numbers separated by commas; at least one, at most 512.
  template <class Number>
  [[nodiscard]] std::vector<Number> list(std::string_view key) {
    const CfgOption* option = find(key);
    if (option == nullptr)
      throw cfg_error(path_, line(), "[" + std::string(name()) + "] lacks " + in_quotes(key));
    std::vector<Number> numbers;
    std::string_view rest = option->value;
    while (true) {
      const auto comma = rest.find(',');
      numbers.push_back(
          parsed<Number>(*option, trimmed(rest.substr(0, comma)), "numbers separated by commas"));
      if (numbers.size() > 512)
        throw error(*option, "option " + in_quotes(key) + " too long", "at most 512 numbers");
      if (comma == std::string_view::npos) return numbers;
      rest.remove_prefix(comma + 1);
    }
  }

  [[nodiscard]] FileError error(const CfgOption& option, const std::string& what,
                                const std::string& expected = "", const std::string& found = "",
                                ErrorKind kind = ErrorKind::malformed) const {
    return FileError(kind, {path_, std::to_string(option.line) + ":" + std::to_string(option.column), what,
                            expected, found});
  }

 private:
  template <class Number>
  [[nodiscard]] Number parsed(const CfgOption& option, std::string_view token, const char* expected) const {
    Number number{};
    const std::string_view digits = token.substr(0, 1) == "+" ? token.substr(1) : token;
    const auto [end, code] = decimal_from_chars(digits.data(), digits.data() + digits.size(), number);
    if (digits.empty() || code != std::errc() || end != digits.data() + digits.size() ||
        !std::isfinite(static_cast<double>(number))) {
      throw error(option, "option " + in_quotes(option.key), expected, in_quotes(token));
    }
    return number;
  }

  std::string path_;
  CfgSection& section_;
};
}  // namespace tapestry::io::detail
