#pragma once
#include "../build_facts.hpp"
#include "inputs.hpp"

namespace tapestry::shell {
inline std::string note_on_shape(const Protocol& protocol) {
  std::string note =
      "Shape: the camouflage and its controls are on the car in the shape that the run has optimised, clean "
      "is the original car. The effect beyond matched noise is that of the texture alone; clean against "
      "matched noise shows the effect of shape and noise together. A found box must overlap the car as it is "
      "drawn.";
  if (protocol.on_photographs || protocol.street)
    note += " A frame's mask cuts the moved car off where the original one ends.";
  return note + (protocol.change
                     ? " Hidden shares, and the car's share of a picture, are those of the original car."
                     : " The car's share of a picture is that of the original car.");
}

inline std::vector<std::string> notes_on_frames(const Protocol& protocol, const ProtocolResult& result,
                                                const ProtocolRequest& request, bool is_reshaped) {
  const auto number = evaluate::detail::short_number;
  std::size_t measured = 0, left_out = 0;
  for (const auto& section : result.sections) {
    measured += section.cell.measured;
    left_out += section.cell.left_out;
  }
  std::vector<std::string> notes{
      "Measured: " + std::to_string(measured) + " of " + std::to_string(protocol.frames.size()) + " frames" +
      (left_out > 0
           ? "; " + std::to_string(left_out) + " are left out, for nothing of the car shows in them" +
                 (is_reshaped ? " in the original or in the optimised shape" : "") +
                 (protocol.change ? ", or too little to hide the share" : "")
           : "") +
      (protocol.on_photographs && result.sections.size() > 1
           ? "; each photograph counts once for each of " + std::to_string(result.sections.size()) +
                 " detectors"
           : "") +
      "."};
  if (request.settings.quick)
    notes.push_back(protocol.on_photographs ? "--quick: at most " + std::to_string(quick_photographs) +
                                                  " photographs; intervals are wider."
                                            : "--quick: fewer views than the paper's; intervals are wider.");
  notes.insert(notes.end(), protocol.notes.begin(), protocol.notes.end());
  if (is_reshaped) notes.push_back(note_on_shape(protocol));
  if (!protocol.on_photographs)
    notes.push_back(
        "Distances are from the car's middle, in units of which its half length is 1; half of the field of "
        "view is " +
        number(evaluate::protocol_half_fov_deg) + " degrees. The paper states neither" +
        (is_before_plain_background(protocol.name) ? "; its pictures fit both." : "."));
  else if (request.trained_on > 0)
    notes.push_back("The camouflage was made with " + std::to_string(request.trained_on) +
                    " of these very photographs: the result holds for no others.");
  return notes;
}

inline std::vector<std::string> notes_on_effects(const ProtocolResult& result,
                                                 const ProtocolRequest& request) {
  std::vector<std::string> notes{
      "Effect: the same frames with matched noise and with the camouflage; brackets: 95 % by paired "
      "bootstrap (BCa, " +
      std::to_string(evaluate::BootstrapSettings{}.resamples) +
      " resamples) over frames, those of P@0.5 by Newcombe's method for paired shares; odds: those of being "
      "found with matched noise over those with the camouflage."};
  if (result.noise_in_place)
    notes.push_back("Matched noise is drawn over the whole car; " + in_place_text(*result.noise_in_place) +
                    ".");
  if (std::ranges::count(result.textures, evaluate::picture_noise_name) > 0)
    notes.push_back(std::string(evaluate::picture_noise_name) +
                    ": each picture with its paint replaced by noise with the colours and the spectrum that "
                    "the paint has there, in the same light.");
  if (request.settings.noise_draws > 1)
    notes.push_back("Matched noise: " + std::to_string(request.settings.noise_draws) +
                    " draws, each measured in every frame. Its rows count the frames of all draws, a frame "
                    "once in their intervals. Intervals of effects are over frames and "
                    "draws, the draws' part by Student's t.");
  const auto has_few = [](const auto& section) {
    return section.cell.measured > 0 && section.cell.measured < 6;
  };
  if (std::ranges::any_of(result.sections, has_few))
    notes.push_back("Intervals of fewer than 6 frames are too narrow.");
  return notes;
}

inline std::string note_on_found(const DetectorSettings& detector) {
  const auto number = evaluate::detail::short_number;
  return (detector.precision == "float" ? "" : "Detectors run in " + detector.precision + ". ") +
         "Found: a box of class " + detector.class_name + ", confidence above " +
         number(detector.confidence) + ", after suppression at IoU " + number(detector.nms) +
         ", that overlaps the box around the car's silhouette by IoU >= 0.5; the best confidence is that of "
         "the surest such box, however low, before suppression. Else the frame is related (such a box is of "
         "another vehicle), renamed (of any other class), misplaced (a box of the class overlaps it by 0.1 "
         "to 0.5) or lost: none of these; other classes may still overlap it by less than 0.5. Attack "
         "success counts the frames that are found in clean and not with the texture; where none is found "
         "in clean it is not defined (-). Brackets: 95 % by Wilson, over the frames and, of noise, its "
         "draws.";
}

/// Notes under every table.
inline std::vector<std::string> notes_of(const Protocol& protocol, const ProtocolResult& result,
                                         const ProtocolRequest& request, const ProtocolInputs& inputs) {
  const auto number = evaluate::detail::short_number;
  const auto& background = request.settings.background;
  auto notes = notes_on_frames(protocol, result, request, inputs.reshaped.has_value());
  if (!inputs.changed.empty())
    notes.push_back("Inputs have changed since the run: " + text_of(inputs.changed) + ".");
  notes.push_back(note_on_found(request.detector));
  if (result.has_camouflage)
    for (const auto& note : notes_on_effects(result, request)) notes.push_back(note);
  std::string input = "Input";
  for (const auto& [detector, class_index] : inputs.detectors)
    input += (input == "Input" ? " " : ", ") + std::to_string(detector.input_width()) + "x" +
             std::to_string(detector.input_height());
  input += " pixels, " + std::to_string(request.scene.samples) + "x" + std::to_string(request.scene.samples) +
           " samples a pixel";
  if (is_before_plain_background(protocol.name))
    input +=
        ", background " + number(background[0]) + " " + number(background[1]) + " " + number(background[2]);
  notes.push_back(input + ", seed " + std::to_string(request.seed) + ". " + computed_by_text() + ".");
  return notes;
}
}  // namespace tapestry::shell
