#pragma once

#include "inputs.hpp"
#include "run_manifest.hpp"

namespace tapestry::shell {

namespace detail {
/// The path of a folder in a standard form.
inline std::string plain_folder(const std::filesystem::path& folder) {
  return (folder / "").lexically_normal().string();
}

/// Whether an option of a run named this file.
inline bool is_named(const Json& options, const std::string& path) {
  return std::ranges::any_of(options, [&](const Json& value) {
    return value == path || (value.is_array() && std::ranges::find(value, Json(path)) != value.end());
  });
}
}  // namespace detail

/// The inputs of a camouflage run that a measurement has read again, by its ledger, and whose bytes differ
/// from the run's manifest. An input that an option replaces is not listed, because it has another path.
/// Frames and material files that are new or missing are listed, too; no reader would notice them. Frames
/// that are there but were not read are not listed: a quick measurement leaves some out.
///
/// \param manifest  of the run
/// \param frames all frames to measure on; none if only the car is rendered
/// \param expected  inputs of the run, and its paint if that is measured
inline std::vector<ChangedInput> changed_since(const Json& manifest, const Json& expected,
                                               const SceneSettings& scene, const Car& car,
                                               const std::vector<std::string>& frames) {
  const Json& options = manifest["options"];
  const auto setting = [&](const char* name) { return options.value(name, std::string()); };
  const std::string folder = setting("frames");
  const auto lies_in = [&](const std::string& path, const std::string& below) {
    return detail::plain_folder(io::path_of(path).parent_path()) == detail::plain_folder(folder + below);
  };
  const bool same_frames = !frames.empty() && scene.frames == folder;
  const bool in_parts = same_frames && frames.front().ends_with(".json");  // with masks of their own
  const auto is_measured_frame = [&](const std::string& path) {
    if (in_parts && (lies_in(path, "/masks") || lies_in(path, "/test/masks"))) return true;
    return is_frame_file(path) && (lies_in(path, "") || lies_in(path, "/test"));
  };
  const auto is_picture = [](const std::string& path) {
    return is_frame_file(path) || io::has_picture_name(path);
  };
  const auto is_material = [&](const ChangedInput& input) {
    return input.found.empty()
               ? !detail::is_named(options, input.path) && !is_picture(input.path)
               : std::ranges::find(car.material_files, input.path) != car.material_files.end();
  };
  auto changed = changed_inputs(expected, recorded_inputs());
  std::erase_if(changed, [&](const ChangedInput& input) {
    if (!input.expected.empty() && !input.found.empty()) return false;
    const bool is_left_out = input.found.empty() && is_there(input.path, ErrorKind::malformed);
    return !(same_frames && is_measured_frame(input.path) && !is_left_out) &&
           !(scene.mesh == setting("mesh") && is_material(input));
  });
  return changed;
}

/// Treatment of changed inputs: the run whose inputs are compared, and whether changes are accepted.
struct RunInputs {
  std::string run{};  ///< its folder; empty: no comparison
  bool accepts_changes = false;
  bool reads_paint = true;
};

/// The inputs of a run, and its paint as the run wrote it, if its manifest states that.
inline Json expected_inputs(const Json& manifest, const RunInputs& inputs) {
  Json expected = manifest["inputs"];
  const std::string name = "texture.npz", path = inputs.run + "/" + name;
  const Json outputs = manifest.value("outputs", Json());
  if (!inputs.reads_paint || !outputs.is_object() || !outputs.contains(name)) return expected;
  io::InputLedger::note(path);
  expected.push_back({{"path", path}, {"sha256", outputs[name]}});
  return expected;
}

/// Returns changed_since(), and adds a warning for each accepted change to `warnings`.
/// \throws Error (in_use) naming the changes, unless they are accepted
inline std::vector<ChangedInput> require_run_inputs(const RunInputs& inputs, const SceneSettings& scene,
                                                    const Car& car, const std::vector<std::string>& frames,
                                                    std::vector<std::string>& warnings) {
  if (inputs.run.empty()) return {};
  const Json manifest = read_manifest(inputs.run);
  auto changed = changed_since(manifest, expected_inputs(manifest, inputs), scene, car, frames);
  if (changed.empty()) return changed;
  const std::string words = inputs.run + ": inputs have changed since the run: " + text_of(changed);
  if (!inputs.accepts_changes)
    throw Error(ErrorKind::in_use,
                words + "; put them back, give another input by its option, or --accept-changed-inputs");
  warnings.push_back(words);
  return changed;
}

inline Json json_of(const std::vector<ChangedInput>& changed) {
  const auto hash = [](const std::string& sha256) { return sha256.empty() ? Json() : Json(sha256); };
  Json json = Json::array();
  for (const auto& input : changed)
    json.push_back({{"path", input.path}, {"expected", hash(input.expected)}, {"found", hash(input.found)}});
  return json;
}

}  // namespace tapestry::shell
