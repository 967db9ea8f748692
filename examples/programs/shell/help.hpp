#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

namespace tapestry::shell {

inline constexpr const char* exit_status_text =
    "Exit status:\n"
    "  0 done              3 input unreadable or malformed   6 a value is not finite\n"
    "  1 internal fault    4 inputs do not fit each other    7 folder in use\n"
    "  2 wrong usage       5 output cannot be written        8 beyond a limit\n"
    "  128 + n after signal n, with the work so far saved where a run can be resumed\n";

/// Formats --help, at most 80 columns wide: description, usage, options by groups in the order in which they
/// were added, the app's footer with examples, and exit codes. The script for manual pages reads this form:
/// names from column 3, texts from column 27.
class HelpText : public CLI::FormatterBase {
 public:
  [[nodiscard]] std::string make_help(const CLI::App* app, std::string name,
                                      CLI::AppFormatMode) const override {
    std::string text = wrapped(app->get_description(), 0) + "\nUsage: " + name + " [OPTIONS]";
    const auto positionals = options_of(app, [](const CLI::Option* o) { return o->get_positional(); });
    for (const auto* option : positionals) text += " " + option->get_name(true, false) + "...";
    text += "\n";
    add_group(text, "Arguments", positionals);
    for (const std::string& group : app->get_groups()) {
      const auto is_in = [&](const CLI::Option* o) { return o->nonpositional() && o->get_group() == group; };
      if (group != general) add_group(text, group, options_of(app, is_in));
    }
    const auto is_general = [](const CLI::Option* o) { return o->get_group() == general; };
    add_group(text, general, options_of(app, is_general));
    if (!app->get_footer().empty()) text += "\nExamples:\n" + app->get_footer() + "\n";
    return text + "\n" + exit_status_text;
  }

  /// The group of the options that every program has.
  static constexpr const char* general = "General";

 private:
  static constexpr std::size_t text_column = 26;
  static constexpr std::size_t most_columns = 80;

  template <class Predicate>
  static std::vector<const CLI::Option*> options_of(const CLI::App* app, Predicate is_wanted) {
    return app->get_options([&](const CLI::Option* option) { return is_wanted(option); });
  }

  static void add_group(std::string& text, const std::string& title,
                        const std::vector<const CLI::Option*>& options) {
    if (options.empty()) return;
    text += "\n" + title + ":\n";
    for (const auto* option : options) {
      std::string name = "  " + option->get_name(option->get_positional(), true) + value_of(*option);
      if (name.size() + 2 > text_column) name += "\n";
      name.resize(name.back() == '\n' ? name.size() + text_column : text_column, ' ');
      text += name + wrapped(option->get_description() + remarks_of(*option), text_column);
    }
  }

  /// The value that an option takes: TEXT, N for a whole number or X for a number.
  static std::string value_of(const CLI::Option& option) {
    if (option.get_positional() || option.get_expected_max() == 0 || option.get_type_name().empty())
      return "";
    const std::string& type = option.get_type_name();
    const char* word = type.rfind("FLOAT", 0) == 0                               ? " X"
                       : type.rfind("UINT", 0) == 0 || type.rfind("INT", 0) == 0 ? " N"
                                                                                 : " TEXT";
    return word + std::string(option.get_items_expected_max() > 1 ? "..." : "");
  }

  static std::string remarks_of(const CLI::Option& option) {
    std::string remarks;
    const auto add = [&](const std::string& remark) { remarks += (remarks.empty() ? "" : "; ") + remark; };
    if (option.get_required()) add("required");
    for (const auto* other : option.get_needs()) add("needs " + other->get_name());
    for (const auto* other : option.get_excludes()) add("not with " + other->get_name());
    const std::string& value = option.get_default_str();
    if (!value.empty() && value != "\"\"" && value != "[]") add("default " + value);
    return remarks.empty() ? "" : " (" + remarks + ")";
  }

  /// Lines of words; all but the first begin with `indent` blanks.
  static std::string wrapped(const std::string& text, std::size_t indent) {
    std::istringstream words(text);
    std::string lines, word;
    std::size_t column = indent;
    while (words >> word) {
      if (column > indent && column + 1 + word.size() > most_columns) {
        lines += "\n" + std::string(indent, ' ');
        column = indent;
      }
      lines += (column > indent ? " " : "") + word;
      column += (column > indent ? 1 : 0) + word.size();
    }
    return lines + "\n";
  }
};

}  // namespace tapestry::shell
