#pragma once
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/nn/network/program_builder.hpp>

namespace tapestry::detect::detail {

/// Goes from a value back through the first operands of nodes that pick, move or scale values.
class PickedValue {
 public:
  PickedValue(const nn::NetworkDescription& network, std::string value) {
    constexpr std::array<std::string_view, 12> picking{"Concat",   "Flatten", "Gather",  "GatherND",
                                                       "Identity", "Mul",     "Reshape", "Slice",
                                                       "Split",    "Squeeze", "TopK",    "Unsqueeze"};
    for (;;) {
      maker_ = nn::maker_of(network, value);
      if (maker_ == nullptr || std::ranges::find(picking, maker_->operation) == picking.end()) return;
      if (maker_->operation.starts_with("Gather")) gathers_.push_back(maker_);
      was_joined_ = was_joined_ || (gathers_.empty() && maker_->operation == "Concat");
      value = maker_->inputs.at(0);
    }
  }

  /// The node that computes it; null where there is none.
  [[nodiscard]] const nn::Node* maker() const { return maker_; }
  [[nodiscard]] bool is_made_by(std::string_view operation) const {
    return maker_ != nullptr && maker_->operation == operation;
  }
  /// Nodes that pick, the last one first.
  [[nodiscard]] const std::vector<const nn::Node*>& gathers() const { return gathers_; }
  /// Whether columns are put side by side behind the last of them, as those of boxes are.
  [[nodiscard]] bool was_joined() const { return was_joined_; }

 private:
  const nn::Node* maker_ = nullptr;
  std::vector<const nn::Node*> gathers_{};
  bool was_joined_ = false;
};

/// Extents, width and height, to which a network resizes its picture before its first convolution; 0 where it
/// does not.
[[nodiscard]] inline std::array<double, 2> inner_extent(const nn::NetworkDescription& network,
                                                        const std::map<std::string, nn::Shape>& inputs) {
  const auto is_first = [](const nn::Node& node) {
    return node.operation == "Resize" || node.operation == "Conv";
  };
  const auto first = std::ranges::find_if(network.nodes, is_first);
  if (first == network.nodes.end() || first->operation != "Resize") return {};
  const std::string& resized = first->outputs.front();
  const auto before = nn::pruned(network, {resized});
  nn::ProgramBuilder<float> builder(before, inputs, false, false);
  builder.add_nodes();
  const auto facts = builder.facts();
  const auto found = facts.find(resized);
  if (found == facts.end() || found->second.shape.size() < 2) return {};
  const nn::Shape& shape = found->second.shape;
  return {static_cast<double>(shape[shape.size() - 1]), static_cast<double>(shape[shape.size() - 2])};
}

/// Outputs of a torchvision detector as it exports them, boxes, scores and labels in any order: the values
/// before the suppression.
class TorchvisionExport {
 public:
  explicit TorchvisionExport(const nn::NetworkDescription& network) : network_(network) {
    for (const std::string& output : network.outputs) {
      PickedValue value(network, output);
      if (value.gathers().empty()) continue;
      if (value.was_joined())
        boxes_.emplace(std::move(value));
      else if (are_scores(value))
        scores_.emplace(std::move(value));
      else
        labels_.emplace(std::move(value));
    }
  }

  /// Whether boxes and scores were found. Where scores are logistic, candidates have a class each.
  [[nodiscard]] bool is_known() const { return boxes_ && scores_ && (has_softmax() || labels_); }
  [[nodiscard]] bool has_softmax() const { return scores_->is_made_by("Softmax"); }

  /// \param classes  K, for candidates with a class each
  [[nodiscard]] DetectorDescription description(std::size_t classes,
                                                const std::map<std::string, nn::Shape>& inputs) const {
    DetectorDescription description;
    description.fit = image::fit_by_name("stretch");
    DecodedOutputs& decoded = description.decoded;
    decoded.form = BoxForm::corners;
    decoded.extent = inner_extent(network_, inputs);
    if (!has_softmax()) {
      description.head = HeadKind::end_to_end;
      decoded.classes = classes;
      decoded.most_candidates = 5000;  // 1000 of each of five maps
      decoded.boxes = boxes_->gathers().front()->inputs.at(0);
      decoded.scores = scores_->gathers().front()->inputs.at(0);
      decoded.labels = labels_->gathers().front()->inputs.at(0);
      return description;
    }
    description.head = HeadKind::boxes_and_scores;
    decoded.scores = scores_->maker()->inputs.at(0);
    decoded.score_form = ScoreForm::softmax;
    decoded.background = Background::first;
    decoded.boxes = boxes_->gathers().back()->inputs.at(0);
    // Boxes of classes stand one behind the other there, without the background's.
    const nn::Node* const reshape = nn::maker_of(network_, decoded.boxes);
    const nn::Node* const slice = reshape == nullptr || reshape->operation != "Reshape"
                                      ? nullptr
                                      : nn::maker_of(network_, reshape->inputs.at(0));
    if (slice != nullptr && slice->operation == "Slice") {
      decoded.has_box_for_each_class = true;
      decoded.boxes = slice->inputs.at(0);
    }
    return description;
  }

 private:
  /// FCOS takes the root of the product of two logistic functions.
  [[nodiscard]] static bool are_scores(const PickedValue& value) {
    return value.is_made_by("Softmax") || value.is_made_by("Sigmoid") || value.is_made_by("Sqrt");
  }

