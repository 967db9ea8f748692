#pragma once
#include "../comparison/measured_folder.hpp"
#include "../foreign_detections.hpp"
#include "run.hpp"

namespace tapestry::shell {
struct ForeignRequest {
  std::string pictures, detections;  ///< folder and file
  double confidence = 0.25;          ///< a detection's must be above it
  std::optional<double> nms{};       ///< see read_detections()
  std::string output;                ///< folder; nothing is written when empty
};

/// Settings of the measurement by another program's detections, whose file names its detector.
inline Json foreign_settings(const ForeignRequest& request, const ExportedPictures& all) {
  Json settings = all.about.at("settings");
  Json& options = settings.at("options");
  options["weights"] = request.detections;
  options["detections"] = detector_name(request.detections);
  options["confidence"] = request.confidence;
  options["nms"] = request.nms ? Json(*request.nms) : Json();
  settings["inputs"] = all.about.at("inputs");
  for (const Json& input : recorded_inputs())
    if (input["path"] == request.detections || input["path"] == instances_path(request.pictures))
      settings["inputs"].push_back(input);
  for (const auto& fact : facts_of_bits) settings[fact] = computed_by_json()[fact];
  if (settings.contains("run"))
    settings["run"]["folder"] =
        path_of_work(request.pictures, settings, settings["run"].at("folder").get<std::string>());
  settings.erase("begun_in");
  return settings;
}

/// Outcomes of the exported pictures by the detections in them.
/// \throws Json::exception, DomainError for labels that do not fit them
inline evaluate::ProtocolOutcomes foreign_outcomes(const ForeignRequest& request, const ExportedPictures& all,
                                                   std::size_t frames,
                                                   const std::vector<evaluate::Control>& textures) {
  evaluate::ProtocolOutcomes outcomes(frames, textures.size());
  outcomes.draws = draws_of(textures);
  std::ranges::fill(outcomes.state.storage(), static_cast<std::uint8_t>(evaluate::FrameState::left_out));
  const auto related = evaluate::related_classes(all.class_names, all.class_index);
  for (const auto& picture : all.pictures) {
    const auto frame = picture.facts.at("frame").get<std::size_t>();
    const auto column = picture.facts.at("column").get<std::size_t>();
    if (frame >= frames || column >= textures.size()) throw DomainError("a picture of no frame");
    outcomes.state(frame) = static_cast<std::uint8_t>(evaluate::FrameState::measured);
    outcomes.hidden_share(frame) = picture.facts.at("hidden_share");
    outcomes.car_share(frame) = picture.facts.at("car_share");
    set_result(outcomes, frame, column,
               evaluate::view_result(picture.detections, picture.best_confidence,
                                     {all.class_index, picture.target}, related, {request.confidence}));
  }
  return outcomes;
}

/// Writes the tables of a protocol by another program's detections in its pictures, as evaluate_protocol()
/// does by its own.
inline int evaluate_foreign_protocol(const ForeignRequest& request, const ExportedPictures& all) try {
  const Json settings = foreign_settings(request, all);
  const Protocol protocol = detail::saved_measurement(settings, instances_path(request.pictures)).protocol();
  std::vector<evaluate::Control> textures;
  for (const Json& texture : all.about.at("textures"))
    textures.push_back({texture.at("name"), {}, texture.at("share_in_place")});
  ProtocolFolder run(request.output, settings, protocol.frames.size(), textures, true);
  run.outcomes = foreign_outcomes(request, all, protocol.frames.size(), textures);
  ProtocolResult result = result_of(protocol, textures, all.about.at("has_camouflage"), run.outcomes);
  result.class_names = {all.class_names};
  const auto best = [&](std::size_t texture) {
    return result.has_camouflage ? evaluate::measured_values(run.outcomes, run.outcomes.best_confidence,
                                                             texture, [](std::size_t) { return true; })
                                 : std::vector<double>{};
  };
  std::vector<std::string> notes{
      "Detections of another program, " + request.detections + ". Found: a box of class " +
          all.class_names[all.class_index] + ", confidence above " +
          evaluate::detail::short_number(request.confidence) +
          (request.nms ? ", after suppression at IoU " + evaluate::detail::short_number(*request.nms)
                       : std::string(", as that program has suppressed them")) +
          ", that overlaps the box around the car's silhouette by IoU >= 0.5.",
      words_on_floor(all.least_score, best(2), best(1))};
  for (const Json& note : all.about.at("notes")) notes.push_back(note);
  std::cout << lines_for_terminal(protocol_text(protocol, result, notes));
  if (request.output.empty()) return 0;
  write_outcomes(run.outcomes_path(), run.outcomes);
  std::vector<std::size_t> columns;
  for (const std::size_t texture : result.shown_textures())
    columns.push_back(run.outcomes.first_column(texture));
  result.pictures.emplace_back(
      "Boxes above the confidence: " + result.shown_names(),
      io::png_file(request.output, sheet_of(all, request.pictures, request.confidence, columns)));
  write_photographs(request.output, protocol, all.about.at("photographs"), result, run.outcomes);
  write_report(request.output, protocol, result, notes, settings, run.outcomes);
  remark("written: " + request.output + "/" + protocol.name + ".html");
  return 0;
} catch (const Json::exception& error) {
  throw malformed_file({instances_path(request.pictures), "", json_fault(error.what())});
}
}  // namespace tapestry::shell
