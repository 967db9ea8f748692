#pragma once
#include <set>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::test {
/// An operand of a vocabulary case: drawn from [low, high), or a constant setting of the operator.
struct CaseOperand {
  enum class Kind { drawn, setting, left_out };
  Kind kind = Kind::drawn;
  nn::Shape shape{};
  double low = -1, high = 1;
  nn::Constant constant{};  ///< of a setting
};

/// A node whose drawn operands may each be a constant or computed by the network.
struct VocabularyCase {
  std::string operation;
  std::vector<CaseOperand> operands;
  std::map<std::string, nn::Attribute> attributes{};
  std::int64_t opset = 17;
  std::size_t output_count = 1;
};

inline CaseOperand drawn(nn::Shape shape, double low = -1, double high = 1) {
  return {CaseOperand::Kind::drawn, std::move(shape), low, high, {}};
}
inline CaseOperand setting(nn::Shape shape, std::vector<double> values,
                           nn::ElementType type = nn::ElementType::integer) {
  return {CaseOperand::Kind::setting, shape, 0, 0, {shape, type, std::move(values)}};
}
inline CaseOperand left_out() { return {CaseOperand::Kind::left_out, {}, 0, 0, {}}; }

/// Operators whose results have no derivative by any operand: truths, positions, constants, or steps that are
/// compared with differences elsewhere.
inline const std::set<std::string>& operators_without_derivative() {
  static const std::set<std::string> names{
      // Truths.
      "And", "Equal", "Greater", "GreaterOrEqual", "IsInf", "IsNaN", "Less", "LessOrEqual", "Not", "Or",
      "Xor",
      // Positions and constants.
      "ArgMax", "ArgMin", "ConstantOfShape", "EyeLike", "NonMaxSuppression", "NonZero", "OneHot", "Range",
      // Steps, and what runs other nodes.
      "If", "Loop", "StraightRound", "QuantizeLinear", "DynamicQuantizeLinear", "ConvInteger",
      "MatMulInteger", "QLinearConv", "QLinearMatMul"};
  return names;
}

