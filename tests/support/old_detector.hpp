#pragma once
#include "../../examples/programs/shell/old_detector.hpp"

namespace tapestry::test {
/// A file of this header, in JSON, and these bytes behind it; neither need be sound.
inline std::string old_file(const std::string& header, const std::string& numbers = "") {
  std::string bytes;
  for (std::size_t i = 0; i < 8; ++i) bytes += static_cast<char>(header.size() >> (8 * i) & 0xFFU);
  return bytes + header + numbers;
}

/// The header of a detector in the form of releases before 0.3.
inline nlohmann::json old_header(const detect::DarknetModel<float>& model, const std::string& cfg) {
  nlohmann::json header{{"__metadata__", io::fields_of({cfg, model.images_seen()})}};
  for (const auto& block : model.layout().blocks) {
    auto [name, entry] = shell::old_entry(model.config(), block);
    header[name] = entry;
  }
  return header;
}

/// The numbers behind it.
inline std::string old_numbers(const detect::DarknetModel<float>& model) {
  return {reinterpret_cast<const char*>(model.parameters().data()), 4 * model.layout().count};
}

inline std::string old_detector(const detect::DarknetModel<float>& model, const std::string& cfg) {
  return old_file(old_header(model, cfg).dump(), old_numbers(model));
}
}  // namespace tapestry::test
