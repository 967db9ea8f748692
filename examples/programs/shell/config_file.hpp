#pragma once
#include <CLI/CLI.hpp>
#include <istream>
#include <sstream>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::shell {

/// Reads the file of --config: `name = value` a line, names as on the command line without dashes, lists in
/// brackets. Refuses content that CLI11 ignores: unknown names, names given twice, sections, open quotes.
/// Takes memory of at most 100 times the file and 1 MiB.
class ConfigFile : public CLI::ConfigTOML {
 public:
  static constexpr std::size_t most_bytes = std::size_t(1) << 20U;

  explicit ConfigFile(const CLI::App& app) : app_(app) { parentSeparatorChar = '\0'; }

  /// \throws FileError usage for a name that is not an option, limit for a file beyond most_bytes
  [[nodiscard]] std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    const std::string text = plain_lines(input);
    std::istringstream lines(text);
    auto given = CLI::ConfigTOML::from_config(lines);
    std::vector<std::string> seen;
    for (const auto& item : given) {
      require_option(item.name);
      if (std::find(seen.begin(), seen.end(), item.name) != seen.end())
        refuse("option " + in_quotes(item.name) + " is given twice");
      seen.push_back(item.name);
      for (const auto& value : item.inputs) require_whole(item.name, value, text);
    }
    const auto is_flag_left_out = [&](const CLI::ConfigItem& item) {
      return app_.get_option("--" + item.name)->get_expected_min() == 0 && item.inputs.size() == 1 &&
             is_off(item.inputs.front());
    };
    given.erase(std::remove_if(given.begin(), given.end(), is_flag_left_out), given.end());
    return given;
  }

 private:
  [[noreturn]] void refuse(const std::string& what, ErrorKind kind = ErrorKind::usage) const {
    throw FileError(kind, {app_.get_config_ptr()->results().front(), "", what});
  }

  /// Before 2.4, CLI11 ends a value at a # within its quotes, and takes an apostrophe within `"` for a quote.
  void require_whole(const std::string& name, const std::string& value, const std::string& text) const {
    if (value.find('"') != std::string::npos)
      refuse("option " + in_quotes(name) + ": a quotation mark within the value, or none at its end");
    if (value.starts_with('\'') && !(value.size() > 1 && value.ends_with('\'')) &&
        text.find('"' + value + '"') == std::string::npos)
      refuse("option " + in_quotes(name) + ": an apostrophe at the start of the value and none at its end");
  }

  /// Whether CLI11 reads the value as a flag that is off.
  [[nodiscard]] static bool is_off(const std::string& value) {
    try {
      return CLI::detail::to_flag_value(value) < 0;
    } catch (const std::invalid_argument&) {  // CLI11 reports the error itself
      return false;
    }
  }

  /// The text of the file without a byte order mark, after checking that it is short and has no sections.
  [[nodiscard]] std::string plain_lines(std::istream& input) const {
    std::string text(most_bytes + 1, '\0');
    input.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(input.gcount()));
    if (text.size() > most_bytes)
      refuse("larger than " + std::to_string(most_bytes) + " bytes", ErrorKind::limit);
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      const auto first = line.find_first_not_of(" \t\r");
      if (first != std::string::npos && line[first] == '[') refuse("has a section, which no option is in");
    }
    return text;
  }

  void require_option(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto* option : app_.get_options())
      if (option->get_configurable())
        for (const auto& known : option->get_lnames()) names.push_back(known);
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    const std::string nearest = io::nearest_word(name, names);
    refuse("unknown option " + in_quotes(name) + (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }

  const CLI::App& app_;
};

}  // namespace tapestry::shell
