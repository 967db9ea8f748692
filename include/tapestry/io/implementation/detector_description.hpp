#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/json.hpp>
#include <utility>
#include <vector>

/// \file
/// The compiled part of the reader of detector descriptions.

namespace tapestry::io {
namespace detail {

/// One object of a description, whose members are read by name and type.
class DescribedObject {
 public:
  /// \param name       its key, for messages; empty for the outermost
  /// \param positions  bytes where members begin; members of an inner object have the byte of that object
  DescribedObject(const nlohmann::json& value, const std::string& path, std::string name,
                  std::map<std::string, std::uint64_t> positions)
      : value_(value), path_(path), name_(std::move(name)), positions_(std::move(positions)) {}

  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& expected,
                         const std::string& found) const {
    const auto at = positions_.find(name_.empty() ? key : name_);
    throw FileError(
        ErrorKind::malformed,
        {path_, at == positions_.end() ? "" : "@" + std::to_string(at->second), what, expected, found});
  }

  /// Refuses other members.
  void require_keys(std::initializer_list<std::string_view> keys) const {
    std::string known;
    for (const auto key : keys) known += (known.empty() ? "" : ", ") + std::string(key);
    for (const auto& member : value_.items())
      if (std::ranges::find(keys, member.key()) == keys.end())
        fail(member.key(), "unknown key" + (name_.empty() ? "" : " of " + in_quotes(name_)), known,
             in_quotes(member.key()));
  }

  [[nodiscard]] bool has(const char* key) const { return value_.contains(key); }

  /// The member with that name, which must exist.
  [[nodiscard]] const nlohmann::json& member(const char* key) const { return value_[key]; }

  /// A number from low to high; `range` states the range in words.
  [[nodiscard]] double number(const char* key, const nlohmann::json& value, double low, double high,
                              const char* range) const {
    const double found = value.is_number() ? value.get<double>() : low - 1;
    if (!(found >= low && found <= high)) refuse(key, value, range);
    return found;
  }

  [[nodiscard]] std::string word(const char* key, const std::string& expected) const {
    if (!member(key).is_string()) refuse(key, member(key), expected);
    return member(key).get<std::string>();
  }

  /// The value of that key's word, parsed by `by_name`.
  template <class ByName>
  [[nodiscard]] auto named(const char* key, const std::string& expected, ByName by_name) const {
    try {
      return by_name(word(key, expected));
    } catch (const DomainError&) {
      refuse(key, member(key), expected);
    }
  }

  [[noreturn]] void refuse(const char* key, const nlohmann::json& value, const std::string& expected) const {
    fail(key, in_quotes(key) + " makes no sense", expected,
         value.is_string() ? in_quotes(value.get_ref<const std::string&>()) : in_quotes(value.dump()));
  }

