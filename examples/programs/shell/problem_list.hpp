#pragma once
#include <cmath>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>
#include "formatted.hpp"

namespace tapestry::shell {
/// Choices of an option: the names of an enumeration's values, or of a table's rows.
template <class Values>
std::vector<std::string> names_of(const Values& values) {
  std::vector<std::string> names;
  for (const auto& value : values)
    if constexpr (requires { value.name; })
      names.emplace_back(value.name);
    else
      names.emplace_back(name_of(value));
  return names;
}

/// Choices of an option for its help: name, in the braces of completions, and sentence of each row of a
/// table.
template <class Rows>
std::string help_of(const Rows& rows) {
  std::string text;
  for (const auto& row : rows)
    text += (text.empty() ? "{" : "; {") + std::string(row.name) + "} (" + row.sentence + ")";
  return text;
}

inline std::vector<std::string> words_in(const std::string& help) {
  std::vector<std::string> words;
  for (std::size_t begin = help.find('{'); begin != std::string::npos; begin = help.find('{', begin + 1))
    words.push_back(help.substr(begin + 1, help.find('}', begin) - begin - 1));
  return words;
}

/// Collects problems instead of stopping at the first.
class ProblemList {
 public:
  /// Adds the error that `action` throws, if it throws one.
  template <class Action>
  void attempt(Action action) {
    try {
      action();
    } catch (const Error& error) {
      problems_.push_back(error);
    }
  }
  /// Adds a usage error unless `holds`.
  void require(bool holds, const std::string& message) {
    if (!holds) problems_.emplace_back(ErrorKind::usage, message);
  }
  /// Adds a usage error unless `value` lies from `least`, unless that is excluded, to `most`.
  void require_number(const std::string& option, double value, double least, double most,
                      bool excludes_least = false) {
    const auto range = std::isinf(most) ? formatted(excludes_least ? "above %g" : "at least %g", least)
                       : excludes_least ? formatted("above %g and at most %.9g", least, most)
                                        : formatted("%g to %.9g", least, most);
    require((excludes_least ? value > least : value >= least) && value <= most, option + " must be " + range);
  }
  /// Adds a usage error that lists the choices unless `value` is one of them.
  void require_choice(const std::string& option, const std::string& value,
                      const std::vector<std::string>& choices) {
    if (std::ranges::find(choices, value) != choices.end()) return;
    const std::string nearest = io::nearest_word(value, choices);
    require(false, option + " is " + in_quotes(value) + "; expected one of " + listed(choices) +
                       (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }
  /// Adds a usage error if writing `output` would replace a file that is read.
  void require_kept(const char* option, const std::string& output, const std::vector<std::string>& inputs) {
    std::error_code no_such_file;
    for (const auto& input : inputs)
      require(!std::filesystem::equivalent(io::path_of(output), io::path_of(input), no_such_file),
              std::string(option) + " would overwrite " + input);
  }
  void throw_first() const {
    if (!problems_.empty()) throw problems_.front();
  }
  [[nodiscard]] const std::vector<Error>& problems() const { return problems_; }

 private:
  std::vector<Error> problems_;
};
}  // namespace tapestry::shell
