#pragma once
#include <CLI/CLI.hpp>
#include <istream>

namespace tapestry::shell {
/// Reads the file of --config: CLI11's TOML, of options without sections. Refuses content that CLI11 ignores:
/// names given twice, open quotes. Takes memory of at most 100 times the file and 1 MiB.
class ConfigFile : public CLI::ConfigTOML {
 public:
  static constexpr std::size_t most_bytes = std::size_t(1) << 20U;

  ConfigFile() { parentSeparatorChar = '\0'; }

  /// \throws CLI::ConfigError
  [[nodiscard]] std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    if (input.peek() == 0xEF) input.ignore(3);  // a byte order mark
    auto given = CLI::ConfigTOML::from_config(input);
    std::vector<std::string> seen;
    for (const auto& item : given) {
      if (std::find(seen.begin(), seen.end(), item.name) != seen.end())
        refuse("option '" + item.name + "' is given twice");
      seen.push_back(item.name);
      for (const auto& value : item.inputs)  // before 2.4, CLI11 ends a value at a # within its quotes
        if (value.find('"') != std::string::npos || (value.starts_with('\'') && !value.ends_with('\'')))
          refuse("option '" + item.name + "': a quotation mark within the value, or none at its end");
    }
    return given;
  }

 private:
  [[noreturn]] static void refuse(const std::string& what) {
    throw CLI::ConfigError(what, CLI::ExitCodes::ConfigError);
  }
};
}  // namespace tapestry::shell
