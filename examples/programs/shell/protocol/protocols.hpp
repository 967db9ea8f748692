#pragma once
#include "attention.hpp"
#include "physical.hpp"
#include "traffic.hpp"
#include "views.hpp"

namespace tapestry::shell {
enum class Surroundings : std::uint8_t { plain, streets, photographs };

/// A protocol's name, a sentence for help, and the function that makes it from settings and a seed.
struct ProtocolEntry {
  std::string name;
  std::string sentence;
  std::function<Protocol(const ProtocolSettings&, std::uint64_t seed, const ProtocolSubject&)> make;
  Surroundings surroundings = Surroundings::plain;
};

inline const std::vector<ProtocolEntry>& protocols() {
  static const std::vector<ProtocolEntry> entries{
      {"digital", "held-out photographs, with every control and each detector, table 1", digital_protocol,
       Surroundings::photographs},
      {"physical",
       "72 views in drawn streets, each printed and photographed twice, and as it is, table 2, simulated",
       physical_protocol, Surroundings::streets},
      {"attention", "heat maps of detectors on held-out photographs, and their share on the car",
       attention_protocol, Surroundings::photographs},
      {"views", "4,320 views from all around, by azimuth and distance, table 3", views_protocol},
      {"occlusion", "1,080 views of a partly hidden car, by hidden share and distance, table 4",
       occlusion_protocol},
      {"traffic", "324 views in drawn streets of a car behind other vehicles, by hidden share and distance",
       traffic_protocol, Surroundings::streets}};
  return entries;
}

/// The protocol with this name.
/// \throws Error (usage) if there is none
inline const ProtocolEntry& protocol_by_name(const std::string& name) {
  for (const auto& entry : protocols())
    if (entry.name == name) return entry;
  throw Error(ErrorKind::usage, "--protocol is '" + name + "', which is unknown");
}

inline bool has_surroundings(const std::string& name, Surroundings surroundings) {
  return std::ranges::any_of(protocols(), [&](const ProtocolEntry& entry) {
    return entry.name == name && entry.surroundings == surroundings;
  });
}

/// Whether a protocol measures photographs, not renders; false for an empty or unknown name.
inline bool is_on_photographs(const std::string& name) {
  return has_surroundings(name, Surroundings::photographs);
}

/// Whether a protocol's pictures show the car alone; true for an empty or unknown name, too.
inline bool is_before_plain_background(const std::string& name) {
  return !is_on_photographs(name) && !has_surroundings(name, Surroundings::streets);
}
}  // namespace tapestry::shell
