#pragma once
#include "../run_origin.hpp"
#include "notes.hpp"
#include "report.hpp"
#include "result.hpp"
#include "source.hpp"

namespace tapestry::shell {
/// The run of a camouflage: its folder, seed and class, and the files of the detectors that it was optimised
/// against.
inline Json run_json(const std::string& run) {
  const Json manifest = read_manifest(run);
  Json detectors = Json::array();
  for (const Json& input : manifest["inputs"])
    for (const Json& role : input.value("read_as", Json::array()))
      if (role.get<std::string>().starts_with(role_of_detector())) {
        detectors.push_back({{"path", input["path"]}, {"sha256", input["sha256"]}});
        break;
      }
  return {{"folder", run},
          {"seed", manifest.value("seed", Json())},
          {"class", manifest["options"].value("class", Json())},
          {"detectors", detectors}};
}

/// Settings that the outcomes in a folder depend on.
inline Json settings_of(const ProtocolRequest& request, const ProtocolInputs& inputs) {
  const bool on_photographs = is_on_photographs(request.settings.protocol);
  Json options;
  add_json(options, request.scene);
  options.erase("scenes");
  if (!on_photographs)
    for (const char* unused : {"frames", "mask", "segmenter", "light", "unpainted"}) options.erase(unused);
  add_json(options, request.detector);
  if (request.settings.protocol == "attention") options["heat-map-kind"] = request.settings.heat_map_kind;
  if (on_photographs)
    options["further-weights"] = request.settings.further_weights;
  else if (is_before_plain_background(request.settings.protocol))
    options["background"] = request.settings.background;
  options["quick"] = request.settings.quick;
  options["clean-only"] = !request.camouflage.is_given();
  if (request.camouflage.is_given()) {
    options["controls"] = request.settings.controls;
    options["noise-draws"] = request.settings.noise_draws;
  }
  options["seed"] = request.seed;
  if (!request.pictures.empty()) options["in-bytes"] = true;
  Json settings{{"program", "evaluate"},
                {"protocol", request.settings.protocol},
                {"options", options},
                {"inputs", recorded_inputs()}};
  for (const auto& fact : facts_of_bits) settings[fact] = computed_by_json()[fact];
  if (!request.camouflage.run.empty()) settings["run"] = run_json(request.camouflage.run);
  if (!request.camouflage.picture.empty()) settings["paint"] = request.camouflage.picture;
  if (!inputs.changed.empty()) settings["changed_inputs"] = json_of(inputs.changed);
  return settings;
}

/// Writes the settings to a new folder; refuses a folder with other settings.
inline void settle_folder(const std::string& folder, const Json& settings) {
  const std::string path = folder + "/settings.json";
  if (!is_there(path, ErrorKind::malformed)) {
    Json kept = settings;
    kept["begun_in"] = begun_in(folder);
    write_text(path, exact_text(kept) + "\n");
    return;
  }
  Json saved = read_json_file(path);
  if (!saved.is_object() || saved.value("program", Json()) != "evaluate" || !saved.contains("version") ||
      !saved.contains("protocol") || !saved.contains("options") || !saved["options"].is_object() ||
      !saved.contains("inputs") || !saved["inputs"].is_array())
    throw malformed_file({path, "", "not the settings of a measurement of evaluate"});
  saved.erase("begun_in");
  for (const auto& fact : facts_of_bits)
    if (!saved.contains(fact)) saved[fact] = settings[fact];      // not stated by earlier versions
  if (nlohmann::json(saved) == nlohmann::json(settings)) return;  // members may be in any order
  throw Error(ErrorKind::in_use,
              folder + " holds a measurement with other settings: " +
                  differences(saved, settings, {"protocol", "changed_inputs"}, values_when_lacking()) +
                  "; give another --output");
}

inline void write_report(const std::string& folder, const Protocol& protocol, const ProtocolResult& result,
                         const std::vector<std::string>& notes, const Json& settings,
                         const evaluate::ProtocolOutcomes& outcomes) {
  const std::string stem = folder + "/" + protocol.name;
  MeasuredFrames frames;
  ViewList shown;
  if (!protocol.on_photographs) {
    frames = measured_frames(protocol, result, outcomes);
    std::vector<std::size_t> columns;
    for (const std::size_t texture : result.shown_textures())
      columns.push_back(outcomes.first_column(texture));
    shown = frames.list(columns);
    write_text(folder + "/frames.csv", views_csv(frames.list()));
  }
  write_text(stem + ".csv", protocol_csv(protocol, result));
  write_text(stem + ".json", report_text(protocol_json(protocol, result, notes, settings)));
  write_text(stem + ".md", protocol_markdown(protocol, result, notes));
  std::string latex;  // which needs the package booktabs
  for (const auto& table : all_tables(protocol, result)) latex += latex_of(table);
  write_text(stem + ".tex", latex);
  write_text(stem + ".svg", figure_svg(protocol.figure(protocol, result)));
  write_text(stem + ".html", protocol_html(protocol, result, notes, shown, settings["inputs"]));
}

/// Prints the time taken, and writes it to a file beside the report, whose other files are the same for every
/// run.
inline void tell_cost(const std::string& folder, double seconds, const ProtocolMeasurement& measurement,
                      std::size_t textures) {
  remark("this process: " + fixed(seconds, 1) + " s for " + std::to_string(measurement.frames_done()) +
         " frames, peak memory " + fixed(peak_mib(), 0) + " MiB, " + std::to_string(thread_count()) +
         (thread_count() == 1 ? " thread" : " threads"));
  if (folder.empty()) return;
  write_text(folder + "/cost.json", report_text({{"seconds", seconds},
                                                 {"frames", measurement.frames_done()},
                                                 {"pictures", measurement.frames_done() * textures},
                                                 {"peak_mib", peak_mib()},
                                                 {"threads", thread_count()}}));
}

/// A row for each photograph, detector and texture.
/// \param photographs  paths
inline std::string photographs_csv(const Protocol& protocol, const std::vector<std::string>& photographs,
                                   const ProtocolResult& result, const evaluate::ProtocolOutcomes& outcomes) {
  std::string text = "detector,texture,found,best_confidence,attention,fate,named,frame\n";
  const auto textures = column_names(result, outcomes);
  for (std::size_t frame = 0; frame < protocol.frames.size(); ++frame) {
    if (outcomes.state_of(frame) != evaluate::FrameState::measured) continue;
    const std::size_t column = protocol.frames[frame].column;
    for (std::size_t k = 0; k < textures.size(); ++k) {
      const auto fate = static_cast<evaluate::Fate>(outcomes.fate(frame, k));
      std::string named;
      if (fate != evaluate::Fate::lost)
        named = csv_field(class_name(outcomes.named(frame, k), result.names_of(column), "class "));
      text += csv_line(csv_field(protocol.table.columns[column]), csv_field(textures[k]),
                       outcomes.found(frame, k), outcomes.best_confidence(frame, k),
                       protocol.maps_attention ? csv_line(outcomes.attention(frame, k)) : "",
                       evaluate::fate_names[outcomes.fate(frame, k)], named,
                       csv_field(photographs[frame % photographs.size()]) + "\n");
    }
  }
  return text;
}

/// Writes photographs.csv of a protocol on photographs. \param photographs  paths
inline void write_photographs(const std::string& folder, const Protocol& protocol,
                              const std::vector<std::string>& photographs, const ProtocolResult& result,
                              const evaluate::ProtocolOutcomes& outcomes) {
  if (protocol.on_photographs)
    write_text(folder + "/photographs.csv", photographs_csv(protocol, photographs, result, outcomes));
}

/// The run's folder, and the outcomes that an earlier run with the same settings has saved there, unless it
/// begins again.
struct ProtocolFolder {
  std::string folder;  ///< empty for ranks that write nothing
  std::optional<RunFolder> claim{};
  evaluate::ProtocolOutcomes outcomes;