 private:
  const nlohmann::json& value_;
  const std::string& path_;
  std::string name_;
  std::map<std::string, std::uint64_t> positions_;
};

inline void read_triple(const DescribedObject& object, const char* key, double low, double high,
                        const char* range, std::array<double, 3>& values) {
  if (!object.has(key)) return;
  const auto& list = object.member(key);
  if (!list.is_array() || list.size() != 3) object.refuse(key, list, range);
  for (std::size_t i = 0; i < 3; ++i) values[i] = object.number(key, list[i], low, high, range);
}

inline void read_fit(const DescribedObject& input, image::Fit& fit) {
  if (input.has("fit"))
    fit = input.named("fit", "letterbox, letterbox_top_left or stretch",
                      [](const std::string& name) { return image::fit_by_name(name); });
  if (!input.has("fill")) return;
  if (fit.kind == image::FitKind::stretch)
    input.fail("fill", "'fill' beside the fit stretch, which leaves nothing to fill", "", "");
  fit.fill = input.number("fill", input.member("fill"), 0, 255, "a number from 0 to 255") / 255;
}

/// Warning that a description says nothing of the input.
inline std::string assumed_input(const std::string& path, const image::Fit& fit) {
  return path + ": has no 'input'; assumed are RGB in the range 0 to 1 and the fit " +
         std::string(image::name_of(fit.kind));
}

inline void read_input(const DescribedObject& input, detect::DetectorDescription& description) {
  constexpr double smallest = 1e-9, largest = 1e9;
  input.require_keys({"order", "scale", "mean", "std", "fit", "fill"});
  auto& encoding = description.encoding;
  if (input.has("order"))
    encoding.order = input.named("order", "rgb or bgr", [](const std::string& name) {
      if (name != "rgb" && name != "bgr") throw DomainError("no such order");
      return name == "rgb" ? detect::ColourOrder::rgb : detect::ColourOrder::bgr;
    });
  if (input.has("scale"))
    encoding.scale =
        input.number("scale", input.member("scale"), smallest, largest, "a number from 1e-9 to 1e9");
  read_triple(input, "mean", -largest, largest, "three numbers from -1e9 to 1e9", encoding.mean);
  read_triple(input, "std", smallest, largest, "three numbers from 1e-9 to 1e9", encoding.deviation);
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

/// The choice that a key names; the first one if the key is missing.
template <class Choice, std::size_t Count>
[[nodiscard]] Choice chosen(const DescribedObject& object, const char* key,
                            const std::array<std::pair<std::string_view, Choice>, Count>& choices) {
  if (!object.has(key)) return choices.front().second;
  std::string expected;
  for (std::size_t i = 0; i < Count; ++i)
    expected += (i == 0 ? "" : i + 1 < Count ? ", " : " or ") + std::string(choices[i].first);
  return object.named(key, expected, [&](const std::string& name) {
    for (const auto& [known, choice] : choices)
      if (known == name) return choice;
    throw DomainError("no such choice");
  });
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
  decoded.relative = chosen<bool, 2>(outputs, "unit", {{{"pixels", false}, {"share", true}}});
}

inline void read_end_to_end(const DescribedObject& outputs, detect::DecodedOutputs& decoded) {
  using detect::ScoreForm;
  constexpr const char *name = "an output's name", *count = "a whole number from 1 to 4096";
  outputs.require_keys({"detections", "classes", "channels", "form", "unit", "score"});
  if (!outputs.has("detections")) outputs.fail("detections", "no 'detections' in 'outputs'", name, "");
  decoded.boxes = decoded.scores = outputs.word("detections", name);
  if (!outputs.has("classes")) outputs.fail("classes", "no 'classes' in 'outputs'", count, "");
  const auto& classes = outputs.member("classes");
  if (!classes.is_number_unsigned() || classes < 1 || classes > 4096)
    outputs.refuse("classes", classes, count);
  decoded.classes = classes.get<std::size_t>();
  read_form(outputs, detect::BoxForm::corners, decoded);
  decoded.score_form = chosen<ScoreForm, 2>(
      outputs, "score", {{{"probability", ScoreForm::probabilities}, {"logit", ScoreForm::logits}}});
}

inline void read_outputs(const DescribedObject& outputs, detect::DecodedOutputs& decoded) {
  using detect::Background;
  using detect::ScoreForm;
  outputs.require_keys({"boxes", "scores", "channels", "form", "unit", "objectness", "score", "background"});
  for (const auto& [key, name] : {std::pair("boxes", &decoded.boxes), std::pair("scores", &decoded.scores)}) {
    if (!outputs.has(key))
      outputs.fail(key, "no " + in_quotes(key) + " in 'outputs'", "an output's name", "");
    *name = outputs.word(key, "an output's name");
  }
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
}

inline void read_decoded(const DescribedObject& outermost, const std::string& path,
                         const std::map<std::string, std::uint64_t>& positions,
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
    throw FileError(ErrorKind::malformed,
                    {path, "", "not a detector's description", "a JSON object", json.value.type_name()});
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
    warnings->push_back(detail::assumed_input(path, description.fit));
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
