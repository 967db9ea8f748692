#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/geometry/carla_pose.hpp>
#include <tapestry/image/letterbox.hpp>
#include <utility>
#include <vector>

#include "../inputs.hpp"
#include "../program.hpp"
#include "../run_folder.hpp"
#include "../run_manifest.hpp"
#include "../run_texture.hpp"
#include "../settings.hpp"
#include "measurement.hpp"
#include "protocols.hpp"
#include "report.hpp"

namespace tapestry::shell {

/// What evaluate was asked for, once a run's settings are adopted.
struct ProtocolRequest {
  ProtocolSettings settings;
  SceneSettings scene;
  DetectorSettings detector;
  std::string run;  ///< folder of the camouflage; empty: the plain car alone
  std::uint64_t seed = 1;
  std::string output;  ///< folder; nothing is written when empty
};

namespace detail {

/// What the outcomes in a folder depend on.
inline Json settings_of(const ProtocolRequest& request) {
  Json options;
  add_json(options, request.scene);
  for (const char* unused : {"frames", "scenes", "mask"}) options.erase(unused);
  add_json(options, request.detector);
  options["background"] = request.settings.background;
  options["quick"] = request.settings.quick;
  options["clean-only"] = request.run.empty();
  if (!request.run.empty()) options["controls"] = request.settings.controls;
  options["seed"] = request.seed;
  auto paths = input_paths(request.scene, request.detector, {});
  if (!request.run.empty()) paths.push_back(request.run + "/texture.npz");
  return {{"program", "evaluate"},
          {"version", TAPESTRY_VERSION_TEXT},
          {"protocol", request.settings.protocol},
          {"options", options},
          {"inputs", input_hashes(paths)}};
}

/// What differs between the settings of two measurements, by name.
inline std::string differences(const Json& saved, const Json& own) {
  std::string text;
  const auto compare = [&](const std::string& name, const Json& was, const Json& now) {
    if (was != now)
      text += (text.empty() ? "" : ", ") + name + " (was " + was.dump() + ", now " + now.dump() + ")";
  };
  for (const char* name : {"version", "protocol"}) compare(name, saved[name], own[name]);
  const auto option = [](const Json& of, const std::string& name) {
    const char* const lacking = value_when_lacking(name);
    return of["options"].value(name, lacking == nullptr ? Json() : Json(lacking));
  };
  for (const auto& [name, value] : own["options"].items()) compare("--" + name, option(saved, name), value);
  for (const auto& [name, value] : saved["options"].items())
    if (!own["options"].contains(name)) compare("--" + name, value, option(own, name));
  for (const auto& names :
       {names_of_missing(own["inputs"], saved["inputs"]), names_of_missing(saved["inputs"], own["inputs"])})
    if (text.empty() && !names.empty()) text = "inputs: " + names;
  return text;
}

/// A new folder gets the settings; one with others is refused.
inline void settle_folder(const std::string& folder, const Json& settings) {
  const std::string path = folder + "/settings.json";
  if (!is_there(path, ErrorKind::malformed)) {
    write_text(path, exact_text(settings) + "\n");
    return;
  }
  const Json saved = read_json_file(path);
  if (!saved.is_object() || saved.value("program", Json()) != "evaluate" || !saved.contains("version") ||
      !saved.contains("protocol") || !saved.contains("options") || !saved["options"].is_object() ||
      !saved.contains("inputs") || !saved["inputs"].is_array())
    throw FileError(ErrorKind::malformed, {path, "", "not the settings of a measurement of evaluate"});
  if (nlohmann::json(saved) == nlohmann::json(settings)) return;  // whatever the order of their members
  throw Error(ErrorKind::in_use, folder + " holds a measurement with other settings: " +
                                     differences(saved, settings) + "; give another --output");
}

struct ProtocolInputs {
  Detector detector;
  Car car;
  std::vector<evaluate::Control<float>> textures;  ///< the clean one first
};

inline ProtocolInputs load_protocol_inputs(const Protocol& protocol, ProtocolRequest& request) {
  fill_in_bundled(request.scene);
  fill_in_bundled(request.detector);
  ProtocolInputs inputs{load_detector(request.detector), load_car(request.scene), {}};
  print_warnings(inputs.detector.warnings);
  print_warnings(inputs.car.warnings);
  auto& car = inputs.car.painted;
  car.mesh = geometry::normalise_mesh(std::move(car.mesh));
  inputs.textures.push_back({"clean", camouflage::own_colours<float>(car)});
  if (!request.run.empty()) {
    auto colours = read_colours(request.run + "/texture.npz", inputs.textures.front().colours.shape(0));
    auto controls = request.settings.controls == "all"
                        ? evaluate::make_controls(car, colours, request.seed)
                        : evaluate::matched_controls(car, colours, request.seed);
    inputs.textures.push_back({"adversarial", std::move(colours)});
    for (auto& control : controls) inputs.textures.push_back(std::move(control));
  }
  if (protocol.change) inputs.textures.push_back({no_car_name, {}});
  return inputs;
}

/// What stands under every table.
inline std::vector<std::string> notes_of(const Protocol& protocol, const ProtocolResult& result,
                                         const ProtocolRequest& request,
                                         const detect::Detector<float>& network) {
  const auto number = evaluate::detail::short_number;
  const auto& background = request.settings.background;
  std::vector<std::string> notes{"Measured: " + std::to_string(result.whole.measured) + " of " +
                                 std::to_string(protocol.frames.size()) + " frames" +
                                 (result.whole.left_out > 0
                                      ? "; " + std::to_string(result.whole.left_out) +
                                            " are left out, for nothing of the car shows in them" +
                                            (protocol.change ? ", or too little to hide the share" : "")
                                      : "") +
                                 "."};
  if (request.settings.quick) notes.push_back("--quick: fewer views than the paper's; intervals are wider.");
  notes.insert(notes.end(), protocol.notes.begin(), protocol.notes.end());
  notes.push_back(
      "Distances are from the car's middle, in units of which its half length is 1; half of the field of "
      "view is " +
      number(evaluate::protocol_half_fov_deg) + " degrees. The paper states neither; its pictures fit both.");
  notes.push_back(
      "Found: a box of class " + request.detector.class_name + ", confidence above " +
      number(request.detector.confidence) + ", after suppression at IoU " + number(request.detector.nms) +
      ", that overlaps the box around the car's silhouette by IoU >= 0.5. Attack success counts the frames "
      "that are found in clean and not with the texture; where none is found in clean it is not defined "
      "(-). Brackets: 95 % by Wilson.");
  notes.push_back("Input " + std::to_string(network.input_width()) + "x" +
                  std::to_string(network.input_height()) + " pixels, " +
                  std::to_string(request.scene.samples) + "x" + std::to_string(request.scene.samples) +
                  " samples a pixel, background " + number(background[0]) + " " + number(background[1]) +
                  " " + number(background[2]) + ", seed " + std::to_string(request.seed) + ".");
  return notes;
}

inline void write_report(const std::string& folder, const Protocol& protocol, const ProtocolResult& result,
                         const std::vector<std::string>& notes, const Json& settings) {
  const std::string stem = folder + "/" + protocol.name;
  write_text(stem + ".csv", protocol_csv(protocol, result));
  write_text(stem + ".json", report_text(protocol_json(protocol, result, notes, settings)));
  write_text(stem + ".md", protocol_markdown(protocol, result, notes));
  write_text(stem + ".svg", figure_svg(protocol.figure(protocol, result)));
  write_text(stem + ".html", protocol_html(protocol, result, notes));
}

/// Prints what it took, and writes it beside the report, whose files are the same for every run.
inline void tell_cost(const std::string& folder, double seconds, const ProtocolMeasurement& measurement,
                      std::size_t textures) {
  std::cout << "this process: " << fixed(seconds, 1) << " s for " << measurement.frames_done()
            << " frames, peak memory " << fixed(peak_mib(), 0) << " MiB, " << thread_count()
            << (thread_count() == 1 ? " thread\n" : " threads\n");
  if (folder.empty()) return;
  write_text(folder + "/cost.json", report_text({{"seconds", seconds},
                                                 {"frames", measurement.frames_done()},
                                                 {"pictures", measurement.frames_done() * textures},
                                                 {"peak_mib", peak_mib()},
                                                 {"threads", thread_count()}}));
}

inline evaluate::ProtocolPicture picture_of(const ProtocolRequest& request, const Detector& detector) {
  const auto& background = request.settings.background;
  return {detector.network->input_height(),
          detector.network->input_width(),
          request.scene.samples,
          detector.fit,
          {background[0], background[1], background[2]}};
}

inline ProtocolResult result_of(const Protocol& protocol,
                                const std::vector<evaluate::Control<float>>& textures, bool has_camouflage,
                                const evaluate::ProtocolOutcomes& outcomes) {
  ProtocolResult result;
  for (const auto& texture : textures) result.textures.push_back(texture.name);
  result.has_camouflage = has_camouflage;
  result.cells = evaluate::cells_of(protocol.table, protocol.frames, outcomes);
  result.whole = evaluate::cell_of(outcomes, [](std::size_t) { return true; });
  return result;
}

}  // namespace detail

/// Measures what a protocol asks for, prints its table and writes NAME.csv, .json, .md, .svg and .html.
/// Killed at any moment, the same command goes on where it was.
///
/// \returns  the exit code
inline int evaluate_protocol(ProtocolRequest request) {
  const auto start = std::chrono::steady_clock::now();
  const StopSignal stop_signal;
  const Protocol protocol = make_protocol(request.settings, request.seed);
  const auto inputs = detail::load_protocol_inputs(protocol, request);
  const auto& network = *inputs.detector.network;
  const std::size_t class_index = class_index_of(request.detector, inputs.detector);
  const Json settings = detail::settings_of(request);
  const std::string& folder = request.output;
  std::optional<RunFolder> claim;
  evaluate::ProtocolOutcomes outcomes(protocol.frames.size(), inputs.textures.size());
  const std::string path = folder.empty() ? "" : folder + "/outcomes.npz";
  if (!folder.empty()) {
    claim.emplace(folder, !is_there(folder, ErrorKind::write));
    detail::settle_folder(folder, settings);
    if (is_there(path, ErrorKind::malformed))
      outcomes = read_outcomes(path, outcomes.frame_count(), outcomes.texture_count());
  }
  ProtocolMeasurement measurement(protocol, inputs.textures, path, std::move(outcomes));
  evaluate::Meter<float> meter(network, class_index, {request.detector.confidence, request.detector.nms, {}});
  try {
    measurement.run(inputs.car.painted, detail::picture_of(request, inputs.detector), meter);
  } catch (const Stopped&) {
    std::cerr << "\nstopped with " << measurement.frames_pending() << " of " << protocol.frames.size()
              << " frames to go; " << (folder.empty() ? "nothing was written" : "the same command goes on")
              << '\n';
    return StopSignal::exit_code();
  }
  const ProtocolResult result =
      detail::result_of(protocol, inputs.textures, !request.run.empty(), measurement.outcomes());
  const auto notes = detail::notes_of(protocol, result, request, network);
  std::cout << protocol_text(protocol, result, notes);
  if (!folder.empty()) detail::write_report(folder, protocol, result, notes, settings);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  detail::tell_cost(folder, seconds, measurement, inputs.textures.size());
  if (!folder.empty()) std::cout << "written: " << folder << "/" << protocol.name << ".html\n";
  return 0;
}

}  // namespace tapestry::shell
