#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/file_source.hpp>
#include <tapestry/detect/network_config/decode_choice.hpp>
#include <tapestry/detect/network_config/known_keys.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/detect/network_config/layer_parsing.hpp>
#include <tapestry/detect/network_config/section.hpp>
#include <tapestry/detect/network_config/shape.hpp>
#include <vector>

namespace tapestry::detect {
namespace detail {
inline void parse_net(SectionReader& reader, NetworkConfig& config) {
  config.line = reader.line();
  config.width = reader.count("width", config.width, 1, 16384);
  config.height = reader.count("height", config.height, 1, 16384);
  config.channels = reader.count("channels", config.channels, 1, 1 << 20);
  if (config.channels != 3) {
    throw reader.error(*reader.find("channels"), "the network is fed with colour pictures", "channels=3",
                       std::to_string(config.channels), ErrorKind::mismatch);
  }
}

/// A detector has at least one head, and no two heads of the same grid.
inline void check_heads(const NetworkConfig& config, const std::vector<FeatureShape>& shapes) {
  std::vector<std::size_t> heads;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    if (config.layers[i].kind != LayerKind::yolo) continue;
    for (const std::size_t earlier : heads) {
      if (shapes[earlier].row_reduction == shapes[i].row_reduction) {
        throw misfit(config, i, "another [yolo] layer has the same grid", "one head for each scale",
                     "the one on line " + std::to_string(config.layers[earlier].line));
      }
    }
    heads.push_back(i);
  }
  if (heads.empty()) {
    throw cfg_error(config.name, config.line, "no [yolo] section, so this is not a YOLO-V3 detector", "", "",
                    ErrorKind::mismatch);
  }
}
}  // namespace detail

/// Parses a Darknet cfg file. Its layers are checked against each other at the size it names; other sizes
/// are checked by infer_shapes(). Options that Darknet only trains with are skipped; those that nobody
/// knows become `warnings`.
///
/// \param text  the file's content
/// \param name  the file's name, for messages
/// \throws FileError  malformed for syntax and impossible values, mismatch for parts that do not fit,
///                    limit for absurd sizes; with line, and column where an option's value is at fault
[[nodiscard]] inline NetworkConfig parse_network_config(std::string_view text, const std::string& name) {
  auto sections = detail::cfg_sections(text, name);
  if (sections.empty()) throw detail::cfg_error(name, 1, "no [net] section", "a Darknet cfg file");
  NetworkConfig config;
  config.name = name;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const bool is_net = sections[i].name == "net" || sections[i].name == "network";
    if (is_net != (i == 0)) {
      throw detail::cfg_error(name, sections[i].line, i == 0 ? "no [net] section" : "a second [net] section",
                              i == 0 ? "[net] first" : "one",
                              "[" + std::string(sections[i].name.substr(0, 40)) + "]");
    }
    detail::SectionReader reader(name, sections[i]);
    detail::check_repeated_options(name, reader, config.warnings);
    if (is_net) {
      detail::parse_net(reader, config);
    } else {
      config.layers.push_back(detail::parse_layer(name, reader, i - 1));
    }
    detail::check_leftover_options(name, reader, config.warnings);
  }
  const auto shapes = infer_shapes(config, config.height, config.width);
  detail::check_heads(config, shapes);
  detail::check_decode(config);
  return config;
}

/// Reads a Darknet cfg file of at most 4 MiB; errors as parse_network_config() and read_text_file().
[[nodiscard]] inline NetworkConfig read_network_config(const std::string& path) {
  return parse_network_config(read_text_file(path, std::uint64_t(4) << 20U), path);
}

}  // namespace tapestry::detect
