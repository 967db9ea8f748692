#include <tapestry/nn/network/network.hpp>

#include "../../support/catch.hpp"

namespace nn = tapestry::nn;

namespace {
nn::NetworkDescription one_node(nn::Node node, std::vector<std::optional<std::size_t>> shape) {
  nn::NetworkDescription description;
  description.path = "net.onnx";
  description.opset = 13;
  description.inputs = {{"x", std::move(shape)}};
  description.outputs = {"y"};
  node.inputs = {"x"};
  node.outputs = {"y"};
  description.nodes = {std::move(node)};
  return description;
}
}  // namespace

TEMPLATE_TEST_CASE("a network of one node passes values on, and adjoints back", "[nn][network]", float,
                   double) {
  const nn::Network<TestType> network(one_node({"", "Identity"}, {2, 3}));
  nn::Buffer<TestType> x(6);
  for (std::size_t i = 0; i < 6; ++i) x.data()[i] = static_cast<TestType>(i);
  nn::NetworkPass<TestType> pass;
  network.forward({x.data()}, pass, nn::Mode::input_gradient);
  std::vector<TestType> gradient(6, TestType(1));
  network.adjoint(pass, {x.data()}, {gradient.data()});
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(pass.output(0)[i] == static_cast<TestType>(i));
    CHECK(gradient[i] == static_cast<TestType>(i + 1));
  }
}

TEST_CASE("a network that cannot be run names every node and why", "[nn][network]") {
  auto description = one_node({"first", "Foo"}, {2, 3});
  description.nodes.push_back({"second", "Identity", {"x"}, {"z"}, {{"speed", std::int64_t(3)}}});
  description.nodes.push_back({"third", "Identity", {"y"}, {"w"}, {}});  // reads what could not be made
  CHECK_THROWS_WITH(
      nn::Network<double>(description),
      "net.onnx: 2 nodes cannot be run: Foo \"first\" (opset 13): the operator is not supported; "
      "Identity \"second\" (opset 13): attribute 'speed' is not supported");
}

TEST_CASE("an open extent takes the size that is asked for, and is an error without", "[nn][network]") {
  const auto description = one_node({"", "Identity"}, {std::nullopt, 3, std::nullopt});
  CHECK(nn::Network<double>(description, {{"x", {2, 3, 5}}}).output_shape(0) == nn::Shape{2, 3, 5});
  CHECK_THROWS_WITH(nn::Network<double>(description),
                    "net.onnx: input 'x' has an open extent at axis 2; state the input's size");
}

TEST_CASE("extents that a network asks for are worked out beforehand", "[nn][network]") {
  nn::NetworkDescription description;
  description.opset = 13;
  description.inputs = {{"x", {std::nullopt, 6}}};
  description.outputs = {"y", "count"};
  const auto whole = [](std::vector<double> values) {
    return nn::Constant{{values.size()}, nn::ElementType::integer, values};
  };
  description.constants = {{"first", whole({0})}, {"others", whole({2, -1})}};
  description.nodes = {{"", "Shape", {"x"}, {"extents"}, {}},
                       {"", "Gather", {"extents", "first"}, {"batch"}, {}},
                       {"", "Concat", {"batch", "others"}, {"wanted"}, {{"axis", std::int64_t(0)}}},
                       {"", "Reshape", {"x", "wanted"}, {"y"}, {}},
                       {"", "Size", {"y"}, {"count"}, {}}};
  const nn::Network<float> network(description, {{"x", {5, 6}}});
  CHECK(network.output_shape(0) == nn::Shape{5, 2, 3});
  nn::Buffer<float> x(30);
  nn::NetworkPass<float> pass;
  network.forward({x.data()}, pass);
  CHECK(pass.output(1)[0] == 30.0F);
}

TEST_CASE("values that nothing makes are refused", "[nn][network]") {
  auto description = one_node({"", "Relu"}, {2});
  description.nodes[0].inputs = {"w"};
  CHECK_THROWS_WITH(nn::Network<double>(description),
                    "net.onnx: 1 node cannot be run: Relu \"y\": nothing makes its input 'w'");
  description = one_node({"", "Relu"}, {2});
  description.outputs = {"z"};
  CHECK_THROWS_WITH(nn::Network<double>(description), "net.onnx: nothing makes the output 'z'");
}

