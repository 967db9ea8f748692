#pragma once
#include "operator_case.hpp"
#include "vocabulary_cases.hpp"

namespace tapestry::test {
/// Value i of n, which no other operand of the case has: ties and kinks are apart by far more than a step.
inline double value_of(const CaseOperand& operand, std::size_t place, std::size_t i, Random& random) {
  const std::size_t count = nn::size_of(operand.shape);
  const double inside = (static_cast<double>((i * 7 + 3) % count % 97) + 0.31 +
                         0.11 * static_cast<double>(place) + 0.05 * random.uniform()) /
                        static_cast<double>(count);
  return operand.low + (operand.high - operand.low) * inside;
}

/// The node behind a Neg for each operand of `computed`, the others constant; and behind the node a Cos of
/// each input, which overwrites memory that the node released before the adjoint.
struct Behind {
  nn::NetworkDescription description{};
  std::vector<std::vector<double>> values{};  ///< of the inputs

  Behind(const VocabularyCase& given, std::uint64_t computed) {
    description.path = "net.onnx";
    description.opset = given.opset;
    nn::Node node{"", given.operation, {}, {}, given.attributes};
    std::vector<nn::Node> behind;
    Random random(5);
    for (std::size_t place = 0; place < given.operands.size(); ++place) {
      const CaseOperand& operand = given.operands[place];
      const std::string name = std::to_string(place);
      node.inputs.push_back(operand.kind == CaseOperand::Kind::left_out ? "" : "operand " + name);
      if (operand.kind == CaseOperand::Kind::setting)
        description.constants[node.inputs.back()] = operand.constant;
      if (operand.kind != CaseOperand::Kind::drawn) continue;
      std::vector<double> drawn;
      for (std::size_t i = 0; i < nn::size_of(operand.shape); ++i)
        drawn.push_back(value_of(operand, place, i, random));
      if ((computed >> place & 1U) == 0) {
        description.constants[node.inputs.back()] = numbers(operand.shape, drawn);
        continue;
      }
      for (double& value : drawn) value = -value;
      values.push_back(std::move(drawn));
      description.inputs.push_back({"input " + name, {operand.shape.begin(), operand.shape.end()}});
      description.nodes.push_back({"", "Neg", {"input " + name}, {node.inputs.back()}, {}});
      behind.push_back({"", "Cos", {"input " + name}, {"cosine " + name}, {}});
    }
    for (std::size_t i = 0; i < given.output_count; ++i) {
      node.outputs.push_back("y" + std::to_string(i));
      description.outputs.push_back(node.outputs.back());
    }
    description.nodes.push_back(std::move(node));
    for (nn::Node& cosine : behind) {
      description.outputs.push_back(cosine.outputs.front());
      description.nodes.push_back(std::move(cosine));
    }
  }
};

/// Every set of drawn operands but the empty one.
inline std::vector<std::uint64_t> computed_sets(const VocabularyCase& given) {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < given.operands.size(); ++i)
    if (given.operands[i].kind == CaseOperand::Kind::drawn) all |= std::uint64_t(1) << i;
  std::vector<std::uint64_t> sets;
  for (std::uint64_t set = 1; set <= all; ++set)
    if ((set & all) == set) sets.push_back(set);
  return sets;
}
}  // namespace tapestry::test
