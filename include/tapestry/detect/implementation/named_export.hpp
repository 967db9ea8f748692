#pragma once
#include <tapestry/detect/implementation/exported_structure.hpp>
#include <tapestry/detect/implementation/named_export/torchvision.hpp>

namespace tapestry::detect {
namespace detail {
/// Boxes and the logistic function of logits, joined to the only output of a network: YOLOv8 and its
/// successors.
struct JoinedOutput {
  const nn::Node* concat = nullptr;  ///< null if the output is not joined of two values
  const nn::Node* curve = nullptr;   ///< null if the second one is no logistic function
};

[[nodiscard]] inline JoinedOutput joined_output(const nn::NetworkDescription& network) {
  if (network.outputs.size() != 1) return {};
  const Makers makers(network);
  const auto maker = [&](const std::string& value) {
    return makers.behind(value, [](const nn::Node& node) { return only_retypes(node.operation); });
  };
  const nn::Node* const concat = maker(network.outputs.front());
  if (concat == nullptr || concat->operation != "Concat" || concat->inputs.size() != 2) return {};
  const nn::Node* const curve = maker(concat->inputs[1]);
  return {concat, curve != nullptr && curve->operation == "Sigmoid" ? curve : nullptr};
}

[[nodiscard]] inline FileError not_an_export(const nn::NetworkDescription& network, const std::string& family,
                                             const std::string& expected, const std::string& found) {
  return file_mismatch({network.path, "", "not an export of " + family, expected, found});
}

/// Outputs of YOLOv8 and its successors: where boxes and scores are joined, the logits of these.
[[nodiscard]] inline DetectorDescription yolov8_description(const nn::NetworkDescription& network) {
  DetectorDescription description;
  description.fit = {image::FitKind::letterbox, 114.0 / 255};
  const JoinedOutput output = joined_output(network);
  if (output.concat == nullptr) {
    description.head = HeadKind::yolov8;
    description.strides = {8, 16, 32};
    return description;
  }
  const bool has_bins = head_trace(network, network.outputs).has({"Softmax"});
  if (output.curve == nullptr && !has_bins)
    throw not_an_export(network, "YOLOv8", "boxes from a softmax over bins, joined with scores",
                        "two other values, joined");
  description.head = HeadKind::boxes_and_scores;
  DecodedOutputs& decoded = description.decoded;
  decoded.channels_first = true;
  decoded.boxes = decoded.scores = network.outputs.front();
  if (output.curve == nullptr) return description;
  decoded.boxes = output.concat->inputs[0];
  decoded.scores = output.curve->inputs.at(0);
  decoded.score_form = ScoreForm::logits;
  return description;
}

/// The decoded output of YOLOv5: each of three convolutions is for three anchors.
[[nodiscard]] inline DetectorDescription yolov5_output(const nn::NetworkDescription& network) {
  constexpr std::size_t anchors = 3;
  const HeadTrace trace = head_trace(network, network.outputs);
  const auto filters = filter_counts(network, trace.convolutions);
  if (network.outputs.size() != 1 || !trace.has({"Sigmoid"}) || trace.has({"Softmax", "TopK"}) ||
      filters.size() < 2 || filters.size() > 5 || !are_apart(filters, filters.size(), {}) ||
      filters.front() % anchors != 0)
    throw not_an_export(network, "YOLOv5",
                        "one output, decoded of two to five convolutions of three times 5 + K filters",
                        std::to_string(network.outputs.size()) + " outputs of " +
                            std::to_string(filters.size()) + " last convolutions");
  DetectorDescription description = known_description("yolov5");
  description = {description.encoding, description.fit, HeadKind::boxes_and_scores};
  description.decoded.boxes = description.decoded.scores = network.outputs.front();
  description.decoded.has_objectness = true;
  return description;
}

[[nodiscard]] inline DetectorDescription end_to_end_description(const nn::NetworkDescription& network,
                                                                std::size_t classes) {
  const HeadTrace trace = head_trace(network, network.outputs);
  if (network.outputs.size() != 1 || !trace.has({"ArgMax", "If", "Loop", "NonMaxSuppression", "TopK"}))
    throw not_an_export(network, "a detector that chooses the classes itself",
                        "one output, behind TopK, ArgMax or NonMaxSuppression",
                        "outputs " + listed(network.outputs) + " without such a choice");
  DetectorDescription description;
  description.fit = {image::FitKind::letterbox, 114.0 / 255};
  description.head = HeadKind::end_to_end;
  description.decoded.boxes = description.decoded.scores = network.outputs.front();
  description.decoded.form = BoxForm::corners;
  description.decoded.classes = classes;
  return description;
}

/// Names of the outputs with scores and boxes of queries: those that exporters give, else the logistic
/// function, which only boxes have, and the linear layer among the outputs.
[[nodiscard]] inline std::pair<std::string, std::string> query_outputs(
    const nn::NetworkDescription& network) {
  const auto is_output = [&](std::string_view name) {
    return std::ranges::find(network.outputs, name) != network.outputs.end();
  };
  for (const char* scores : {"logits", "pred_logits"})
    if (is_output(scores) && is_output("pred_boxes")) return {scores, "pred_boxes"};
  std::vector<std::string> scores, boxes;
  for (const std::string& output : network.outputs) {
    const PickedValue value(network, output);
    if (value.is_made_by("Sigmoid")) boxes.push_back(output);
    const bool is_linear = value.is_made_by("Add") || value.is_made_by("Gemm") || value.is_made_by("MatMul");
    if (is_linear) scores.push_back(output);
  }
  if (scores.size() == 1 && boxes.size() == 1) return {scores.front(), boxes.front()};
  throw not_an_export(network, "a DETR",
                      "outputs logits (or pred_logits) and pred_boxes, or one of a linear layer and one of a "
                      "logistic function",
                      listed(network.outputs));
}

/// Queries with logits and a box each, as transformers predict them.
/// \param has_background  whether one softmax goes over the classes and, behind them, the background
[[nodiscard]] inline DetectorDescription query_description(const nn::NetworkDescription& network,
                                                           bool has_background) {
  DetectorDescription description;
  description.fit = image::fit_by_name("stretch");
  description.head = HeadKind::boxes_and_scores;
  DecodedOutputs& decoded = description.decoded;
  std::tie(decoded.scores, decoded.boxes) = query_outputs(network);
  // Networks that refine reference points, by the logit of a box, by sampling there, or by choosing the
  // surest, are trained with a logistic function a class.
  const HeadTrace trace = head_trace(network, {decoded.scores, decoded.boxes});
  const bool attends = trace.has({"Attention", "Softmax"});
  const bool has_references = trace.has({"GridSample", "Log", "TopK"});
  if (attends && has_references == has_background)
    throw not_an_export(network, has_background ? "DETR or YOLOS" : "RT-DETR or D-FINE",
                        has_background ? "boxes of its queries alone (rt_detr is for others)"
                                       : "boxes refined from reference points (detr is for others)",
                        has_background ? "reference points: GridSample, Log or TopK" : "none");
  decoded.relative = true;
  decoded.score_form = has_background ? ScoreForm::softmax : ScoreForm::logits;
  if (has_background) {
    description.encoding = imagenet_encoding;
    decoded.background = Background::last;
  }
  return description;
}
}  // namespace detail

std::map<std::string, nn::Shape> picture_extents(const nn::NetworkDescription& network, std::size_t size) {
  const auto refuse = [&](const std::string& found) {
    throw file_mismatch(
        {network.path, "", "not a detector of pictures", "one input [1, 3, H, W] or [3, H, W]", found});
  };
  if (network.inputs.size() != 1) refuse(std::to_string(network.inputs.size()) + " inputs");
  const auto& shape = network.inputs.front().shape;
  const std::size_t axis = shape.size() == 3 ? 0 : 1;  // of the channels
  if (shape.size() != 3 + axis || shape[axis].value_or(3) != 3 ||
      shape[0].value_or(axis == 0 ? 3 : 1) != (axis == 0 ? 3 : 1))
    refuse("input " + in_quotes(network.inputs.front().name) + " of other extents");
  const auto height = shape[axis + 1], width = shape[axis + 2];
  if (size == 0 && (!height || !width))
    throw file_mismatch({network.path, "", "the input's size is open; state it with --size"});
  nn::Shape extents{3, size == 0 ? *height : size, size == 0 ? *width : size};
  if (axis == 1) extents.insert(extents.begin(), 1);
  return {{network.inputs.front().name, std::move(extents)}};
}

bool is_export_name(std::string_view name) {
  return std::ranges::find(export_names, name) != export_names.end();
}

std::string_view recognised_export(const nn::NetworkDescription& network) {
  if (detail::TorchvisionExport(network).is_known()) return "torchvision";
  const bool is_of_ultralytics = network.metadata.contains("stride");
  return is_of_ultralytics && detail::joined_output(network).curve != nullptr ? "yolov8" : "";
}

std::vector<std::string_view> fitting_exports(const nn::NetworkDescription& network, std::size_t size) {
  std::vector<std::string_view> fitting;
  for (const std::string_view name : export_names) try {
      require_layers_of(network, named_export(network, name, 1, size));
      fitting.push_back(name);
    } catch (const Error&) {  // another one's
    }
  return fitting;
}

DetectorDescription named_export(const nn::NetworkDescription& network, std::string_view name,
                                 std::size_t classes, std::size_t size) {
  if (!is_export_name(name))
    throw DomainError(
        {"no family of exports is called ", in_quotes(name), "; expected one of ", listed(export_names)});
  const auto need_classes = [&] {
    if (classes == 0)
      throw Error(
          ErrorKind::usage,
          {network.path, ": outputs of the kind ", name,
           " do not tell the number of classes; give the file of their names (--names), or a description"});
  };
  if (name == "yolov5" && raw_outputs(network).empty()) return detail::yolov5_output(network);
  if (name == "yolov8") return detail::yolov8_description(network);
  if (name == "end_to_end") {
    auto description = detail::end_to_end_description(network, classes);
    need_classes();
    return description;
  }
  if (name == "detr" || name == "rt_detr") return detail::query_description(network, name == "detr");
  if (name != "torchvision") {
    DetectorDescription description = known_description(name);
    const auto shown = detail::shown_anchors(network);
    const bool has_own = name == "yolov5" && shown.size() == description.anchors.size() &&
                         !detail::are_same_anchors(shown, description.anchors);
    if (has_own) description.anchors = shown;
    return description;
  }
  const detail::TorchvisionExport outputs(network);
  if (!outputs.is_known())
    throw detail::not_an_export(network, "a torchvision detector",
                                "boxes, scores and labels that are picked from candidates",
                                std::to_string(network.outputs.size()) + " outputs of other kinds");
  if (!outputs.has_softmax()) need_classes();
  return outputs.description(classes, picture_extents(network, size));
}
}  // namespace tapestry::detect
