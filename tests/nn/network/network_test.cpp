#include <tapestry/nn/network/network.hpp>

#include <vector>

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
