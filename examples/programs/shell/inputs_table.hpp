#pragma once
#include <tapestry/core/in_quotes.hpp>
#include "run_folder.hpp"
#include "word_table.hpp"

namespace tapestry::shell {
/// The inputs of a result as a table that a page shows once it is opened; empty without inputs.
/// \param inputs  see recorded_inputs()
inline std::string inputs_html(const Json& inputs) {
  constexpr std::size_t digits = 12;
  if (inputs.empty()) return {};
  WordTable table{"Inputs as their readers found them",
                  {"file", "read as", "bytes", "SHA-256, its beginning"}};
  for (const Json& input : inputs) {
    table.rows.push_back({input.at("path").get<std::string>(),
                          listed(input.at("read_as").get<std::vector<std::string>>()),
                          std::to_string(input.at("size").get<std::uint64_t>()),
                          input.at("sha256").get<std::string>().substr(0, digits)});
  }
  return "<details><summary>Inputs: " + std::to_string(inputs.size()) + " files</summary>\n" +
         html_of(table) + "</details>\n";
}
}  // namespace tapestry::shell