  ProtocolFolder(std::string path, const Json& settings, std::size_t frames,
                 const std::vector<evaluate::Control>& textures, bool begins_again)
      : folder(std::move(path)), outcomes(frames, textures.size()) {
    if (!folder.empty()) {
      claim.emplace(folder, !is_there(folder, ErrorKind::write));
      settle_folder(folder, settings);
      if (!begins_again && is_there(outcomes_path(), ErrorKind::malformed))
        outcomes = read_outcomes(outcomes_path(), frames, textures.size());
    }
    outcomes.draws = draws_of(textures);
    for_each_array(outcomes, [](const char*, auto& array) {
      Ranks::all().share(std::span(array.data(), array.size()));
    });
  }
  [[nodiscard]] std::string outcomes_path() const { return folder.empty() ? "" : folder + "/outcomes.npz"; }
};

[[nodiscard]] inline std::vector<evaluate::Meter> meters_of(const ProtocolInputs& inputs,
                                                            const ProtocolRequest& request) {
  std::vector<evaluate::Meter> meters;
  for (const auto& [detector, class_index] : inputs.detectors)
    meters.emplace_back(
        detector, class_index,
        evaluate::MeterSettings{request.detector.confidence, request.detector.nms, swept_thresholds});
  return meters;
}

/// Measures the remaining frames. \returns false if a signal stopped it
[[nodiscard]] inline bool has_measured(ProtocolMeasurement& measurement, const ProtocolSource& source,
                                       const Protocol& protocol, const std::string& folder) try {
  measurement.run(source);
  return true;
} catch (const Stopped&) {
  std::cerr << "\nstopped with " << measurement.frames_pending() << " of " << protocol.frames.size()
            << " frames to go; "
            << (folder.empty()               ? "nothing was written"
                : source.pictures != nullptr ? "the same command begins again"
                                             : "the same command goes on")
            << '\n';
  return false;
}

/// Adds a sheet of heat maps of each detector to the pictures of a result, where they are computed and shown.
inline void add_attention(const std::string& folder, const Protocol& protocol,
                          const std::vector<evaluate::Control>& textures,
                          const ProtocolMeasurement& measurement, const ProtocolSource& source,
                          const ProtocolInputs& inputs, const ProtocolRequest& request,
                          ProtocolResult& result) {
  if (!protocol.maps_attention || folder.empty()) return;
  for (std::size_t column = 0; column < inputs.detectors.size(); ++column)
    result.pictures.emplace_back(
        "Attention of " + protocol.table.columns[column] + ": " + result.shown_names(),
        io::png_file(
            folder + "/" + protocol.name + ".html",
            attention_sheet(column, protocol, result, textures, measurement.outcomes(), source,
                            inputs.detectors[column], heat_map_by_name(request.settings.heat_map_kind))));
}

/// The protocol of a request. \param inputs  must outlive the result
[[nodiscard]] inline Protocol protocol_of(const ProtocolRequest& request, const ProtocolInputs& inputs) {
  Protocol protocol = protocol_by_name(request.settings.protocol)
                          .make(request.settings, request.seed, subject_of(request, inputs));
  if (protocol.on_photographs) protocol.view_of = photograph_view(inputs);
  return protocol;
}

/// Facts for the labels of the pictures of a protocol: all that its tables need beside the detections.
inline Json facts_for_labels(const ProtocolRequest& request, const ProtocolInputs& inputs, Json settings,
                             const ProtocolResult& result, const std::vector<evaluate::Control>& textures,
                             std::vector<std::string> notes) {
  std::erase(notes, note_on_found(request.detector));
  settings["begun_in"] = begun_in(request.pictures);
  Json facts{{"inputs", settings["inputs"]},
             {"has_camouflage", result.has_camouflage},
             {"notes", notes},
             {"photographs", inputs.photographs}};
  for (const auto& texture : textures)
    facts["textures"].push_back({{"name", texture.name}, {"share_in_place", texture.share_in_place}});
  settings.erase("inputs");
  facts["settings"] = std::move(settings);
  return facts;
}

/// Measures a protocol, prints its table and writes NAME.csv, .json, .md, .tex, .svg and .html; for renders
/// also frames.csv, and for photographs photographs.csv. After an interruption the same command continues.
/// Under mpirun the frames are divided among the ranks; the files are the same for any number of them.
///
/// \returns  the exit code
inline int evaluate_protocol(ProtocolRequest request) {
  const auto start = std::chrono::steady_clock::now();
  const StopSignal stop_signal;
  ProtocolInputs inputs;
  load_car_and_detectors(request, inputs);
  const Protocol protocol = protocol_of(request, inputs);
  auto textures = textures_of(inputs.car, request, !protocol.photograph);
  if (!protocol.bare_name.empty()) textures.push_back({protocol.bare_name, {}});
  inputs.reshaped = reshaped_car(inputs.car.painted, request);
  auto meters = meters_of(inputs, request);
  const Json settings = settings_of(request, inputs);
  Ranks::all().require_same("settings and inputs", io::sha256(exact_text(settings)));
  if (protocol.on_photographs && !request.camouflage.run.empty())
    request.trained_on = trained_on(request.camouflage.run, inputs.photographs, settings["inputs"]);
  const bool is_first = Ranks::all().is_first();
  const std::string folder = is_first ? request.output : "";
  PictureExport pictures(request.pictures, meters.front().detector().names(),
                         inputs.detectors.front().class_index);
  ProtocolFolder run(folder, settings, protocol.frames.size(), textures, pictures.is_on());
  ProtocolSource source = source_of(protocol, request, inputs, meters);
  if (pictures.is_on()) source.pictures = &pictures;
  ProtocolMeasurement measurement(protocol, textures, run.outcomes_path(), std::move(run.outcomes));
  if (!has_measured(measurement, source, protocol, folder)) return StopSignal::exit_code();
  if (!is_first) return 0;
  ProtocolResult result =
      result_of(protocol, textures, request.camouflage.is_given(), measurement.outcomes());
  for (const auto& meter : meters) result.class_names.push_back(meter.detector().names());
  if (protocol.on_photographs && result.sections.front().cell.measured == 0)
    throw Error(ErrorKind::mismatch, request.scene.frames + ": no frame shows the car");
  add_attention(folder, protocol, textures, measurement, source, inputs, request, result);
  const auto notes = notes_of(protocol, result, request, inputs);
  std::cout << lines_for_terminal(protocol_text(protocol, result, notes));
  if (!folder.empty()) {
    write_report(folder, protocol, result, notes, settings, measurement.outcomes());
    write_photographs(folder, protocol, inputs.photographs, result, measurement.outcomes());
  }
  if (pictures.is_on()) pictures.finish(facts_for_labels(request, inputs, settings, result, textures, notes));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  tell_cost(folder, seconds, measurement, textures.size());
  if (!folder.empty()) remark("written: " + folder + "/" + protocol.name + ".html");
  return 0;
}
}  // namespace tapestry::shell
