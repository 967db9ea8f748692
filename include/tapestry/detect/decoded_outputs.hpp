#pragma once
#include <array>
#include <atomic>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::detect {
/// Meaning of the four numbers of a box.
enum class BoxForm {
  centre,     ///< cx, cy, width, height
  corners,    ///< left, top, right, bottom
  corners_yx  ///< top, left, bottom, right, as in TensorFlow
};
/// Meaning of the class numbers: probabilities, their logits, or logits of one softmax over all classes.
enum class ScoreForm { probabilities, logits, softmax };
/// Entry among the classes that stands for the background, and is left out.
enum class Background { none, first, last };

/// Largest deviation of an output's values from their description: rounding, also in half precision.
inline constexpr double claim_tolerance = 1e-3;

/// The outputs of an export that holds its own decoding: N candidates, with a box and scores each. Inner
/// values may be named, too, such as those before suppression; these may lack the axis of the picture, [N,
/// channels]. Name logits rather than probabilities: where a probability is rounded to 1, its gradient is 0.
/// If N depends on the picture, as with proposals, the head has room for most_candidates; missing ones have a
/// box of no extent and the least probability.
struct DecodedOutputs {
  std::string boxes{}, scores{};  ///< names of outputs; of one for both, boxes come first in it
  bool channels_first = false;    ///< [1, channels, N], as of YOLOv8, instead of [1, N, channels]
  BoxForm form = BoxForm::centre;
  bool relative = false;  ///< boxes are shares of the picture, not pixels
  /// Whether an objectness follows the box, in the same form as the classes; it is a factor of their scores.
  /// Only in one output for both.
  bool has_objectness = false;
  ScoreForm score_form = ScoreForm::probabilities;
  Background background = Background::none;
  /// K, of an end-to-end output: each candidate has one score and, behind it, the number of its class. 0: it
  /// has a score for each class. Objectness, background and softmax are not for end-to-end outputs.
  std::size_t classes = 0;
  /// Names the numbers of the classes, [N], where an end-to-end output has three parts, with boxes [N, 4] and
  /// scores [N]. Empty: they are one output.
  std::string labels{};
  /// Width and height of the picture that boxes are in pixels of, for values within networks that resize
  /// their input; 0: the input's own.
  std::array<double, 2> extent{};
  /// Whether boxes are [N, K, 4], one for each entry of the scores: the surest class's box counts, for
  /// equally sure classes the mean of their boxes.
  bool has_box_for_each_class = false;
  std::size_t most_candidates = 1000;  ///< if their number depends on the picture

  bool operator==(const DecodedOutputs&) const = default;
};

/// Probabilities are clipped to this distance from 0 and 1, so that they have a logit; clipped ones have no
/// slope.
inline constexpr float least_probability = 1e-7F;

namespace detail {
/// Values of an output as described, to compare with a first pass.
struct OutputClaim {
  std::string path{};  ///< of the network, for messages
  std::atomic<bool> is_judged = false;
};

/// Names of values that were added to a network: logits are [1, 4 + K, 1, N], scores, with values as
/// described, are [1, N, channels] or [1, channels, N].
struct AddedOutputs {
  std::string logits{}, scores{};
};

/// Adds the nodes that make a head's logits of decoded outputs to a network.
class DecodedOutputNodes {
 public:
  DecodedOutputNodes(nn::NetworkDescription& network, DecodedOutputs outputs)
      : network_(network), outputs_(std::move(outputs)) {}

  /// Makes values of any of the forms that DecodedOutputs allows [1, N, channels], or [1, channels, N].
  void give_picture_axis();

  /// \param height, width  of the network's input
  AddedOutputs add(std::size_t height, std::size_t width);

 private:
  static constexpr std::int64_t to_the_end = std::int64_t(1) << 31U;

  std::string node(const std::string& operation, std::vector<std::string> inputs,
                   std::map<std::string, nn::Attribute> attributes);
  std::string constant(nn::Constant values);
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
  std::string rows(const std::string& from, std::int64_t first, std::int64_t end, std::int64_t axis = 1);
  std::string classes_only(const std::string& from, std::int64_t axis);
  /// ReduceMax, ReduceSum, Squeeze or Unsqueeze.
  std::string along(std::int64_t axis, const std::string& operation, const std::string& from);
  /// The last `axes` axes behind one of extent 1.
  std::string of_one_picture(const std::string& from, std::int64_t axes);
  /// [1, N, 1] of [N] or [1, N].
  std::string column(const std::string& from) { return along(2, "Unsqueeze", of_one_picture(from, 1)); }
  /// Boxes, [1, N, 4], of the surest classes.
  /// \param boxes   [1, N, K, 4]
  /// \param scores  [1, N, K]
  std::string surest(const std::string& boxes, const std::string& scores);

  /// The class numbers of the output, [1, K, N]; probabilities if the form is softmax.
  std::string scores(std::string from);
  /// Probabilities of an end-to-end output, [1, K, N]: the score for the class whose number follows
  /// it, 0 for all other classes.
  std::string probabilities_of_choice(const std::string& all);
  std::string probabilities(const std::string& said) {
    return outputs_.score_form == ScoreForm::logits ? node("Sigmoid", {said}, {}) : said;
  }
  /// log p − log(1 − p)
  std::string logits(const std::string& from);

  /// The matrix that turns the numbers of a box into centre and extent in pixels.
  std::string to_pixels(std::size_t height, std::size_t width);

  nn::NetworkDescription& network_;
  DecodedOutputs outputs_;
};
}  // namespace detail

/// Adds values to a network: the logits of a head of the decode family decoded, made of the network's
/// outputs.
///
/// \param height, width  of the network's input, pixels
/// \param lacks_axis     whether the outputs may lack the axis of the picture
[[nodiscard]] inline detail::AddedOutputs add_decoded_outputs(nn::NetworkDescription& network,
                                                              const DecodedOutputs& outputs,
                                                              std::size_t height, std::size_t width,
                                                              bool lacks_axis) {
  detail::DecodedOutputNodes nodes(network, outputs);
  if (lacks_axis || outputs.has_box_for_each_class || !outputs.labels.empty()) nodes.give_picture_axis();
  return nodes.add(height, width);
}
}  // namespace tapestry::detect
