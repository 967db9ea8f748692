#include <tapestry/nn/detail/network/decomposition.hpp>

#include "../../support/operator_case.hpp"
#include "../../support/vocabulary_cases.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Counts = std::pair<std::size_t, std::size_t>;
constexpr std::size_t any = std::numeric_limits<std::size_t>::max();

/// Least and most operands at the opsets of the vocabulary's cases, where they are not one and one.
/// Source: onnx.ai, Operators.md; for Tapestry's own operators, their headers.
const std::vector<std::pair<Counts, std::set<std::string>>> counts = {
    {{1, 2},
     {"ReduceL1", "ReduceL2", "ReduceLogSum", "ReduceLogSumExp", "ReduceMax", "ReduceMean", "ReduceMin",
      "ReduceProd", "ReduceSum", "ReduceSumSquare",
      // beside reductions
      "Split", "Squeeze", "Trilu"}},
    {{1, 3}, {"Clip", "Dropout"}},
    {{1, 4}, {"Resize"}},
    {{1, any}, {"Concat", "Einsum", "If", "Max", "Mean", "Min", "Sum"}},
    {{2, 2},
     {"Add", "And", "Div", "Equal", "Greater", "GreaterOrEqual", "Less", "LessOrEqual", "Mod", "Mul", "Or",
      "PRelu", "Pow", "Sub", "Xor",
      // beside functions of two numbers
      "CastLike", "Compress", "CumSum", "Expand", "Gather", "GatherElements", "GatherND", "GridSample",
      "InterleaveChannels", "MatMul", "RMSNormalization", "Reshape", "Tile", "TopK", "Unsqueeze", "Upsample",
      "TangentPool"}},
    {{2, 3},
     {"Conv", "ConvTranspose", "Gemm", "LayerNormalization", "Pad",
      // of quantities, and losses
      "DequantizeLinear", "QuantizeLinear", "NegativeLogLikelihoodLoss", "SoftmaxCrossEntropyLoss"}},
    {{2, 4}, {"ConvInteger", "MatMulInteger", "Tangent"}},
    {{2, 5}, {"NonMaxSuppression"}},
    {{2, any}, {"Loop"}},
    {{3, 3},
     {"GroupNormalization", "InstanceNormalization", "OneHot", "Range", "RoiAlign",
      // that place values
      "Scatter", "Col2Im", "ScatterElements", "ScatterND", "Where"}},
    {{3, 4}, {"FusedConv"}},
    {{3, 5}, {"DeformConv", "Slice"}},
    {{3, 6}, {"Attention", "GRU", "RNN"}},
    {{3, 8}, {"LSTM"}},
    {{5, 5}, {"BatchNormalization"}},
    {{8, 8}, {"QLinearMatMul"}},
    {{8, 9}, {"QLinearConv"}},
};

Counts counts_of(const std::string& operation) {
  for (const auto& [of_these, names] : counts)
    if (names.contains(operation)) return of_these;
  return {1, 1};
}

std::int64_t opset_of(const std::string& operation) {
  for (const VocabularyCase& given : vocabulary_cases())
    if (given.operation == operation) return given.opset;
  return 17;
}

/// The error of a node of so many operands, the same one each.
std::string complaint(const std::string& operation, std::int64_t opset, std::size_t count) {
  OperatorCase given{operation, std::vector<nn::Shape>(count, {1, 2, 3, 4}), {}, {}, opset};
  return complaint_of(given);
}
}  // namespace

TEST_CASE("every operator refuses operands beyond those of ONNX's definition, and too few of them",
          "[nn][network]") {
  std::set<std::string> names;
  for (const auto& entry : nn::operators<double>()) names.insert(entry.first);
  for (const auto& entry : nn::decompositions()) names.insert(entry.first);
  for (const std::string& name : names) {
    const auto [least, most] = counts_of(name);
    const std::int64_t opset = opset_of(name);
    CAPTURE(name, opset);
    for (std::size_t count = 0; count < 11; ++count) {
      CAPTURE(count);
      const bool is_refused =
          complaint(name, opset, count).starts_with(std::to_string(count) + " operands, expected ");
      CHECK(is_refused == (count < least || count > most));
    }
  }
}

TEST_CASE("operands that a later version of an operator has are refused in earlier ones", "[nn][network]") {
  const std::map<std::string, std::pair<std::int64_t, Counts>> before{
      {"Clip", {10, {1, 1}}},      {"Dropout", {11, {1, 1}}},    {"Pad", {10, {1, 1}}},
      {"ReduceSum", {12, {1, 1}}}, {"ReduceMean", {17, {1, 1}}}, {"Resize", {10, {2, 2}}},
      {"Slice", {9, {1, 1}}},      {"Split", {12, {1, 1}}},      {"Squeeze", {12, {1, 1}}},
      {"TopK", {9, {1, 1}}},       {"Unsqueeze", {12, {1, 1}}},  {"Upsample", {8, {1, 1}}}};
  for (const auto& [name, version] : before) {
    CAPTURE(name);
    const auto& [opset, expected] = version;
    CHECK(complaint(name, opset, expected.second + 1) ==
          std::to_string(expected.second + 1) + " operands, expected " + std::to_string(expected.second));
    CHECK(complaint(name, opset, expected.second).find("operands, expected") == std::string::npos);
  }
  CHECK(complaint("Pad", 17, 4) == "4 operands, expected 2 to 3");  // its axes came with opset 18
  CHECK(complaint("Pad", 18, 4).find("operands, expected") == std::string::npos);
}

TEST_CASE("places that are left empty behind the last operand do not count", "[nn][network]") {
  nn::NetworkDescription network = description_of({"Relu", {{2}}});
  network.nodes.back().inputs = {"x0", "", ""};
  CHECK(nn::Network<float>(network).output_shape(0) == nn::Shape{2});
  network.nodes.back().inputs = {"x0", "", "x0"};
  CHECK_THROWS_WITH(nn::Network<float>(network),
                    "net.onnx: 1 node cannot be run: Relu \"y0\" (opset 17): 3 operands, expected 1");
}

TEST_CASE("values of attributes beyond an operator's range are refused by name", "[nn][network]") {
  const auto complaint_with = [](const std::string& operation, const std::string& name,
                                 const nn::Attribute& value) {
    const auto [least, most] = counts_of(operation);
    return complaint_of({operation, std::vector<nn::Shape>(least, {1, 2, 3, 4}), {{name, value}}});
  };
  for (const char* operation : {"Conv", "ConvTranspose", "ChannelShuffle"})
    CHECK(complaint_with(operation, "group", std::int64_t(0)) ==
          "attribute 'group' is out of range: 0, expected 1 to 2147483647");
  for (const char* operation : {"AveragePool", "Conv", "ConvTranspose", "LpPool", "MaxPool"})
    CHECK(complaint_with(operation, "dilations", std::vector<std::int64_t>{1, -2}) ==
          "attribute 'dilations' is out of range: -2, expected 1 to 1048576");
  CHECK(complaint_with("GatherND", "batch_dims", std::int64_t(-1)) ==
        "attribute 'batch_dims' is out of range: -1, expected 0 to 32");
  CHECK(complaint_with("DepthToSpace", "blocksize", std::int64_t(0)) ==
        "attribute 'blocksize' is out of range: 0, expected 1 to 2147483647");
}
