#pragma once
#include <optional>
#include <tapestry/io/atomic_file.hpp>
#include "../../examples/programs/shell/build_facts.hpp"
#include "../../examples/programs/shell/csv.hpp"

namespace tapestry::benchmarks {
/// One line of a benchmark's table. What could not be measured has no value.
struct Result {
  std::string case_name, variant;
  int threads = 1;
  std::optional<double> seconds{}, error{}, memory_mib{};
  std::optional<double> spread{};  ///< of the seconds, see Timing
};

[[nodiscard]] inline bool is_peer(const std::string& variant) { return variant.rfind("peer:", 0) == 0; }

/// A number by printf's rules, or nothing.
[[nodiscard]] inline std::string formatted(const char* format, std::optional<double> value) {
  if (!value) return {};
  char text[64];
  std::snprintf(text, sizeof text, format, *value);
  return text;
}

/// Replaces the file as a whole; see io::write_file_atomically(). Each row states where it was measured, so
/// that rows of several runs can be put together.
inline void write_csv(const std::string& path, const std::vector<Result>& results) {
  std::string text = "case,variant,threads,seconds,error,memory_mib,spread", place;
  for (const auto& [name, fact] : shell::computed_by()) {
    text += "," + name;
    place += "," + shell::csv_field(fact);
  }
  text += "\n";
  for (const Result& result : results) {
    text += result.case_name + "," + result.variant + "," + std::to_string(result.threads) + "," +
            formatted("%.6g", result.seconds) + "," + formatted("%.3e", result.error) + "," +
            formatted("%.1f", result.memory_mib) + "," + formatted("%.3f", result.spread) + place + "\n";
  }
  io::write_file_atomically(path, std::string_view(text));
}
}  // namespace tapestry::benchmarks
