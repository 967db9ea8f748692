#include <tapestry/nn/network/program_builder.hpp>

#include "../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
/// A network of one picture x, [2, 6, 7, 8], with drawn constants.
struct Builder {
  nn::NetworkDescription network{"test.onnx", 13, {{"x", {2, 6, 7, 8}}}, {}, {}, {}};

  std::string constant(const std::string& name, const nn::Shape& shape, double low = -1, double high = 1) {
    network.constants[name] = {shape, nn::ElementType::floating,
                               random_values(nn::size_of(shape), network.constants.size() + 1, low, high)};
    return name;
  }
  std::string numbers(const std::string& name, std::vector<double> values) {
    network.constants[name] = {{values.size()}, nn::ElementType::integer, values};
    return name;
  }
  std::string node(const std::string& operation, std::vector<std::string> inputs, const std::string& output,
                   std::map<std::string, nn::Attribute> attributes = {}) {
    network.nodes.push_back({"", operation, std::move(inputs), {output}, std::move(attributes)});
    return output;
  }
  /// A convolution that keeps rows and columns.
  std::string convolution(const std::string& x, std::size_t in, std::size_t out, const std::string& output) {
    const auto weights = constant("w." + output, {out, in, 3, 3}), bias = constant("b." + output, {out});
    return node("Conv", {x, weights, bias}, output, {{"pads", Integers{1, 1, 1, 1}}});
  }
  std::string batch_norm(const std::string& x, std::size_t channels, const std::string& output) {
    std::vector<std::string> inputs{x};
    for (const char* what : {"scale.", "shift.", "mean.", "variance."})
      inputs.push_back(constant(what + output, {channels}, 0.5, 2));
    return node("BatchNormalization", inputs, output);
  }
};

nn::NetworkDescription simple(const nn::NetworkDescription& description) {
  nn::ProgramBuilder<double> builder(description, {{"x", {2, 6, 7, 8}}}, false);
  static_cast<void>(builder.build());
  return nn::simplified(description, builder.facts());
}

std::vector<std::string> operations(const nn::NetworkDescription& description) {
  std::vector<std::string> all;
  for (const nn::Node& node : description.nodes) all.push_back(node.operation);
  return all;
}

/// Checks that results and the gradient with respect to x equal those of the network as described, and that
/// these operations are left.
void check(const Builder& builder, const std::vector<std::string>& expected) {
  CHECK(operations(simple(builder.network)) == expected);
  const nn::Network<double> plain(builder.network, {}, false, false), simple(builder.network);
  const auto x = random_values(672, 9);
  std::vector<std::vector<double>> gradients;
  nn::NetworkPass<double> passes[2];
  for (const auto* network : {&plain, &simple}) {
    auto& pass = passes[gradients.size()];
    network->forward({x.data()}, pass, nn::Mode::input_gradient);
    std::vector<nn::Buffer<double>> adjoints;
    for (std::size_t i = 0; i < network->output_count(); ++i) {
      const auto drawn = random_values(nn::size_of(network->output_shape(i)), 20 + i);
      adjoints.emplace_back(drawn.size());
      std::copy(drawn.begin(), drawn.end(), adjoints.back().data());
    }
    gradients.emplace_back(x.size(), 0.0);
    network->adjoint(pass, addresses(adjoints), {gradients.back().data()});
  }
  for (std::size_t i = 0; i < plain.output_count(); ++i) {
    REQUIRE(plain.output_shape(i) == simple.output_shape(i));
    const std::size_t count = nn::size_of(plain.output_shape(i));
    const std::vector<double> one(passes[0].output(i), passes[0].output(i) + count);
    const std::vector<double> other(passes[1].output(i), passes[1].output(i) + count);
    CHECK(largest_difference(other, one) <= 1e-11);
  }
  CHECK(largest_difference(gradients[1], gradients[0]) <= 1e-11);
}
}  // namespace

TEST_CASE("copies are left out, but for results", "[nn][network][simplify]") {
  Builder b;
  b.node("Identity", {"x"}, "a");
  b.node("Dropout", {"a"}, "b");
  b.node("Relu", {"b"}, "c");
  b.node("Identity", {"c"}, "d");
  b.network.outputs = {"d", "c"};
  check(b, {"Relu", "Identity"});
}

