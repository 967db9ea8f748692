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
      was_joined_ = was_joined_ ||
                    (gathers_.empty() && maker_->operation == "Concat" && maker_->inputs.size() == box_size);
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
  /// Whether four columns are put side by side behind the last of them, as those of boxes are; keypoints
  /// have three.
  [[nodiscard]] bool was_joined() const { return was_joined_; }

 private:
  static constexpr std::size_t box_size = 4;

  const nn::Node* maker_ = nullptr;
  std::vector<const nn::Node*> gathers_{};
  bool was_joined_ = false;
};

/// Width and height that a network resizes its picture to before its first convolution; 0 if it does not.
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

/// Outputs of a torchvision detector as it exports them, boxes, scores and labels in any order, before masks
/// or keypoints: the values before the suppression.
class TorchvisionExport {
 public:
  explicit TorchvisionExport(const nn::NetworkDescription& network) : network_(network) {
    for (const std::string& output : network.outputs) {
      PickedValue value(network, output);
      if (value.gathers().empty()) continue;
      auto& part = value.was_joined() ? boxes_ : are_scores(value) ? scores_ : labels_;
      if (!part) part.emplace(std::move(value));
    }
  }

  /// Whether boxes and scores were found. Logistic scores have one candidate a class.
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
    // The boxes of all classes follow each other there, without the background's.
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
}  // namespace tapestry::detect::detail