TEST_CASE("results that are not supported are refused of constants, too", "[nn][network]") {
  auto description = one_node({"", "Relu"}, {2});
  description.constants["x"] = {{2}, nn::ElementType::floating, std::vector<float>{1, 2}};
  description.inputs.clear();
  description.nodes[0].outputs.push_back("z");
  CHECK_THROWS_WITH(nn::Network<double>(description),
                    "net.onnx: 1 node cannot be run: Relu \"y\" (opset 13): result 1 is not supported");
}

TEST_CASE("results that are a constant or an input outlive the network, its constants and the input",
          "[nn][network]") {
  nn::NetworkDescription description = one_node({"", "MatMul"}, {1, 2});
  description.nodes[0].inputs.push_back("w");
  description.outputs = {"y", "w", "x", "w"};
  description.constants["w"] = {{2, 2}, nn::ElementType::floating, std::vector<double>{3, 0, 0, 5}};
  auto network = std::make_unique<nn::Network<double>>(description);
  auto x = std::make_unique<nn::Buffer<double>>(2);
  x->data()[0] = 7, x->data()[1] = 11;
  nn::NetworkPass<double> pass, gone;
  network->forward({x->data()}, pass, nn::Mode::training);
  network->forward({x->data()}, gone);
  std::vector<double> other(network->weights().begin(), network->weights().end());
  for (double& weight : other) weight *= 10;
  network->set_weights(other);
  const auto results = [](const nn::NetworkPass<double>& of) {
    constexpr std::size_t sizes[] = {2, 4, 2, 4};
    std::vector<double> values;
    for (std::size_t i = 0; i < 4; ++i) values.insert(values.end(), of.output(i), of.output(i) + sizes[i]);
    return values;
  };
  const std::vector<double> before{21, 55, 3, 0, 0, 5, 7, 11, 3, 0, 0, 5};
  CHECK(results(pass) == before);
  network->forward({x->data()}, pass);
  network.reset();
  x.reset();
  CHECK(results(gone) == before);
  CHECK(results(pass) == std::vector<double>{210, 550, 30, 0, 0, 50, 7, 11, 30, 0, 0, 50});
}

TEST_CASE("the adjoint of a weight counts other nodes that read it, and that it is a result",
          "[nn][network][gradient]") {
  const bool is_result = GENERATE(false, true);
  nn::NetworkDescription description;
  description.opset = 13;
  description.inputs = {{"x", {2, 2}}};
  description.outputs = {"y"};
  if (is_result) description.outputs.push_back("w");
  description.constants["w"] = {{2, 2}, nn::ElementType::floating, std::vector<double>{0.3, -0.7, 0.45, 0.2}};
  description.nodes = {{"", "MatMul", {"x", "w"}, {"product"}, {}},
                       {"", "Tanh", {"product"}, {"bent"}, {}},
                       {"", "Add", {"bent", "w"}, {"y"}, {}}};
  nn::Network<double> network(description);
  REQUIRE(network.weight_blocks().size() == 1);
  nn::Buffer<double> x(4), adjoint(4);
  for (std::size_t i = 0; i < 4; ++i) {
    x.data()[i] = 0.5 - 0.3 * static_cast<double>(i);
    adjoint.data()[i] = 1 + 0.2 * static_cast<double>(i);
  }
  nn::NetworkPass<double> pass;
  network.forward({x.data()}, pass, nn::Mode::training);
  std::vector<double> gradient(network.weights().size(), 0.0);
  network.adjoint(pass, {adjoint.data(), adjoint.data()}, {nullptr}, gradient.data());
  const auto value_at = [&](std::size_t i, double step) {
    auto moved = description;
    std::get<std::vector<double>>(moved.constants["w"].values)[i] += step;
    const nn::Network<double> beside(moved);  // a constant result lies in it
    beside.forward({x.data()}, pass);
    double sum = 0;
    for (std::size_t result = 0; result < description.outputs.size(); ++result)
      for (std::size_t k = 0; k < 4; ++k) sum += adjoint.data()[k] * pass.output(result)[k];
    return sum;
  };
  // Third derivatives of tanh(x · w) by w stay below 2 · |x|³ < 1: with h = 1e-5 truncation is below 1e-10,
  // and so is rounding, 4 ε/h.
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i, is_result);
    const double difference = (value_at(i, 1e-5) - value_at(i, -1e-5)) / 2e-5;
    CHECK(std::abs(gradient[network.weight_blocks()[0].offset + i] - difference) <= 1e-9);
  }
}