TEST_CASE("Casts from one floating-point type to another are left out, others stay",
          "[nn][network][simplify]") {
  const std::int64_t half = 10, single = 1, integer = 7;
  Builder b;
  b.node("Cast", {b.convolution("x", 6, 4, "c")}, "a", {{"to", half}});
  b.node("Relu", {"a"}, "r");
  b.node("CastLike", {"r", "x"}, "k");
  b.node("Cast", {"k"}, "whole", {{"to", integer}});
  b.node("Cast", {"whole"}, "y", {{"to", single}});
  b.node("Cast", {"k"}, "result", {{"to", half}});
  b.network.outputs = {"y", "result"};
  check(b, {"FusedConv", "Cast", "Cast", "Cast"});
}

TEST_CASE("x times its gate is one function", "[nn][network][simplify]") {
  Builder b;
  b.node("Sigmoid", {"x"}, "s");
  b.node("Mul", {"x", "s"}, "a");
  b.node("HardSigmoid", {"a"}, "h", {{"alpha", static_cast<double>(1.0F / 6)}, {"beta", 0.5}});
  b.node("Mul", {"h", "a"}, "y");
  b.network.outputs = {"y"};
  CHECK(operations(simple(b.network)) == std::vector<std::string>{"Swish", "HardSwish"});
  b.network.nodes[2].attributes.erase("alpha");  // 0.2
  check(b, {"Swish", "HardSigmoid", "Mul"});
  b.network.outputs = {"y", "s"};
  check(b, {"Sigmoid", "Mul", "HardSigmoid", "Mul"});
}

TEST_CASE("HardSwish in four operators is one function", "[nn][network][simplify]") {
  const bool divides = GENERATE(true, false), is_last = GENERATE(true, false);
  CAPTURE(divides, is_last);
  const auto network = [&](double raise, double least, double most, double sixth) {
    Builder b;
    for (const auto& [name, value] :
         std::map<std::string, double>{{"3", raise},
                                       {"0", least},
                                       {"6", most},
                                       {"sixth", divides ? sixth : static_cast<double>(float(1 / sixth))}})
      b.network.constants[name] = {{}, nn::ElementType::floating, std::vector<double>{value}};
    const char* const scale = divides ? "Div" : "Mul";
    b.node("Add", {"3", "x"}, "a");
    b.node("Clip", {"a", "0", "6"}, "c");
    b.node(is_last ? "Mul" : scale, {"c", is_last ? "x" : "sixth"}, "d");
    b.node(is_last ? scale : "Mul", {"d", is_last ? "sixth" : "x"}, "y");
    b.network.outputs = {"y"};
    return b;
  };
  const Builder b = network(3, 0, 6, 6);
  CHECK(operations(simple(b.network)) == std::vector<std::string>{"HardSwish"});
  // In single precision: each of the four rounds once, and |y| is at most |x|.
  const nn::Network<float> plain(b.network, {}, false, false), merged(b.network);
  std::vector<float> x;
  for (const double value : random_values(672, 9, -5, 5)) x.push_back(static_cast<float>(value));
  x.resize(x.size() + 32);
  nn::NetworkPass<float> passes[2];
  plain.forward({x.data()}, passes[0]);
  merged.forward({x.data()}, passes[1]);
  constexpr float epsilon = std::numeric_limits<float>::epsilon();
  for (std::size_t i = 0; i < 672; ++i)
    CHECK(std::abs(passes[0].output(0)[i] - passes[1].output(0)[i]) <= 4 * epsilon * std::abs(x[i]));
  for (const Builder& other :
       {network(2, 0, 6, 6), network(3, -1, 6, 6), network(3, 0, 5, 6), network(3, 0, 6, 5)})
    CHECK(operations(simple(other.network)).size() == 4);
}

