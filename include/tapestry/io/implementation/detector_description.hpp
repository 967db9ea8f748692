#pragma once
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/implementation/described_object.hpp>

/// \file
/// The compiled part of the reader of detector descriptions.

namespace tapestry::io {
namespace detail {
inline void read_fit(const DescribedObject& input, image::Fit& fit) {
  if (input.has("fit"))
    fit = input.named("fit", "letterbox, letterbox_top_left or stretch",
                      [](const std::string& name) { return image::fit_by_name(name); });
  if (!input.has("fill")) return;
  if (fit.kind == image::FitKind::stretch)
    input.fail("fill", "'fill' beside the fit stretch, which leaves nothing to fill", "", "");
  fit.fill = input.number("fill", input.member("fill"), 0, 255, "a number from 0 to 255") / 255;
}

inline void read_input(const DescribedObject& input, detect::DetectorDescription& description) {
  constexpr double smallest = 1e-9, largest = 1e9;
  input.require_keys({"order", "scale", "mean", "std", "fit", "fill"});
  auto& encoding = description.encoding;
  using detect::ColourOrder;
  encoding.order =
      chosen<ColourOrder, 2>(input, "order", {{{"rgb", ColourOrder::rgb}, {"bgr", ColourOrder::bgr}}});
  if (input.has("scale"))
    encoding.scale =
        input.number("scale", input.member("scale"), smallest, largest, "a number from 1e-9 to 1e9");
  read_numbers(input, "mean", -largest, largest, "three numbers from -1e9 to 1e9", encoding.mean);
  read_numbers(input, "std", smallest, largest, "three numbers from 1e-9 to 1e9", encoding.deviation);
  read_fit(input, description.fit);
}

inline void read_strides(const DescribedObject& outermost, detect::DetectorDescription& description) {
  constexpr const char* expected = "up to 16 whole numbers from 1 to 4096, each once";
  if (!outermost.has("strides")) outermost.fail("strides", "no 'strides'", expected, "");
  const auto& list = outermost.member("strides");
  if (!list.is_array() || list.empty() || list.size() > 16) outermost.refuse("strides", list, expected);
  for (const auto& entry : list) {
    const bool is_count = entry.is_number_unsigned() && entry >= 1 && entry <= 4096;
    const auto& strides = description.strides;
    if (!is_count || std::ranges::find(strides, entry.get<std::size_t>()) != strides.end())
      outermost.refuse("strides", list, expected);
    description.strides.push_back(entry.get<std::size_t>());
  }
}

inline void read_anchors(const DescribedObject& outermost, detect::DetectorDescription& description) {
  const std::size_t heads = description.strides.size();
  const std::string expected = "for each of " + std::to_string(heads) +
                               " strides a list of up to 16 widths and heights above 0, at most 1e5";
  const bool is_anchored = detect::has_anchors(detect::decode_family_of(description.head));
  if (!outermost.has("anchors")) {
    if (is_anchored) outermost.fail("anchors", "no 'anchors', which such heads need", expected, "");
    return;
  }
  const auto& lists = outermost.member("anchors");
  if (!is_anchored) outermost.fail("anchors", "'anchors' of heads that have none", "", "");
  if (!lists.is_array() || lists.size() != heads) outermost.refuse("anchors", lists, expected);
  for (const auto& list : lists) {
    if (!list.is_array() || list.empty() || list.size() > 32 || list.size() % 2 != 0)
      outermost.refuse("anchors", lists, expected);
    auto& anchors = description.anchors.emplace_back();
    for (std::size_t i = 0; i < list.size(); i += 2)
      anchors.push_back({outermost.number("anchors", list[i], 1e-9, 1e5, expected.c_str()),
                         outermost.number("anchors", list[i + 1], 1e-9, 1e5, expected.c_str())});
  }
}

/// Reads the choices that all decoded outputs have; `form` is its value if the key is missing.
inline void read_form(const DescribedObject& outputs, detect::BoxForm form, detect::DecodedOutputs& decoded) {
  using detect::BoxForm;
  decoded.channels_first = chosen<bool, 2>(outputs, "channels", {{{"last", false}, {"first", true}}});
  decoded.form = form;
  if (outputs.has("form"))
    decoded.form = chosen<BoxForm, 3>(
        outputs, "form",
        {{{"centre", BoxForm::centre}, {"corners", BoxForm::corners}, {"corners_yx", BoxForm::corners_yx}}});
  if (outputs.has("unit") && outputs.member("unit").is_array())
    return read_numbers(outputs, "unit", 1, 1e6, "pixels, share or the width and height of another picture",
                        decoded.extent);
  decoded.relative = chosen<bool, 2>(outputs, "unit", {{{"pixels", false}, {"share", true}}});
}

/// The names of outputs that a description must have.
inline void read_names(const DescribedObject& outputs,
                       std::initializer_list<std::pair<const char*, std::string*>> names) {
  for (const auto& [key, name] : names) {
    if (!outputs.has(key))
      outputs.fail(key, "no " + in_quotes(key) + " in 'outputs'", "an output's name", "");
    *name = outputs.word(key, "an output's name");
  }
}

inline void read_count(const DescribedObject& outputs, const char* key, std::size_t most,
                       std::size_t& count) {
  const auto& value = outputs.member(key);
  if (!value.is_number_unsigned() || value < 1 || value > most)
    outputs.refuse(key, value, "a whole number from 1 to " + std::to_string(most));
  count = value.get<std::size_t>();
}

inline void read_candidates(const DescribedObject& outputs, detect::DecodedOutputs& decoded) {
  if (outputs.has("candidates")) read_count(outputs, "candidates", 100'000, decoded.most_candidates);
}

inline void read_end_to_end(const DescribedObject& outputs, detect::DecodedOutputs& decoded) {
  using detect::ScoreForm;
  outputs.require_keys({"detections", "boxes", "scores", "labels", "classes", "channels", "form", "unit",
                        "score", "candidates"});
  if (outputs.has("labels")) {
    for (const char* key : {"detections", "channels"})
      if (outputs.has(key)) outputs.fail(key, in_quotes(key) + " beside 'labels'", "", "");
    read_names(outputs,
               {{"boxes", &decoded.boxes}, {"scores", &decoded.scores}, {"labels", &decoded.labels}});
  } else {
    for (const char* key : {"boxes", "scores"})
      if (outputs.has(key)) outputs.fail(key, in_quotes(key) + " without 'labels'", "", "");
    read_names(outputs, {{"detections", &decoded.boxes}});
    decoded.scores = decoded.boxes;
  }
  if (!outputs.has("classes"))
    outputs.fail("classes", "no 'classes' in 'outputs'", "a whole number from 1 to 4096", "");
  read_count(outputs, "classes", 4096, decoded.classes);
  read_candidates(outputs, decoded);
  read_form(outputs, detect::BoxForm::corners, decoded);
  decoded.score_form = chosen<ScoreForm, 2>(
      outputs, "score", {{{"probability", ScoreForm::probabilities}, {"logit", ScoreForm::logits}}});
}

inline void read_outputs(const DescribedObject& outputs, detect::DecodedOutputs& decoded) {
  using detect::Background;
  using detect::ScoreForm;
  outputs.require_keys({"boxes", "scores", "boxes_of", "channels", "form", "unit", "objectness", "score",
                        "background", "candidates"});
  read_names(outputs, {{"boxes", &decoded.boxes}, {"scores", &decoded.scores}});
  decoded.has_box_for_each_class =
      chosen<bool, 2>(outputs, "boxes_of", {{{"candidate", false}, {"class", true}}});
  read_candidates(outputs, decoded);
  read_form(outputs, detect::BoxForm::centre, decoded);
  decoded.has_objectness = chosen<bool, 2>(outputs, "objectness", {{{"no", false}, {"yes", true}}});
  decoded.score_form = chosen<ScoreForm, 3>(outputs, "score",
                                            {{{"probability", ScoreForm::probabilities},
                                              {"logit", ScoreForm::logits},
                                              {"softmax", ScoreForm::softmax}}});
  decoded.background = chosen<Background, 3>(
      outputs, "background",
      {{{"none", Background::none}, {"first", Background::first}, {"last", Background::last}}});
  if (decoded.has_objectness && decoded.boxes != decoded.scores)
    outputs.fail("objectness", "'objectness' of two outputs, which have none", "", "");
  if (decoded.has_box_for_each_class && (decoded.channels_first || decoded.boxes == decoded.scores))
    outputs.fail("boxes_of", "boxes of classes are an output of their own, with channels last", "", "");
}

inline void read_decoded(const DescribedObject& outermost, const std::string& path,
                         const std::map<std::string, std::string>& positions,
                         detect::DetectorDescription& description) {
  if (!outermost.has("outputs")) outermost.fail("outputs", "no 'outputs'", "an object", "");
  const auto& outputs = outermost.member("outputs");
  if (!outputs.is_object()) outermost.refuse("outputs", outputs, "an object");
  const DescribedObject object(outputs, path, "outputs", positions);
  if (description.head == detect::HeadKind::end_to_end)
    read_end_to_end(object, description.decoded);
  else
    read_outputs(object, description.decoded);
}
}  // namespace detail

detect::DetectorDescription parse_detector_description(std::string_view text, const std::string& path,
                                                       std::vector<std::string>* warnings) {
  constexpr std::size_t levels = 3;  // outermost object, `input` with its `mean`, or anchors of a stride
  const JsonText json = read_json(text, path, 0, levels);
  if (!json.value.is_object())
    throw malformed_file({path, "", "not a detector's description", "a JSON object", json.value.type_name()});
  const detail::DescribedObject outermost(json.value, path, "", json.positions);
  outermost.require_keys({"input", "head", "strides", "anchors", "outputs"});
  detect::DetectorDescription description;
  if (!outermost.has("head")) outermost.fail("head", "no 'head'", std::string(detect::head_kind_names), "");
  description.head = outermost.named("head", std::string(detect::head_kind_names),
                                     [](const std::string& name) { return detect::head_kind_by_name(name); });
  const bool is_yolov5 = description.head == detect::HeadKind::yolov5;
  if (is_yolov5) description.fit = detect::known_description("yolov5").fit;
  if (outermost.has("input")) {
    const auto& input = outermost.member("input");
    if (!input.is_object()) outermost.refuse("input", input, "an object");
    detail::read_input({input, path, "input", json.positions}, description);
  } else if (!is_yolov5 && warnings != nullptr) {
    warnings->push_back(path + ": has no 'input'; assumed are RGB in the range 0 to 1 and the fit " +
                        std::string(image::name_of(description.fit.kind)));
  }
  const bool is_decoded = detect::decode_family_of(description.head) == detect::DecodeFamily::decoded;
  for (const char* key : {"strides", "anchors", "outputs"})
    if (outermost.has(key) && is_decoded != (key == std::string_view("outputs")))
      outermost.fail(key, in_quotes(key) + " of heads that have none", "", "");
  if (is_decoded) {
    detail::read_decoded(outermost, path, json.positions, description);
    return description;
  }
  if (is_yolov5 && !outermost.has("strides") && !outermost.has("anchors")) {
    const auto known = detect::known_description("yolov5");
    description.strides = known.strides;
    description.anchors = known.anchors;
    return description;
  }
  detail::read_strides(outermost, description);
  detail::read_anchors(outermost, description);
  return description;
}
}  // namespace tapestry::io