TEST_CASE("weights that nodes have moved are named as the file's, with the places of their elements",
          "[nn][network][gradient]") {
  nn::NetworkDescription description;
  description.opset = 13;
  description.inputs = {{"x", {2, 3}}};
  description.outputs = {"y"};
  std::vector<double> elements(24);
  for (std::size_t i = 0; i < 24; ++i) elements[i] = std::sin(static_cast<double>(i));
  description.constants["w"] = {{2, 4, 3}, nn::ElementType::floating, elements};
  for (const auto& [name, value] : std::map<std::string, double>{{"one", 1}, {"two", 2}, {"first", 0}})
    description.constants[name] = {{1}, nn::ElementType::integer, std::vector<double>{value}};
  description.nodes = {{"", "Slice", {"w", "one", "two", "first"}, {"second"}, {}},
                       {"", "Squeeze", {"second", "first"}, {"rows"}, {}},
                       {"", "Transpose", {"rows"}, {"columns"}, {}},
                       {"", "MatMul", {"x", "columns"}, {"y"}, {}}};
  const nn::Network<double> network(description, {}, false, false);
  REQUIRE(network.weight_blocks().size() == 1);
  const nn::WeightBlock& block = network.weight_blocks().front();
  CHECK(block.name == "w");
  CHECK(block.constant_shape == nn::Shape{2, 4, 3});
  const auto places = nn::Network<double>::places_of(block);
  REQUIRE(places.size() == 12);
  nn::Buffer<double> x(6), adjoint(8);
  for (std::size_t i = 0; i < 6; ++i) x.data()[i] = std::cos(static_cast<double>(i));
  for (std::size_t i = 0; i < 8; ++i) adjoint.data()[i] = static_cast<double>(i) - 3;
  nn::NetworkPass<double> pass;
  network.forward({x.data()}, pass, nn::Mode::training);
  std::vector<double> gradient(network.weights().size(), 0.0);
  network.adjoint(pass, {adjoint.data()}, {nullptr}, gradient.data());
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK(network.weights()[block.offset + i] == elements[places[i]]);
    const std::size_t row = places[i] / 3 - 4, column = places[i] % 3;  // of the second matrix
    const double expected =
        adjoint.data()[row] * x.data()[column] + adjoint.data()[4 + row] * x.data()[3 + column];
    CHECK(gradient[block.offset + i] == Approx(expected).epsilon(1e-14));
  }
}

TEST_CASE("the adjoint of a weight that is a result is the sum of a batch's", "[nn][network][batch]") {
  nn::NetworkDescription description = one_node({"", "MatMul"}, {1, 1});
  description.nodes[0].inputs.push_back("w");
  description.outputs = {"y", "w"};
  description.constants["w"] = {{1, 2}, nn::ElementType::floating, std::vector<double>{3, 5}};
  const nn::Network<double> network(description);
  REQUIRE(network.weight_blocks().size() == 1);
  nn::Buffer<double> x(3), adjoint(6);
  for (std::size_t n = 0; n < 3; ++n) x.data()[n] = static_cast<double>(n);
  for (std::size_t i = 0; i < 6; ++i) adjoint.data()[i] = std::pow(2, i);
  nn::NetworkPass<double> pass;
  network.forward({x.data()}, pass, nn::Mode::training, 3);
  for (std::size_t n = 0; n < 3; ++n) {
    CHECK(pass.output(0)[2 * n + 1] == 5 * x.data()[n]);
    CHECK(pass.output(1)[2 * n + 1] == 5);
  }
  std::vector<double> gradient(network.weights().size(), 0.0);
  network.adjoint(pass, {adjoint.data(), adjoint.data()}, {nullptr}, gradient.data());
  const double* const of_weight = gradient.data() + network.weight_blocks()[0].offset;
  CHECK(of_weight[0] == (1 + 4 + 16) + (0 * 1 + 1 * 4 + 2 * 16));
  CHECK(of_weight[1] == (2 + 8 + 32) + (0 * 2 + 1 * 8 + 2 * 32));
}