TEST_CASE("batch normalisations and scalings go into the weights before them", "[nn][network][simplify]") {
  Builder b;
  b.convolution("x", 6, 5, "a");
  b.batch_norm("a", 5, "b");
  b.node("Mul", {b.constant("m", {1, 5, 1, 1}), "b"}, "c");
  b.node("Add", {"c", b.constant("p", {5, 1, 1})}, "d");
  b.node("Div", {"d", b.constant("q", {1}, 1, 2)}, "e");
  b.node("Sub", {b.constant("r", {}), "e"}, "f");
  b.network.outputs = {"f"};
  check(b, {"Conv"});
  CHECK(simple(b.network).constants.size() == 2);
  SECTION("but not where others read the value") {
    b.network.outputs = {"f", "b"};
    check(b, {"Conv", "Mul", "Add", "Div", "Sub"});
  }
  SECTION("weights of others stay as they are") {
    b.node("Conv", {"x", "w.a", "b.a"}, "g", {{"pads", Integers{1, 1, 1, 1}}});
    b.network.outputs = {"f", "g"};
    check(b, {"Conv", "Conv"});
    CHECK(simple(b.network).constants.size() == 4);
  }
  SECTION("nor what scales columns") {
    b.node("Mul", {"f", b.constant("columns", {8})}, "g");
    b.network.outputs = {"g"};
    check(b, {"Conv", "Mul"});
  }
}

TEST_CASE("transposed convolutions and Gemm take scalings, too", "[nn][network][simplify]") {
  Builder b;
  SECTION("ConvTranspose in groups") {
    b.node("ConvTranspose", {"x", b.constant("w", {6, 2, 3, 2})}, "a",
           {{"group", std::int64_t(3)}, {"strides", Integers{2, 1}}});
    b.batch_norm("a", 6, "y");
    b.network.outputs = {"y"};
    check(b, {"ConvTranspose"});
  }
  SECTION("Gemm") {
    const auto turns = GENERATE(std::int64_t(0), std::int64_t(1));
    const auto c = GENERATE(nn::Shape{}, nn::Shape{1}, nn::Shape{9}, nn::Shape{1, 9}, nn::Shape{0});
    b.node("GlobalAveragePool", {"x"}, "mean");
    b.node("Flatten", {"mean"}, "flat");
    std::vector<std::string> inputs{"flat", b.constant("w", turns != 0 ? nn::Shape{9, 6} : nn::Shape{6, 9})};
    if (c != nn::Shape{0}) inputs.push_back(b.constant("c", c));
    b.node("Gemm", inputs, "a", {{"transB", turns}, {"alpha", 0.5}, {"beta", 3.0}});
    b.batch_norm("a", 9, "y");
    b.network.outputs = {"y"};
    check(b, {"GlobalAveragePool", "Flatten", "Gemm"});
  }
}

TEST_CASE("convolutions apply what follows them", "[nn][network][simplify]") {
  Builder b;
  SECTION("an activation") {
    const auto name = GENERATE(as<std::string>(), "Relu", "LeakyRelu", "Sigmoid", "HardSigmoid", "HardSwish",
                               "Mish", "Swish");
    b.convolution("x", 6, 16, "a");
    b.node(name, {"a"}, "y");
    b.network.outputs = {"y"};
    check(b, {"FusedConv"});
    b.network.outputs = {"y", "a"};
    check(b, {"Conv", name});
  }
  SECTION("PRelu of one slope, but not of several, and no slope that is computed") {
    b.convolution("x", 6, 16, "a");
    b.network.constants["one"] = {{16, 1, 1}, nn::ElementType::floating, std::vector<double>(16, 0.25)};
    b.node("PRelu", {"a", "one"}, "b");
    b.convolution("b", 16, 4, "c");
    b.node("PRelu", {"c", b.constant("several", {4, 1, 1}, 0.1, 0.9)}, "d");
    b.convolution("d", 4, 4, "e");
    b.network.constants["below"] = {{1}, nn::ElementType::floating, std::vector<double>{-0.5}};
    b.node("PRelu", {"e", "below"}, "f");
    b.convolution("f", 4, 4, "g");
    b.node("PRelu", {"f", "g"}, "y");
    b.network.outputs = {"y"};
    check(b, {"FusedConv", "Conv", "PRelu", "Conv", "PRelu", "Conv", "PRelu"});
  }
  SECTION("Clip with one bound, or two, or attributes") {
    b.convolution("x", 6, 16, "a");
    b.node("Clip", {"a", b.constant("low", {}, -0.5, -0.4), ""}, "b");
    b.convolution("b", 16, 4, "c");
    b.node("Clip", {"c", "", b.constant("high", {}, 0.5, 0.6)}, "d");
    b.network.outputs = {"d"};
    check(b, {"FusedConv", "FusedConv"});
    b.network.opset = 10;
    for (nn::Node& node : b.network.nodes)
      if (node.operation == "Clip") node.inputs.resize(1), node.attributes = {{"min", -0.5}, {"max", 6.0}};
    check(b, {"FusedConv", "FusedConv"});
  }
  SECTION("an addition behind an activation, and one before") {
    b.convolution("x", 6, 16, "a");
    b.node("Sigmoid", {"a"}, "s");
    b.node("Mul", {"a", "s"}, "b");
    b.convolution("b", 16, 16, "c");
    b.node("Relu", {"c"}, "d");
    b.node("Add", {"d", "b"}, "e");
    b.convolution("e", 16, 16, "f");
    b.node("Add", {"b", "f"}, "g");
    b.node("Relu", {"g"}, "h");
    b.network.outputs = {"h"};
    check(b, {"FusedConv", "FusedConv", "FusedConv"});
  }
  SECTION("of two convolutions that are added the second") {
    b.convolution("x", 6, 4, "a");
    b.convolution("x", 6, 4, "b");
    b.node("Add", {"a", "b"}, "y");
    b.network.outputs = {"y"};
    check(b, {"Conv", "FusedConv"});
  }
  SECTION("but no addition that repeats") {
    b.convolution("x", 6, 4, "a");
    b.node("GlobalAveragePool", {"x"}, "m");
    b.convolution("m", 6, 4, "b");
    b.node("Add", {"a", "b"}, "y");
    b.node("Add", {"y", "y"}, "z");
    b.network.outputs = {"z"};
    check(b, {"Conv", "GlobalAveragePool", "Conv", "Add", "Add"});
  }
}

