#pragma once
#include <tapestry/detect/network_config.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/darknet/known_keys.hpp>
#include <tapestry/io/detail/darknet/layer_parsing.hpp>

namespace tapestry::io {
namespace detail {

detect::NetworkConfig parse_cfg(std::string_view text, const std::string& name) {
  auto sections = cfg_sections(text, name);
  if (sections.empty()) throw detect::cfg_error(name, 1, "no [net] section", "a Darknet cfg file");
  detect::NetworkConfig config;
  config.name = name;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const bool is_net = sections[i].name == "net" || sections[i].name == "network";
    if (is_net != (i == 0))
      throw detect::cfg_error(name, sections[i].line, i == 0 ? "no [net] section" : "a second [net] section",
                              i == 0 ? "[net] first" : "one",
                              "[" + std::string(sections[i].name.substr(0, 40)) + "]");
    SectionReader reader(name, sections[i]);
    check_repeated_options(name, reader, config.warnings);
    if (is_net) {
      parse_net(reader, config);
    } else {
      config.layers.push_back(parse_layer(name, reader, i - 1));
    }
    check_leftover_options(name, reader, config.warnings);
  }
  return config;
}

}  // namespace detail

detect::NetworkConfig parse_network_config(std::string_view text, const std::string& name) {
  auto config = detail::parse_cfg(text, name);
  detect::check_network(config);
  return config;
}

detect::NetworkConfig parse_classifier_config(std::string_view text, const std::string& name) {
  auto config = detail::parse_cfg(text, name);
  detect::check_classifier(config);
  return config;
}

}  // namespace tapestry::io
