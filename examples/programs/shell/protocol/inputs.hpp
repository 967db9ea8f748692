#pragma once
#include <unordered_set>

#include "../camouflage_source.hpp"
#include "../measured_controls.hpp"
#include "../run_inputs.hpp"
#include "protocols.hpp"

namespace tapestry::shell {

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

/// Inputs of a protocol's measurement.
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
