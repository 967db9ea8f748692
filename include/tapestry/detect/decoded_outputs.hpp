#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tapestry/nn/network/description.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tapestry::detect {

/// What four numbers of a box say.
enum class BoxForm {
  centre,     ///< cx, cy, width, height
  corners,    ///< left, top, right, bottom
  corners_yx  ///< top, left, bottom, right, as in TensorFlow
};
/// What the numbers of classes are: probabilities, their logits, or logits of one softmax over all classes.
enum class ScoreForm { probabilities, logits, softmax };
/// Which entry among the classes stands for none of them, and is left out.
enum class Background { none, first, last };

/// The outputs of an export that holds its own decoding: N candidates, with a box and scores each. The names
/// may be those of inner values, too. Better name logits than probabilities: where a probability is rounded
/// to 1, its gradient is 0.
struct DecodedOutputs {
  std::string boxes{}, scores{};  ///< names of outputs; of one for both, boxes come first in it
  bool channels_first = false;    ///< [1, channels, N], as of YOLOv8, instead of [1, N, channels]
  BoxForm form = BoxForm::centre;
  bool relative = false;  ///< boxes are shares of the picture, not pixels
  /// Behind the box, in one output for both: in the form of the classes, and a factor of theirs.
  bool has_objectness = false;
  ScoreForm score_form = ScoreForm::probabilities;
  Background background = Background::none;

  bool operator==(const DecodedOutputs&) const = default;
};

/// How far probabilities are kept from 0 and 1, so that they have a logit: beyond, no slope is left.
inline constexpr float least_probability = 1e-7F;

namespace detail {

/// Adds the nodes that make a head's logits of decoded outputs to a network.
class DecodedOutputNodes {
 public:
  DecodedOutputNodes(nn::NetworkDescription& network, const DecodedOutputs& outputs)
      : network_(network), outputs_(outputs) {}

  /// \param height, width  of the network's input
  /// \returns  the name of [1, 4 + K, 1, N]
  std::string add(std::size_t height, std::size_t width) {
    const bool is_one = outputs_.boxes == outputs_.scores;
    const std::string all = channels_first(outputs_.boxes);
    const std::string boxes = node("MatMul", {to_pixels(height, width), is_one ? rows(all, 0, 4) : all}, {});
    std::string classes = scores(is_one ? rows(all, outputs_.has_objectness ? 5 : 4, to_the_end)
                                        : channels_first(outputs_.scores));
    if (outputs_.has_objectness)
      classes = logits(node("Mul", {probabilities(classes), probabilities(rows(all, 4, 5))}, {}));
    else if (outputs_.score_form != ScoreForm::logits)
      classes = logits(classes);
    const std::string joined = node("Concat", {boxes, classes}, {{"axis", std::int64_t(1)}});
    if (network_.opset < 13) return node("Unsqueeze", {joined}, {{"axes", std::vector<std::int64_t>{2}}});
    return node("Unsqueeze", {joined, integers({2})}, {});
  }

 private:
  static constexpr std::int64_t to_the_end = std::int64_t(1) << 31U;

  std::string node(const std::string& operation, std::vector<std::string> inputs,
                   std::map<std::string, nn::Attribute> attributes) {
    std::string output = "decoded outputs " + std::to_string(network_.nodes.size());
    network_.nodes.push_back({output, operation, std::move(inputs), {output}, std::move(attributes)});
    return output;
  }
  std::string constant(nn::Constant values) {
    std::string name;
    for (std::size_t i = network_.constants.size(); name.empty() || network_.constants.contains(name); ++i)
      name = "decoded outputs, constant " + std::to_string(i);
    network_.constants[name] = std::move(values);
    return name;
  }
  std::string integers(std::vector<double> values) {
    return constant({{values.size()}, nn::ElementType::integer, std::move(values)});
  }
  std::string number(float value) {
    return constant({{1}, nn::ElementType::floating, std::vector<float>{value}});
  }
  std::string transposed(const std::string& from) {
    return node("Transpose", {from}, {{"perm", std::vector<std::int64_t>{0, 2, 1}}});
  }
  std::string channels_first(const std::string& from) {
    return outputs_.channels_first ? from : transposed(from);
  }
  /// Channels `first` to `end`, which counts from behind where it is below 0.
  std::string rows(const std::string& from, std::int64_t first, std::int64_t end) {
    using List = std::vector<std::int64_t>;
    if (network_.opset < 10)
      return node("Slice", {from}, {{"starts", List{first}}, {"ends", List{end}}, {"axes", List{1}}});
    const auto list = [&](std::int64_t value) { return integers({static_cast<double>(value)}); };
    return node("Slice", {from, list(first), list(end), list(1)}, {});
  }

  /// The classes as they are said, [1, K, N], but of a softmax their probabilities.
  std::string scores(std::string from) {
    if (outputs_.score_form == ScoreForm::softmax)  // whose axis is the last one in every opset
      from = transposed(node("Softmax", {transposed(from)}, {{"axis", std::int64_t(2)}}));
    if (outputs_.background == Background::none) return from;
    return outputs_.background == Background::first ? rows(from, 1, to_the_end) : rows(from, 0, -1);
  }
  std::string probabilities(const std::string& said) {
    return outputs_.score_form == ScoreForm::logits ? node("Sigmoid", {said}, {}) : said;
  }
  /// log p − log(1 − p)
  std::string logits(const std::string& from) {
    const std::string above = node("Max", {from, number(least_probability)}, {});
    const std::string inside = node("Min", {above, number(1 - least_probability)}, {});
    const std::string others = node("Sub", {number(1), inside}, {});
    return node("Sub", {node("Log", {inside}, {}), node("Log", {others}, {})}, {});
  }

  /// The matrix that makes centre and extent in pixels of what a box says.
  std::string to_pixels(std::size_t height, std::size_t width) {
    const bool are_corners = outputs_.form != BoxForm::centre;
    const float x = outputs_.relative ? static_cast<float>(width) : 1;
    const float y = outputs_.relative ? static_cast<float>(height) : 1;
    const std::size_t left = outputs_.form == BoxForm::corners_yx ? 1 : 0, top = 1 - left;
    std::vector<float> matrix(16, 0);
    const auto entry = [&](std::size_t row, std::size_t column) -> float& {
      return matrix[4 * row + column];
    };
    for (const auto& [axis, near, scale] : {std::tuple(0U, left, x), std::tuple(1U, top, y)}) {
      entry(axis, near) = are_corners ? scale / 2 : scale;
      entry(axis, near + 2) = are_corners ? scale / 2 : 0;
      entry(axis + 2, near) = are_corners ? -scale : 0;
      entry(axis + 2, near + 2) = scale;
    }
    return constant({{4, 4}, nn::ElementType::floating, std::move(matrix)});
  }

  nn::NetworkDescription& network_;
  const DecodedOutputs& outputs_;
};

}  // namespace detail

/// Adds a value to a network: the logits of a head of the decode family decoded, made of the network's own
/// outputs.
///
/// \param height, width  of the network's input, pixels
/// \returns  the value's name; it is [1, 4 + K, 1, N]
inline std::string add_decoded_outputs(nn::NetworkDescription& network, const DecodedOutputs& outputs,
                                       std::size_t height, std::size_t width) {
  return detail::DecodedOutputNodes(network, outputs).add(height, width);
}

}  // namespace tapestry::detect
