#pragma once
#include <unordered_set>
#include "../camouflage_source.hpp"
#include "../measured_controls.hpp"
#include "protocols.hpp"

namespace tapestry::shell {
namespace detail {
/// The path of a folder in a standard form.
inline std::string plain_folder(const std::filesystem::path& folder) {
  return (folder / "").lexically_normal().string();
}

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

/// Options of evaluate for a protocol, once a run's settings are adopted.
struct ProtocolRequest {
  ProtocolSettings settings;
  SceneSettings scene;
  DetectorSettings detector;
  CamouflageSource camouflage;
  std::uint64_t seed = 1;
  std::string output;          ///< folder; nothing is written when empty
  std::string pictures;        ///< folder for every picture; empty: none
  RunInputs run_inputs{};      ///< files that must equal those of the run
  std::size_t trained_on = 0;  ///< number of its photographs that the camouflage was made with
};

struct ProtocolInputs {
  std::vector<FurtherDetector> detectors{};  ///< that of --weights first
  Car car{};
  std::optional<raster::PaintedMesh> reshaped{};        ///< the car in the run's shape, see reshaped_car()
  bool posed = false;                                   ///< of the photographs, see FrameLists
  std::vector<std::string> photographs{};               ///< paths; none if only the car is rendered
  std::optional<camouflage::PhotoLight> photo_light{};  ///< rule that estimates the light, if any
  bool keeps_photograph = true;                         ///< see --unpainted
  MaskRule mask{};                                      ///< of the photographs
  std::vector<ChangedInput> changed{};                  ///< since the run, and accepted
};

/// The file's name in a form that fits a table; for a file of harden, its run's folder.
inline std::string detector_name(const std::string& weights) {
  const fs::path path = io::path_of(weights);
  std::string name = path.stem().string();
  if (name == "hardened" && path.has_parent_path())
    name = path.parent_path().filename().string() + " hardened";
  std::ranges::replace_if(
      name, [](char c) { return c == ',' || c == '|' || c == '"'; }, '_');
  return name;
}

/// The number of these photographs that the camouflage in a folder was optimised or validated on; their
/// bytes are compared.
/// \param hashes  of every input of the measurement, see recorded_inputs()
inline std::size_t trained_on(const std::string& run, const std::vector<std::string>& photographs,
                              const Json& hashes) {
  const Json manifest = read_manifest(run);
  std::unordered_set<std::string> learnt;
  for (const auto& input : manifest["inputs"])
    if (!manifest.value("held_out", false) ||
        io::path_of(input["path"].get<std::string>()).parent_path().filename() == "train")
      learnt.insert(input.value("sha256", std::string()));
  const std::unordered_set<std::string> own(photographs.begin(), photographs.end());
  return static_cast<std::size_t>(std::ranges::count_if(hashes, [&](const Json& input) {
    return own.contains(input["path"].get<std::string>()) &&
           learnt.contains(input["sha256"].get<std::string>());
  }));
}

inline void load_car_and_detectors(ProtocolRequest& request, ProtocolInputs& inputs) {
  const auto& settings = request.settings;
  if (is_on_photographs(settings.protocol)) {
    // Heat maps use the last layer that all heads depend on.
    const std::vector<std::string> layers(settings.protocol == "attention" ? 1 : 0);
    auto loaded = load_inputs(request.scene, request.detector, layers);
    inputs.photographs = settings.quick ? thinned(loaded.frames.test, quick_photographs) : loaded.frames.test;
    note_frames(inputs.photographs, loaded.mask);
    inputs.changed = require_run_inputs(request.run_inputs, request.scene, loaded.car, inputs.photographs,
                                        loaded.warnings);
    print_warnings(loaded.warnings);
    inputs.car = std::move(loaded.car);
    inputs.posed = loaded.frames.posed;
    inputs.photo_light = std::move(loaded.photo_light);
    inputs.keeps_photograph = loaded.keeps_photograph;
    inputs.mask = std::move(loaded.mask);
    inputs.detectors.push_back({std::move(loaded.detector), loaded.class_index});
    std::vector<std::string> warnings;
    for (const auto& path : settings.further_weights)
      inputs.detectors.push_back(
          load_further_detector("--further-weights", path, request.detector, warnings, layers));
    print_warnings(warnings);
    return;
  }
  fill_in_bundled(request.scene);
  fill_in_bundled(request.detector);
  std::vector<std::string> warnings;
  inputs.detectors.push_back({load_first_detector(request.detector, warnings)});
  FurtherDetector& first = inputs.detectors.back();
  first.class_index = first.detector.class_index(request.detector.class_name);
  inputs.car = load_car(request.scene);
  inputs.changed = require_run_inputs(request.run_inputs, request.scene, inputs.car, {}, inputs.car.warnings);
  print_warnings(warnings);
  print_warnings(inputs.car.warnings);
  inputs.car.painted.mesh = geometry::normalise_mesh(std::move(inputs.car.painted.mesh));
}

/// The textures to measure: clean, the camouflage and its controls; several draws of one side by side.
/// \param draws_in_pictures  whether pictures are views with a paint, so that noise can be drawn in them
inline std::vector<evaluate::Control> textures_of(const Car& loaded, const ProtocolRequest& request,
                                                  bool draws_in_pictures) {
  const auto& car = loaded.painted;
  std::vector<evaluate::Control> textures{
      {"clean", camouflage::without_paint(camouflage::own_colours<float>(car))}};
  if (!request.camouflage.is_given()) return textures;
  auto paint = read_camouflage(request.camouflage, loaded, request.scene.mesh);
  const std::size_t draws = request.settings.noise_draws;
  auto controls = measured_controls(request.settings.controls, car, paint, request.seed, draws);
  if (draws_in_pictures) {
    const auto after =
        std::ranges::find(controls, std::string(evaluate::shuffled_patches_name), &evaluate::Control::name);
    controls.insert(after, {evaluate::picture_noise_name, paint});
  }
  textures.push_back({"adversarial", std::move(paint)});
  for (auto& control : controls) textures.push_back(std::move(control));
  return textures;
}

/// The car in the shape that the run has optimised; nothing if the run has kept the shape. Offsets are in
/// lengths of the car: a normalised car is moved at the original's scale, and not normalised again.
inline std::optional<raster::PaintedMesh> reshaped_car(const raster::PaintedMesh& car,
                                                       const ProtocolRequest& request) {
  const auto offsets = read_offsets_of(request.camouflage, car);
  if (offsets.size() == 0) return std::nullopt;
  return camouflage::reshaped(car, offsets);
}

/// \param weights  files of the detectors
inline ProtocolSubject subject_of(const std::vector<std::string>& weights, std::size_t photographs) {
  ProtocolSubject subject{{}, photographs};
  for (const auto& path : weights) {
    std::string name = detector_name(path);
    while (std::ranges::count(subject.detectors, name) > 0) name += "'";
    subject.detectors.push_back(name);
  }
  return subject;
}

inline ProtocolSubject subject_of(const ProtocolRequest& request, const ProtocolInputs& inputs) {
  std::vector<std::string> weights{request.detector.weights};
  weights.insert(weights.end(), request.settings.further_weights.begin(),
                 request.settings.further_weights.end());
  return subject_of(weights, inputs.photographs.size());
}
}  // namespace tapestry::shell
