#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
namespace detail {

/// The layers, each checked by itself.
[[nodiscard]] detect::NetworkConfig parse_cfg(std::string_view text, const std::string& name);

inline constexpr std::uint64_t largest_cfg_size = std::uint64_t(4) << 20U;
}  // namespace detail

/// Parses a Darknet cfg file of a detector. Its layers are checked against each other at the size it names;
/// other sizes are checked by detect::infer_shapes(). Options that Darknet only trains with are skipped;
/// those that nobody knows become `warnings`.
///
/// \param text  the file's content
/// \param name  the file's name, for messages
/// \throws FileError  malformed for syntax and impossible values, mismatch for parts that do not fit,
///                    limit for absurd sizes; with line, and column where an option's value is at fault
[[nodiscard]] detect::NetworkConfig parse_network_config(std::string_view text, const std::string& name);

/// The same of a network without heads, such as a classifier; see detect::check_classifier().
[[nodiscard]] detect::NetworkConfig parse_classifier_config(std::string_view text, const std::string& name);

/// Reads a Darknet cfg file of at most 4 MiB; errors as parse_network_config() and read_text_file().
/// Takes memory of at most 24 times the file and 1 MiB.
[[nodiscard]] inline detect::NetworkConfig read_network_config(const std::string& path) {
  return parse_network_config(read_text_file(path, detail::largest_cfg_size), path);
}

/// The same by parse_classifier_config().
[[nodiscard]] inline detect::NetworkConfig read_classifier_config(const std::string& path) {
  return parse_classifier_config(read_text_file(path, detail::largest_cfg_size), path);
}

}  // namespace tapestry::io
