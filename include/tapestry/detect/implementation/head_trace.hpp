#pragma once
#include <set>
#include <tapestry/detect/exported_heads.hpp>

namespace tapestry::detect::detail {
/// Whether an operator only moves values, changes their type, or takes the logistic function of them. Exports
/// put such operators between the last convolution and an output.
[[nodiscard]] inline bool only_presents(std::string_view operation) {
  constexpr std::array<std::string_view, 14> presenting{
      "Cast",     "CastLike",       "Concat",    "DequantizeLinear", "Flatten",
      "Identity", "QuantizeLinear", "Reshape",   "Sigmoid",          "Slice",
      "Split",    "Squeeze",        "Transpose", "Unsqueeze"};
  return std::ranges::find(presenting, operation) != presenting.end();
}

/// Whether an operator changes only the type and rounding of values.
[[nodiscard]] inline bool only_retypes(std::string_view operation) {
  return operation.starts_with("Cast") || operation == "Identity" || operation == "QuantizeLinear" ||
         operation == "DequantizeLinear";
}

/// Empty for a node without inputs, which files may have.
[[nodiscard]] inline std::string_view first_input(const nn::Node& node) {
  return node.inputs.empty() ? std::string_view() : node.inputs.front();
}

class Makers {
 public:
  explicit Makers(const nn::NetworkDescription& network) {
    for (const nn::Node& node : network.nodes)
      for (const std::string& output : node.outputs) makers_.emplace(output, &node);
  }

  /// Null where no node makes the value.
  [[nodiscard]] const nn::Node* of(std::string_view value) const {
    const auto found = makers_.find(value);
    return found == makers_.end() ? nullptr : found->second;
  }

  /// The first node, going back along first inputs, for which `passes` is false.
  template <class Passes>
  [[nodiscard]] const nn::Node* behind(std::string_view value, Passes passes) const {
    const nn::Node* node = of(value);
    while (node != nullptr && passes(*node)) node = of(first_input(*node));
    return node;
  }