/// Ranges and attributes in lists of one line an operator.
namespace detail {
using Ints = std::vector<std::int64_t>;

inline void add_elementwise_cases(std::vector<VocabularyCase>& all) {
  const auto unary = [&](std::initializer_list<const char*> names, double low, double high) {
    for (const char* name : names) all.push_back({name, {drawn({2, 3}, low, high)}});
  };
  unary({"Abs",  "Atan", "Asinh", "Celu",     "Ceil",     "Cos",       "Cosh",           "Dropout",
         "Elu",  "Erf",  "Exp",   "Floor",    "HardMish", "HardSwish", "Identity",       "LeakyRelu",
         "Mish", "Neg",  "Relu",  "Round",    "Selu",     "Shrink",    "Sigmoid",        "Sign",
         "Sin",  "Sinh", "Swish", "Softplus", "Softsign", "Tanh",      "ThresholdedRelu"},
        -1.9, 1.9);
  unary({"Asin", "Acos", "Atanh", "Tan"}, -0.8, 0.8);
  unary({"Log", "Reciprocal", "Sqrt"}, 0.5, 2);
  unary({"Acosh"}, 1.2, 3);
  unary({"HardSigmoid"}, -4, 4);
  all.push_back({"Gelu", {drawn({2, 3})}, {}, 20});
  all.push_back({"Gelu", {drawn({2, 3})}, {{"approximate", std::string("tanh")}}, 20});
  const auto scalar = [](double value) { return setting({}, {value}, nn::ElementType::floating); };
  all.push_back({"Clip", {drawn({2, 3}), scalar(-0.4), scalar(0.55)}});
  all.push_back({"Cast", {drawn({2, 3})}, {{"to", std::int64_t(1)}}});
  all.push_back({"CastLike", {drawn({2, 3}), drawn({2})}});
  for (const char* name : {"Add", "Sub", "Mul", "PRelu"}) {
    all.push_back({name, {drawn({2, 3}), drawn({2, 3})}});
    all.push_back({name, {drawn({2, 3}), drawn({3})}});
  }
  for (const char* name : {"Add", "Sub", "Mul"}) all.push_back({name, {drawn({3}), drawn({2, 3})}});
  for (const char* name : {"Div", "Mod", "Pow"}) {
    const std::map<std::string, nn::Attribute> attributes =
        name == std::string("Mod") ? std::map<std::string, nn::Attribute>{{"fmod", std::int64_t(1)}}
                                   : std::map<std::string, nn::Attribute>{};
    all.push_back({name, {drawn({2, 3}, 0.5, 2), drawn({2, 3}, 0.7, 2.3)}, attributes});
    all.push_back({name, {drawn({2, 1, 3}, 0.5, 2), drawn({2, 1}, 0.7, 2.3)}, attributes});
  }
  for (const char* name : {"Max", "Mean", "Min", "Sum"}) {
    all.push_back({name, {drawn({2, 3}), drawn({2, 3}), drawn({2, 3})}});
    all.push_back({name, {drawn({2, 3}), drawn({3}), drawn({2, 1})}});
  }
  const auto condition = setting({2, 3}, {1, 0, 0, 1, 1, 0}, nn::ElementType::boolean);
  all.push_back({"Where", {condition, drawn({2, 3}), drawn({3})}});
}

inline void add_convolution_cases(std::vector<VocabularyCase>& all) {
  const Ints pads{1, 1, 1, 1};
  for (const bool has_bias : {false, true}) {
    const auto with_bias = [&](std::vector<CaseOperand> operands, std::size_t channels) {
      if (has_bias) operands.push_back(drawn({channels}));
      return operands;
    };
    all.push_back({"Conv", with_bias({drawn({1, 2, 3, 4}), drawn({3, 2, 3, 3})}, 3), {{"pads", pads}}});
    all.push_back(
        {"Conv", with_bias({drawn({2, 4, 2, 3}), drawn({2, 2, 1, 1})}, 2), {{"group", std::int64_t(2)}}});
    all.push_back({"Conv",
                   with_bias({drawn({1, 3, 3, 3}), drawn({3, 1, 3, 3})}, 3),
                   {{"pads", pads}, {"group", std::int64_t(3)}}});
    all.push_back({"ConvTranspose",
                   with_bias({drawn({1, 2, 2, 3}), drawn({2, 3, 2, 2})}, 3),
                   {{"strides", Ints{2, 2}}}});
    all.push_back({"ConvTranspose",
                   with_bias({drawn({1, 4, 2, 2}), drawn({4, 1, 3, 3})}, 2),
                   {{"pads", pads}, {"group", std::int64_t(2)}}});
  }
  const std::map<std::string, std::pair<double, double>> activations{{"", {}},
                                                                     {"Clip", {-0.7, 0.9}},
                                                                     {"HardSigmoid", {0.2, 0.5}},
                                                                     {"HardSwish", {1.0 / 6, 0.5}},
                                                                     {"Mish", {1, 0}},
                                                                     {"LeakyRelu", {0.1, 0}},
                                                                     {"Relu", {0, 0}},
                                                                     {"Sigmoid", {1, 0}},
                                                                     {"Swish", {1, 0}}};
  for (const auto& [name, numbers] : activations)
    for (const int addend : {0, 1, 2})
      all.push_back({"FusedConv",
                     {drawn({1, 2, 3, 3}), addend == 0 ? left_out() : drawn({1, 2, 3, 3}),
                      drawn({2, 2, 3, 3}), drawn({2})},
                     {{"pads", pads},
                      {"activation", name},
                      {"activation_a", numbers.first},
                      {"activation_b", numbers.second},
                      {"adds_first", std::int64_t(addend == 2)}}});
  all.push_back({"FusedConv",
                 {drawn({1, 2, 3, 3}), drawn({1, 2, 3, 3}), drawn({2, 2, 3, 3})},
                 {{"pads", pads}, {"signs", 0.1}}});
}

/// Operators together with their derivatives.
inline void add_tangent_cases(std::vector<VocabularyCase>& all) {
  const auto of = [](const char* name) {
    return std::map<std::string, nn::Attribute>{{"of", std::string(name)}};
  };
  const auto picture = drawn({1, 2, 3, 4});
  for (const char* name : {"Exp", "LeakyRelu", "Mish", "Relu", "Sigmoid", "Swish"})
    all.push_back({"Tangent", {picture, picture}, of(name), 17, 2});
  all.push_back({"Tangent", {drawn({2, 3}, 0.5, 2), drawn({2, 3})}, of("Sqrt"), 17, 2});
  all.push_back({"Tangent", {picture, picture, setting({1}, {1})}, of("ReduceMax"), 18, 2});
  all.push_back({"TangentPool", {picture, picture}, of("MaxPool"), 17, 2});
  all.back().attributes["kernel_shape"] = Ints{2, 2};
  all.push_back({"TangentPool", {picture, picture}, of("GlobalMaxPool"), 17, 2});
}

inline void add_product_cases(std::vector<VocabularyCase>& all) {
  for (const std::int64_t turns : {0, 1, 2, 3}) {
    const nn::Shape a = turns % 2 == 0 ? nn::Shape{2, 3} : nn::Shape{3, 2};
    const nn::Shape b = turns / 2 == 0 ? nn::Shape{3, 4} : nn::Shape{4, 3};
    const std::map<std::string, nn::Attribute> attributes{
        {"transA", turns % 2}, {"transB", turns / 2}, {"alpha", 0.7}, {"beta", 1.3}};
    all.push_back({"Gemm", {drawn(a), drawn(b)}, attributes});
    all.push_back({"Gemm", {drawn(a), drawn(b), drawn({4})}, attributes});
    all.push_back({"Gemm", {drawn(a), drawn(b), drawn({2, 1})}, attributes});
  }
  all.push_back({"MatMul", {drawn({2, 3}), drawn({3, 2})}});
  all.push_back({"MatMul", {drawn({2, 2, 3}), drawn({3, 2})}});
  all.push_back({"MatMul", {drawn({2, 2, 3}), drawn({2, 3, 2})}});
  all.push_back({"MatMul", {drawn({2, 3}), drawn({2, 3, 2})}});
  all.push_back({"MatMul", {drawn({3}), drawn({3, 2})}});
}

inline void add_normalization_cases(std::vector<VocabularyCase>& all) {
  for (const nn::Shape& shape : {nn::Shape{2, 4, 2, 2}, nn::Shape{3, 4}, nn::Shape{2, 4, 3}}) {
    const auto x = drawn(shape), weight = drawn({4}, 0.5, 2), bias = drawn({4});
    all.push_back({"BatchNormalization", {x, weight, bias, drawn({4}), drawn({4}, 0.5, 2)}});
    all.push_back({"LRN", {x}, {{"size", std::int64_t(3)}, {"alpha", 0.5}}});
    all.push_back({"LayerNormalization", {x, drawn({shape.back()}, 0.5, 2), drawn({shape.back()})}});
    all.push_back({"LayerNormalization", {x, drawn({shape.back()}, 0.5, 2)}});
    if (shape.size() > 2) all.push_back({"InstanceNormalization", {x, weight, bias}});
    all.push_back({"GroupNormalization", {x, weight, bias}, {{"num_groups", std::int64_t(2)}}, 21});
    const auto groups = drawn({2}, 0.5, 2);
    all.push_back({"GroupNormalization", {x, groups, drawn({2})}, {{"num_groups", std::int64_t(2)}}, 18});
  }
  for (const char* name : {"Hardmax", "LogSoftmax", "Softmax"})
    for (const std::int64_t axis : {1, -1}) all.push_back({name, {drawn({2, 3, 2})}, {{"axis", axis}}});
}

inline void add_reduction_cases(std::vector<VocabularyCase>& all) {
  for (const char* name : {"ReduceL1", "ReduceL2", "ReduceLogSum", "ReduceLogSumExp", "ReduceMax",
                           "ReduceMean", "ReduceMin", "ReduceProd", "ReduceSum", "ReduceSumSquare"})
    for (const std::int64_t axis : {1, -1})
      all.push_back({name, {drawn({2, 3, 2}, 0.3, 1.6), setting({1}, {static_cast<double>(axis)})}, {}, 18});
  all.push_back({"CumSum", {drawn({2, 3}), setting({}, {1})}});
  all.push_back({"TopK", {drawn({2, 4}), setting({1}, {2})}, {}, 17, 2});
  const std::map<std::string, nn::Attribute> window{{"kernel_shape", Ints{2, 2}}};
  for (const char* name : {"AveragePool", "LpPool", "MaxPool"})
    all.push_back({name, {drawn({1, 2, 3, 4}, 0.2, 2)}, window});
  for (const char* name : {"GlobalAveragePool", "GlobalLpPool", "GlobalMaxPool"})
    all.push_back({name, {drawn({2, 2, 2, 3}, 0.2, 2)}});
}

inline void add_view_cases(std::vector<VocabularyCase>& all) {
  const auto picture = drawn({1, 4, 2, 4});
  const std::map<std::string, nn::Attribute> twice{{"blocksize", std::int64_t(2)}};
  all.push_back({"ChannelShuffle", {picture}, {{"group", std::int64_t(2)}}});
  all.push_back({"PixelUnshuffle", {picture}, {{"block", Ints{2, 2}}, {"places", Ints{0, 0, 1, 1, 0, 1}}}});
  all.push_back({"InterleaveChannels", {picture, picture}, {{"split", Ints{3, 5}}}, 17, 2});
  all.push_back({"FlattenPixels", {picture}});
  all.push_back({"DepthToSpace", {picture}, twice});
  all.push_back({"SpaceToDepth", {picture}, twice});
  all.push_back({"Reshape", {drawn({2, 3}), setting({2}, {3, 2})}});
  all.push_back({"Flatten", {drawn({2, 3, 2})}});
  all.push_back({"Squeeze", {drawn({2, 1, 3}), setting({1}, {1})}});
  all.push_back({"Unsqueeze", {drawn({2, 3}), setting({1}, {1})}});
  all.push_back({"Transpose", {drawn({2, 3, 2})}, {{"perm", Ints{2, 0, 1}}}});
  all.push_back(
      {"Slice",
       {drawn({2, 5}), setting({1}, {4}), setting({1}, {0}), setting({1}, {1}), setting({1}, {-2})}});
  all.push_back({"Concat", {drawn({2, 2}), drawn({2, 3}), drawn({2, 1})}, {{"axis", std::int64_t(1)}}});
  all.push_back({"Split", {drawn({2, 5}), setting({2}, {2, 3})}, {{"axis", std::int64_t(1)}}, 17, 2});
  all.push_back({"Expand", {drawn({2, 1, 3}), setting({3}, {2, 2, 3})}});
  all.push_back({"Tile", {drawn({2, 3}), setting({2}, {2, 2})}});
  all.push_back({"Trilu", {drawn({3, 3})}});
  for (const char* mode : {"constant", "edge", "reflect"})
    all.push_back({"Pad", {drawn({2, 3}), setting({4}, {0, 1, 1, 1})}, {{"mode", std::string(mode)}}});
  const auto scales = setting({4}, {1, 1, 2, 1.5}, nn::ElementType::floating);
  for (const char* mode : {"cubic", "linear", "nearest"})
    all.push_back({"Resize", {drawn({1, 2, 2, 4}), left_out(), scales}, {{"mode", std::string(mode)}}});
  all.push_back({"Upsample", {drawn({1, 2, 2, 4}), scales}, {{"mode", std::string("nearest")}}, 9});
}

inline void add_index_cases(std::vector<VocabularyCase>& all) {
  for (const char* mode : {"bilinear", "bicubic", "nearest"})
    all.push_back({"GridSample",
                   {drawn({1, 2, 3, 3}), drawn({1, 2, 2, 2}, -0.83, 0.79)},
                   {{"mode", std::string(mode)}},
                   16});
  all.push_back({"Gather", {drawn({3, 2}), setting({4}, {2, 0, 0, 1})}});
  all.push_back(
      {"GatherElements", {drawn({2, 3}), setting({2, 2}, {2, 0, 1, 1})}, {{"axis", std::int64_t(1)}}});
  all.push_back({"GatherND", {drawn({2, 3}), setting({2, 2}, {1, 2, 0, 1})}});
  for (const char* rule : {"none", "add", "mul", "max", "min"}) {
    const std::map<std::string, nn::Attribute> reduction{{"reduction", std::string(rule)}};
    all.push_back({"ScatterND", {drawn({3, 2}), setting({2, 1}, {2, 0}), drawn({2, 2})}, reduction, 18});
    all.push_back(
        {"ScatterElements", {drawn({3, 2}), setting({2, 2}, {2, 0, 1, 1}), drawn({2, 2})}, reduction, 18});
  }
  all.push_back({"Scatter", {drawn({3, 2}), setting({2, 2}, {2, 0, 1, 1}), drawn({2, 2})}, {}, 9});
}

/// Operators that are made of others, and boxes that move.
inline void add_decomposed_cases(std::vector<VocabularyCase>& all) {
  const auto einsum = [&](const char* equation, std::vector<CaseOperand> operands) {
    all.push_back({"Einsum", std::move(operands), {{"equation", std::string(equation)}}});
  };
  einsum("bij,bjk->bik", {drawn({2, 2, 3}), drawn({2, 3, 2})});
  einsum("i,ij,j", {drawn({2}), drawn({2, 3}), drawn({3})});
  einsum("...ii->...i", {drawn({2, 3, 3})});
  einsum("i,j->ji", {drawn({2}), drawn({3})});
  const std::size_t size = 2;
  const auto recurrent = [&](const char* name, std::size_t gates, std::size_t directions, const char* way,
                             std::size_t outputs, std::map<std::string, nn::Attribute> attributes) {
    attributes["direction"] = std::string(way);
    attributes["hidden_size"] = static_cast<std::int64_t>(size);
    all.push_back(
        {name,
         {drawn({3, 1, 2}), drawn({directions, gates * size, 2}), drawn({directions, gates * size, size}),
          drawn({directions, 2 * gates * size}), left_out(), drawn({directions, 1, size})},
         attributes,
         17,
         outputs});
  };
  recurrent("LSTM", 4, 2, "bidirectional", 3, {});
  recurrent("RNN", 1, 1, "reverse", 2, {});
  for (const std::int64_t after : {0, 1})
    recurrent("GRU", 3, 1, "forward", 2, {{"linear_before_reset", after}});
  const auto heads = drawn({1, 2, 3, 2});
  all.push_back({"Attention", {heads, heads, heads}, {{"is_causal", std::int64_t(1)}}, 23});
  all.push_back({"RMSNormalization", {drawn({2, 4}), drawn({4}, 0.5, 2)}, {}, 23});
  all.push_back({"Col2Im", {drawn({1, 4, 4}), setting({2}, {3, 3}), setting({2}, {2, 2})}, {}, 18});
  all.push_back({"DequantizeLinear", {drawn({2, 3}), drawn({3}, 0.5, 2), drawn({3})}});
  all.push_back({"com.microsoft.QuickGelu", {drawn({2, 3})}});
  all.push_back({"Compress",
                 {drawn({3, 2}), setting({3}, {0, 1, 1}, nn::ElementType::boolean)},
                 {{"axis", std::int64_t(0)}}});
  all.push_back(
      {"DeformConv",
       {drawn({1, 2, 4, 4}), drawn({2, 2, 2, 2}), drawn({1, 8, 3, 3}), drawn({2}), drawn({1, 4, 3, 3})},
       {},
       19});
  for (const char* loss : {"NegativeLogLikelihoodLoss", "SoftmaxCrossEntropyLoss"})
    all.push_back({loss, {drawn({2, 3}), setting({2}, {0, 2}), drawn({3}, 0.5, 2)}});
  const Ints pads{1, 1};
  all.push_back({"Conv", {drawn({1, 2, 4}), drawn({3, 2, 3}), drawn({3})}, {{"pads", pads}}});
  all.push_back({"ConvTranspose", {drawn({1, 2, 3}), drawn({2, 3, 2})}, {{"strides", Ints{2}}}});
  all.push_back({"MaxPool", {drawn({1, 2, 4})}, {{"kernel_shape", Ints{2}}}});
  const auto boxes = drawn({2, 4}, 0.3, 4.2), images = setting({2}, {1, 0});
  for (const std::int64_t samples : {0, 2})
    all.push_back({"RoiAlign",
                   {drawn({2, 2, 4, 5}), boxes, images},
                   {{"output_height", std::int64_t(2)},
                    {"output_width", std::int64_t(2)},
                    {"sampling_ratio", samples}}});
}
}  // namespace detail

/// Every operator that has a derivative, in all forms whose adjoints may read other operands.
inline std::vector<VocabularyCase> vocabulary_cases() {
  std::vector<VocabularyCase> all;
  detail::add_elementwise_cases(all);
  detail::add_convolution_cases(all);
  detail::add_tangent_cases(all);
  detail::add_product_cases(all);
  detail::add_normalization_cases(all);
  detail::add_reduction_cases(all);
  detail::add_view_cases(all);
  detail::add_index_cases(all);
  detail::add_decomposed_cases(all);
  return all;
}
}  // namespace tapestry::test