TEST_CASE("channels that are shuffled by three nodes are by one", "[nn][network][simplify]") {
  Builder b;
  b.node("Reshape", {"x", b.numbers("five", {2, 3, 2, 7, 8})}, "a");
  b.node("Transpose", {"a"}, "b", {{"perm", Integers{0, 2, 1, 3, 4}}});
  b.node("Reshape", {"b", b.numbers("four", {2, -1, 7, 8})}, "c");
  b.convolution("c", 6, 4, "y");
  b.network.outputs = {"y"};
  check(b, {"ChannelShuffle", "Conv"});
  b.numbers("four", {2, -1, 8, 7});
  check(b, {"Reshape", "Transpose", "Reshape", "Conv"});
}

TEST_CASE("joined, shuffled and cut channels are interleaved", "[nn][network][simplify]") {
  Builder b;
  b.convolution("x", 6, 7, "p");
  b.node("Relu", {"p"}, "r");
  b.node("Sin", {"p"}, "q");
  b.node("Concat", {"r", "q"}, "j", {{"axis", std::int64_t(1)}});
  b.node("Reshape", {"j", b.numbers("five", {2, 2, 7, 7, 8})}, "a");
  b.node("Transpose", {"a"}, "b", {{"perm", Integers{0, 2, 1, 3, 4}}});
  b.node("Reshape", {"b", b.numbers("four", {2, 14, 7, 8})}, "c");
  b.node("Sin", {"c"}, "whole");
  b.network.outputs = {"whole"};
  check(b, {"Conv", "Relu", "Sin", "InterleaveChannels", "Sin"});
  b.network.nodes.pop_back();
  b.network.nodes.push_back(
      {"", "Split", {"c", b.numbers("sizes", {5, 9})}, {"d", "e"}, {{"axis", std::int64_t(-3)}}});
  b.node("Sin", {"d"}, "y");
  b.network.outputs = {"y", "e"};
  check(b, {"Conv", "Relu", "Sin", "InterleaveChannels", "Sin"});
}

