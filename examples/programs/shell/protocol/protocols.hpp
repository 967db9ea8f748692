#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "occlusion.hpp"
#include "protocol.hpp"
#include "settings.hpp"
#include "views.hpp"

namespace tapestry::shell {

/// A protocol's name, what it measures, and how it is made of settings and a seed.
struct ProtocolEntry {
  std::string name;
  std::string help;
  std::function<Protocol(const ProtocolSettings&, std::uint64_t seed)> make;
};

inline const std::vector<ProtocolEntry>& protocols() {
  static const std::vector<ProtocolEntry> entries{
      {"views", "4,320 views from all around, by azimuth and distance (table 3)", views_protocol},
      {"occlusion", "1,080 views of a partly hidden car, by hidden share and distance (table 4)",
       occlusion_protocol}};
  return entries;
}

inline std::vector<std::string> protocol_names() {
  std::vector<std::string> names;
  for (const auto& entry : protocols()) names.push_back(entry.name);
  return names;
}

/// Names and what they measure, for --help.
inline std::string protocol_help() {
  std::string help;
  for (const auto& entry : protocols()) help += (help.empty() ? "" : "; ") + entry.name + ": " + entry.help;
  return help;
}

/// \param settings  which require_sound() has checked
inline Protocol make_protocol(const ProtocolSettings& settings, std::uint64_t seed) {
  for (const auto& entry : protocols())
    if (entry.name == settings.protocol) return entry.make(settings, seed);
  throw Error(ErrorKind::usage, "--protocol is '" + settings.protocol + "', which is unknown");
}

}  // namespace tapestry::shell