 private:
  std::map<std::string_view, const nn::Node*> makers_{};
};

/// Last convolutions of a network, and the operators behind them.
struct HeadTrace {
  std::vector<std::string> convolutions{};  ///< their outputs
  std::vector<const nn::Node*> nodes{};     ///< behind them
  std::set<std::string_view> operations{};  ///< of the nodes behind them
  [[nodiscard]] bool has(std::initializer_list<std::string_view> any) const {
    return std::ranges::any_of(any, [&](std::string_view one) { return operations.contains(one); });
  }
};

/// Goes back from values to convolutions. One that weighs a softmax is a mean over bins, not a layer.
[[nodiscard]] inline HeadTrace head_trace(const nn::NetworkDescription& network,
                                          const std::vector<std::string>& values) {
  const Makers makers(network);
  HeadTrace trace;
  std::set<std::string_view> seen;
  std::vector<std::string_view> waiting(values.begin(), values.end());
  while (!waiting.empty()) {
    const std::string_view value = waiting.back();
    waiting.pop_back();
    const nn::Node* const node = makers.of(value);
    if (node == nullptr || !seen.insert(value).second) continue;
    if (node->operation == "Conv") {
      const nn::Node* const read =
          makers.behind(first_input(*node), [](const nn::Node& n) { return only_presents(n.operation); });
      if (read == nullptr || read->operation != "Softmax") {
        trace.convolutions.emplace_back(value);
        continue;
      }
    }
    trace.operations.insert(node->operation);
    trace.nodes.push_back(node);
    if (node->operation == "Shape" || node->operation == "Size") continue;  // extents, not values
    waiting.insert(waiting.end(), node->inputs.begin(), node->inputs.end());
  }
  return trace;
}

/// Channels of raw outputs that a network takes the logistic function of.
struct LogisticChannels {
  bool of_all = false;    ///< all channels of a convolution at once
  bool of_some = false;   ///< channels cut off anywhere
  bool of_first = false;  ///< channels cut off before anything else, without anchors
};

[[nodiscard]] inline LogisticChannels logistic_channels(const nn::NetworkDescription& network,
                                                        const std::vector<std::string>& raw) {
  const Makers makers(network);
  LogisticChannels found;
  for (const nn::Node& node : network.nodes) {
    if (node.operation != "Sigmoid") continue;
    bool was_cut = false, is_first = false;
    const nn::Node* const maker = makers.behind(first_input(node), [&](const nn::Node& n) {
      if (!only_presents(n.operation)) return false;
      if (!only_retypes(n.operation)) is_first = n.operation == "Split" || n.operation == "Slice";
      was_cut = was_cut || is_first;
      return true;
    });
    if (maker == nullptr || std::ranges::find(raw, maker->outputs.front()) == raw.end()) continue;
    (was_cut ? found.of_some : found.of_all) = true;
    found.of_first = found.of_first || is_first;
  }
  return found;
}

/// Anchors that a network multiplies extents by where it decodes boxes itself: one list for each grid, the
/// smallest first. Grids without visible anchors have no list.
[[nodiscard]] inline std::vector<std::vector<std::array<double, 2>>> shown_anchors(
    const nn::NetworkDescription& network) {
  constexpr std::size_t most = 9;  // anchors of a grid; more are places of cells
  const Makers makers(network);
  std::vector<std::vector<std::array<double, 2>>> found;
  for (const nn::Node* const node : head_trace(network, network.outputs).nodes) {
    if (node->operation != "Mul") continue;
    for (std::string_view factor : node->inputs) {
      for (const nn::Node* maker = makers.of(factor);
           maker != nullptr &&
           (only_presents(maker->operation) || maker->operation == "Expand" || maker->operation == "Tile");
           maker = makers.of(factor))
        factor = first_input(*maker);
      const auto constant = network.constants.find(std::string(factor));
      if (constant == network.constants.end()) continue;
      const nn::Constant& values = constant->second;
      if (values.shape.size() < 2 || values.shape.back() != 2) continue;
      std::vector<std::array<double, 2>> pairs;
      for (std::size_t i = 0; i < values.size() && pairs.size() <= most; i += 2)
        if (const std::array pair{values.at(i), values.at(i + 1)}; pairs.empty() || pairs.back() != pair)
          pairs.push_back(pair);
      const bool are_anchors = pairs.size() > 1 && pairs.size() <= most;
      if (are_anchors && std::ranges::find(found, pairs) == found.end()) found.push_back(pairs);
    }
  }
  std::ranges::stable_sort(found, {}, [](const auto& pairs) {  // as YOLOv5 does
    double area = 0;
    for (const auto& [width, height] : pairs) area += width * height;
    return area / static_cast<double>(pairs.size());
  });
  return found;
}

/// Whether anchors are the same but for rounding to half precision.
[[nodiscard]] inline bool are_same_anchors(const std::vector<std::vector<std::array<double, 2>>>& a,
                                           const std::vector<std::vector<std::array<double, 2>>>& b) {
  const auto is_same = [](const std::array<double, 2>& x, const std::array<double, 2>& y) {
    return std::abs(x[0] - y[0]) <= 1e-3 * x[0] && std::abs(x[1] - y[1]) <= 1e-3 * x[1];
  };
  return std::ranges::equal(a, b,
                            [&](const auto& x, const auto& y) { return std::ranges::equal(x, y, is_same); });
}

/// Filters of the convolution that makes each of these values; 0 where its weights are not constant.
[[nodiscard]] inline std::vector<std::size_t> filter_counts(const nn::NetworkDescription& network,
                                                            const std::vector<std::string>& values) {
  const Makers makers(network);
  std::vector<std::size_t> counts;
  for (const std::string& value : values) {
    const nn::Node& convolution = *makers.of(value);
    std::string_view weights = convolution.inputs.size() > 1 ? std::string_view(convolution.inputs[1]) : "";
    for (const nn::Node* node = makers.of(weights); node != nullptr && only_retypes(node->operation);
         node = makers.of(weights))
      weights = first_input(*node);
    const auto found = network.constants.find(std::string(weights));
    const bool is_known = found != network.constants.end() && !found->second.shape.empty();
    counts.push_back(is_known ? found->second.shape.front() : 0);
  }
  return counts;
}
}  // namespace tapestry::detect::detail