TEST_CASE("rows and columns that are taken in steps are blocks of pixels", "[nn][network][simplify]") {
  Builder b;
  const auto slice = [&](const std::string& x, double first, double axis, double step, const std::string& y) {
    std::vector<std::string> inputs{x};
    for (const double value : {first, 1e9, axis, step})
      inputs.push_back(b.numbers(y + std::to_string(inputs.size()), {value}));
    return b.node("Slice", inputs, y);
  };
  b.node("Pad", {"x", b.numbers("pads", {0, 0, 0, 0, 0, 0, 1, 0})}, "p");  // [2, 6, 8, 8]
  b.node("Sin", {"p"}, "s");
  slice(slice("s", 0, 2, 2, "r0"), 0, 3, 2, "a");
  slice(slice("s", 0, 2, 2, "r1"), 1, 3, 2, "b");
  slice(slice("s", 1, -2, 2, "r2"), 0, -1, 2, "c");
  slice(slice("s", 1, 2, 2, "r3"), 1, 3, 2, "d");
  b.node("Concat", {"a", "c", "b", "d"}, "y", {{"axis", std::int64_t(1)}});
  b.network.outputs = {"y"};
  check(b, {"Pad", "Sin", "PixelUnshuffle"});
  b.numbers("r31", {-7});  // counted from the end
  CHECK(operations(simple(b.network)).size() > 3);
}

TEST_CASE("pictures that become rows of pixels stay as they lie", "[nn][network][simplify]") {
  Builder b;
  b.convolution("x", 6, 5, "a");
  b.node("Reshape", {"a", b.numbers("flat", {2, 5, -1})}, "b");
  SECTION("one") {
    b.node("Transpose", {"b"}, "y", {{"perm", Integers{0, 2, 1}}});
    b.network.outputs = {"y"};
    check(b, {"Conv", "FlattenPixels"});
  }
  SECTION("several that are joined") {
    b.node("MaxPool", {"a"}, "c", {{"kernel_shape", Integers{2, 2}}});
    b.node("Reshape", {"c", "flat"}, "d");
    b.node("Concat", {"b", "d"}, "e", {{"axis", std::int64_t(-1)}});
    b.node("Transpose", {"e"}, "y", {{"perm", Integers{0, 2, 1}}});
    b.network.outputs = {"y"};
    check(b, {"Conv", "FlattenPixels", "MaxPool", "FlattenPixels", "Concat"});
  }
}

TEST_CASE("operations of simplified networks pull adjoints back to what is fresh and what is not",
          "[nn][network][simplify][gradient]") {
  const auto x = given({2, 19, 4, 6}, 1);
  check_adjoints(operator_network("PixelUnshuffle", {x},
                                  {{"block", Integers{2, 3}}, {"places", Integers{1, 2, 0, 0, 1, 1}}}));
  check_adjoints(operator_network("FlattenPixels", {x}));
  check_adjoints(operator_network("InterleaveChannels", {x, given({2, 19, 4, 6}, 2)}));
  check_adjoints(operator_network("ChannelShuffle", {given({2, 18, 4, 6}, 1)}, {{"group", std::int64_t(3)}}));
}

TEST_CASE("zeros around a picture go into the padding behind them", "[nn][network][simplify]") {
  Builder b;
  b.node("Pad", {"x", b.numbers("pads", {0, 0, 1, 2, 0, 0, 3, 0})}, "a");
  SECTION("of a convolution") {
    b.convolution("a", 6, 4, "y");
    b.network.outputs = {"y"};
    check(b, {"Conv"});
    b.numbers("pads", {0, 0, 1, -1, 0, 0, 3, 0});
    check(b, {"Pad", "Conv"});
  }
  SECTION("of an average") {
    b.node("AveragePool", {"a"}, "y", {{"kernel_shape", Integers{4, 3}}, {"strides", Integers{2, 3}}});
    b.network.outputs = {"y"};
    check(b, {"AveragePool"});
    b.network.nodes.back().attributes["pads"] = Integers{1, 0, 0, 1};
    check(b, {"Pad", "AveragePool"});
  }
  SECTION("but no other values") {
    b.network.nodes.back().inputs.push_back(b.constant("value", {}));
    b.convolution("a", 6, 4, "y");
    b.network.outputs = {"y"};
    check(b, {"Pad", "Conv"});
  }
}

TEST_CASE("what is known beforehand is a constant", "[nn][network][simplify]") {
  Builder b;
  b.node("Relu", {b.constant("w", {4, 6, 1, 1})}, "weights");
  b.node("Conv", {"x", "weights"}, "y");
  b.node("Relu", {"x"}, "unread");
  b.network.outputs = {"y"};
  check(b, {"Conv"});
}