  const nn::NetworkDescription& network_;
  std::optional<PickedValue> boxes_{}, scores_{}, labels_{};
};

/// Boxes and the logistic function of logits, joined to the only output of a network: YOLOv8 and its
/// successors.
struct JoinedOutput {
  const nn::Node* concat = nullptr;  ///< null if the output is not joined of two values
  const nn::Node* curve = nullptr;   ///< null if the second one is no logistic function
};

[[nodiscard]] inline JoinedOutput joined_output(const nn::NetworkDescription& network) {
  const nn::Node* const concat =
      network.outputs.size() == 1 ? nn::maker_of(network, network.outputs.front()) : nullptr;
  if (concat == nullptr || concat->operation != "Concat" || concat->inputs.size() != 2) return {};
  const nn::Node* const curve = nn::maker_of(network, concat->inputs[1]);
  return {concat, curve != nullptr && curve->operation == "Sigmoid" ? curve : nullptr};
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

[[nodiscard]] inline DetectorDescription end_to_end_description(const nn::NetworkDescription& network,
                                                                std::size_t classes) {
  DetectorDescription description;
  description.fit = {image::FitKind::letterbox, 114.0 / 255};
  description.head = HeadKind::end_to_end;
  description.decoded.boxes = description.decoded.scores = network.outputs.front();
  description.decoded.form = BoxForm::corners;
  description.decoded.classes = classes;
  return description;
}

/// Queries with logits and a box each, as transformers predict them.
/// \param has_background  whether one softmax goes over the classes and, behind them, the background
[[nodiscard]] inline DetectorDescription query_description(const nn::NetworkDescription& network,
                                                           bool has_background) {
  const auto is_output = [&](std::string_view name) {
    return std::ranges::find(network.outputs, name) != network.outputs.end();
  };
  DetectorDescription description;
  description.fit = image::fit_by_name("stretch");
  description.head = HeadKind::boxes_and_scores;
  DecodedOutputs& decoded = description.decoded;
  decoded.scores = is_output("logits") ? "logits" : "pred_logits";
  decoded.boxes = "pred_boxes";
  if (!is_output(decoded.scores) || !is_output(decoded.boxes)) {
    std::string found;
    for (const std::string& output : network.outputs) found += (found.empty() ? "" : ", ") + output;
    throw FileError(ErrorKind::mismatch, {network.path, "", "not an export of a DETR",
                                          "outputs logits (or pred_logits) and pred_boxes", found});
  }
  decoded.relative = true;
  decoded.score_form = has_background ? ScoreForm::softmax : ScoreForm::logits;
  if (has_background) {
    description.encoding = imagenet_encoding;
    decoded.background = Background::last;
  }
  return description;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

std::map<std::string, nn::Shape> picture_extents(const nn::NetworkDescription& network, std::size_t size) {
  const auto refuse = [&](const std::string& found) {
    throw FileError(ErrorKind::mismatch, {network.path, "", "not a detector of pictures",
                                          "one input [1, 3, H, W] or [3, H, W]", found});
  };
  if (network.inputs.size() != 1) refuse(std::to_string(network.inputs.size()) + " inputs");
  const auto& shape = network.inputs.front().shape;
  const std::size_t axis = shape.size() == 3 ? 0 : 1;  // of the channels
  if (shape.size() != 3 + axis || shape[axis].value_or(3) != 3 ||
      shape[0].value_or(axis == 0 ? 3 : 1) != (axis == 0 ? 3 : 1))
    refuse("input " + in_quotes(network.inputs.front().name) + " of other extents");
  const auto height = shape[axis + 1], width = shape[axis + 2];
  if (size == 0 && (!height || !width))
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "the input's size is open; state it with --size"});
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

DetectorDescription named_export(const nn::NetworkDescription& network, std::string_view name,
                                 std::size_t classes, std::size_t size) {
  if (!is_export_name(name)) {
    std::string names;
    for (const std::string_view known : export_names)
      names += (names.empty() ? "" : ", ") + std::string(known);
    throw DomainError({"no family of exports is called ", in_quotes(name), "; expected one of ", names});
  }
  const auto need_classes = [&] {
    if (classes == 0)
      throw Error(
          ErrorKind::usage,
          {network.path, ": outputs of the kind ", name,
           " do not tell the number of classes; give the file of their names (--names), or a description"});
  };
  if (name == "yolov5" && raw_outputs(network).empty()) {
    DetectorDescription description = known_description(name);
    description = {description.encoding, description.fit, HeadKind::boxes_and_scores};
    description.decoded.boxes = description.decoded.scores = network.outputs.front();
    description.decoded.has_objectness = true;
    return description;
  }
  if (name == "yolov8") return detail::yolov8_description(network);
  if (name == "end_to_end") {
    need_classes();
    return detail::end_to_end_description(network, classes);
  }
  if (name == "detr" || name == "rt_detr") return detail::query_description(network, name == "detr");
  if (name != "torchvision") return known_description(name);
  const detail::TorchvisionExport outputs(network);
  if (!outputs.is_known())
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "not an export of a torchvision detector",
                     "boxes, scores and labels that are picked from candidates",
                     std::to_string(network.outputs.size()) + " outputs of other kinds"});
  if (!outputs.has_softmax()) need_classes();
  return outputs.description(classes, picture_extents(network, size));
}

}  // namespace tapestry::detect
