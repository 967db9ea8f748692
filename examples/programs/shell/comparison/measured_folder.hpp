#pragma once
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/protocol_outcomes.hpp>
#include <utility>
#include <vector>

#include "../protocol/inputs.hpp"
#include "../protocol/measurement.hpp"
#include "../protocol/protocols.hpp"
#include "../protocol/result.hpp"
#include "../run_folder.hpp"

namespace tapestry::shell {

/// A folder that evaluate --protocol has written.
struct MeasuredFolder {
  std::string path;
  Protocol protocol;
  evaluate::ProtocolOutcomes outcomes;
  std::vector<std::string> textures;  ///< names, as in ProtocolResult
  std::string run;                    ///< folder of the camouflage; empty without one
  std::string detector{};             ///< name of the first
  std::vector<std::string> frames{};  ///< SHA-256 of each photograph; none of renders

  [[nodiscard]] bool has_camouflage() const { return !run.empty(); }
};

namespace detail {

/// The member of a JSON object with this type.
/// \throws FileError (malformed) if there is none
template <class Value>
Value member_of(const Json& json, const char* name, const std::string& path) {
  try {
    return json.at(name).get<Value>();
  } catch (const nlohmann::json::exception&) {
    throw FileError(ErrorKind::malformed, {path, "", std::string("no ") + name + " of a measurement"});
  }
}

/// Settings of a measurement, as evaluate writes them.
struct SavedMeasurement {
  ProtocolSettings settings;
  std::uint64_t seed = 1;
  std::vector<std::string> weights{};  ///< of every detector, the run's own first
  std::string run{};
  std::vector<std::string> frames{};  ///< SHA-256
};

inline SavedMeasurement read_saved_measurement(const std::string& path) {
  const Json json = read_json_file(path);
  const auto options = member_of<Json>(json, "options", path);
  SavedMeasurement saved;
  saved.settings.protocol = member_of<std::string>(json, "protocol", path);
  saved.settings.quick = member_of<bool>(options, "quick", path);
  saved.seed = member_of<std::uint64_t>(options, "seed", path);
  if (options.contains("noise-draws"))
    saved.settings.noise_draws = member_of<std::size_t>(options, "noise-draws", path);
  saved.weights = {member_of<std::string>(options, "weights", path)};
  if (options.contains("further-weights"))
    for (auto& weights : member_of<std::vector<std::string>>(options, "further-weights", path))
      saved.weights.push_back(std::move(weights));
  for (const Json& input : member_of<Json>(json, "inputs", path)) {
    const fs::path file = member_of<std::string>(input, "path", path);
    if (file.filename() == "texture.npz")
      saved.run = file.parent_path().string();
    else if (file.extension() == ".npz")
      saved.frames.push_back(member_of<std::string>(input, "sha256", path));
  }
  return saved;
}

}  // namespace detail

/// Reads the folder of a finished measurement.
/// \throws FileError: unreadable, malformed, or mismatch if its files do not belong together
inline MeasuredFolder read_measured_folder(const std::string& folder) {
  const std::string path = folder + "/settings.json";
  const auto saved = detail::read_saved_measurement(path);
  MeasuredFolder measured{folder, {}, {}, {}, saved.run};
  const std::string report = folder + "/" + saved.settings.protocol + ".json";
  measured.textures = detail::member_of<std::vector<std::string>>(read_json_file(report), "textures", report);
  const auto noise = std::ranges::find(measured.textures, std::string(evaluate::matched_noise_name));
  const std::size_t extra_draws = noise == measured.textures.end() ? 0 : saved.settings.noise_draws - 1;
  const auto subject = detail::subject_of(saved.weights, saved.frames.size());
  measured.detector = subject.detectors.front();
  measured.frames = saved.frames;
  measured.protocol = protocol_by_name(saved.settings.protocol).make(saved.settings, saved.seed, subject);
  measured.outcomes = read_outcomes(folder + "/outcomes.npz", measured.protocol.frames.size(),
                                    measured.textures.size() + extra_draws);
  measured.outcomes.draws.assign(measured.textures.size(), 1);
  if (noise != measured.textures.end())
    measured.outcomes.draws[static_cast<std::size_t>(noise - measured.textures.begin())] += extra_draws;
  return measured;
}

}  // namespace tapestry::shell
