#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

std::string DecodedOutputNodes::add(std::size_t height, std::size_t width) {
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

std::string DecodedOutputNodes::node(const std::string& operation, std::vector<std::string> inputs,
                                     std::map<std::string, nn::Attribute> attributes) {
  std::string output = "decoded outputs " + std::to_string(network_.nodes.size());
  network_.nodes.push_back({output, operation, std::move(inputs), {output}, std::move(attributes)});
  return output;
}

std::string DecodedOutputNodes::constant(nn::Constant values) {
  std::string name;
  for (std::size_t i = network_.constants.size(); name.empty() || network_.constants.contains(name); ++i)
    name = "decoded outputs, constant " + std::to_string(i);
  network_.constants[name] = std::move(values);
  return name;
}

std::string DecodedOutputNodes::rows(const std::string& from, std::int64_t first, std::int64_t end) {
  using List = std::vector<std::int64_t>;
  if (network_.opset < 10)
    return node("Slice", {from}, {{"starts", List{first}}, {"ends", List{end}}, {"axes", List{1}}});
  const auto list = [&](std::int64_t value) { return integers({static_cast<double>(value)}); };
  return node("Slice", {from, list(first), list(end), list(1)}, {});
}

std::string DecodedOutputNodes::scores(std::string from) {
  if (outputs_.score_form == ScoreForm::softmax)  // whose axis is the last one in every opset
    from = transposed(node("Softmax", {transposed(from)}, {{"axis", std::int64_t(2)}}));
  if (outputs_.background == Background::none) return from;
  return outputs_.background == Background::first ? rows(from, 1, to_the_end) : rows(from, 0, -1);
}

std::string DecodedOutputNodes::logits(const std::string& from) {
  const std::string above = node("Max", {from, number(least_probability)}, {});
  const std::string inside = node("Min", {above, number(1 - least_probability)}, {});
  const std::string others = node("Sub", {number(1), inside}, {});
  return node("Sub", {node("Log", {inside}, {}), node("Log", {others}, {})}, {});
}

std::string DecodedOutputNodes::to_pixels(std::size_t height, std::size_t width) {
  const bool are_corners = outputs_.form != BoxForm::centre;
  const float x = outputs_.relative ? static_cast<float>(width) : 1;
  const float y = outputs_.relative ? static_cast<float>(height) : 1;
  const std::size_t left = outputs_.form == BoxForm::corners_yx ? 1 : 0, top = 1 - left;
  std::vector<float> matrix(16, 0);
  const auto entry = [&](std::size_t row, std::size_t column) -> float& { return matrix[4 * row + column]; };
  for (const auto& [axis, near, scale] : {std::tuple(0U, left, x), std::tuple(1U, top, y)}) {
    entry(axis, near) = are_corners ? scale / 2 : scale;
    entry(axis, near + 2) = are_corners ? scale / 2 : 0;
    entry(axis + 2, near) = are_corners ? -scale : 0;
    entry(axis + 2, near + 2) = scale;
  }
  return constant({{4, 4}, nn::ElementType::floating, std::move(matrix)});
}

}  // namespace tapestry::detect::detail
