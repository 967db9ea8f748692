#include <tapestry/io/onnx/onnx_file.hpp>

#include <tapestry/io/file_source.hpp>

#include "../../support/catch.hpp"
#include "../../support/onnx_builder.hpp"
#include "../../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
void check_same(const nn::Constant& a, const nn::Constant& b) {
  CHECK(a.shape == b.shape);
  CHECK(a.type == b.type);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    CHECK((a.at(i) == b.at(i) || (a.at(i) != a.at(i) && b.at(i) != b.at(i))));
}

void check_same(const nn::NetworkDescription& a, const nn::NetworkDescription& b) {
  CHECK(a.opset == b.opset);
  CHECK(a.metadata == b.metadata);
  CHECK(a.outputs == b.outputs);
  REQUIRE(a.inputs.size() == b.inputs.size());
  for (std::size_t i = 0; i < a.inputs.size(); ++i) {
    CHECK(a.inputs[i].name == b.inputs[i].name);
    CHECK(a.inputs[i].shape == b.inputs[i].shape);
    CHECK(a.inputs[i].type == b.inputs[i].type);
  }
  REQUIRE(a.constants.size() == b.constants.size());
  for (const auto& [name, constant] : a.constants) check_same(constant, b.constants.at(name));
  REQUIRE(a.nodes.size() == b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    INFO(nn::label_of(a.nodes[i]));
    CHECK(a.nodes[i].name == b.nodes[i].name);
    CHECK(a.nodes[i].operation == b.nodes[i].operation);
    CHECK(a.nodes[i].inputs == b.nodes[i].inputs);
    CHECK(a.nodes[i].outputs == b.nodes[i].outputs);
    REQUIRE(a.nodes[i].attributes.size() == b.nodes[i].attributes.size());
    for (const auto& [name, attribute] : a.nodes[i].attributes) {
      const auto& other = b.nodes[i].attributes.at(name);
      REQUIRE(attribute.index() == other.index());
      if (const auto* constant = std::get_if<nn::Constant>(&attribute)) {
        check_same(*constant, std::get<nn::Constant>(other));
      } else {
        std::visit(
            [&](const auto& value) {
              using Value = std::decay_t<decltype(value)>;
              if constexpr (!std::is_same_v<Value, nn::Constant>) CHECK(value == std::get<Value>(other));
            },
            attribute);
      }
    }
  }
}
}  // namespace

TEST_CASE("models are read from what was written as they were", "[io][onnx][writer]") {
  for (const auto& parts : {onnx::small_model(), onnx::model_of_many()}) {
    const auto network = io::parse_onnx(onnx::model(parts), "foreign.onnx");
    const std::string bytes = io::onnx_bytes(network);
    check_same(network, io::parse_onnx(bytes, "own.onnx"));
    CHECK(io::onnx_bytes(io::parse_onnx(bytes, "own.onnx")) == bytes);
  }
}

TEST_CASE("every kind of attribute, element and extent is written", "[io][onnx][writer]") {
  nn::NetworkDescription network;
  network.opset = 17;
  network.inputs = {{"picture", {std::nullopt, 3, 4}}, {"count", {}, nn::ElementType::integer}};
  network.outputs = {"out"};
  const double inf = std::numeric_limits<double>::infinity();
  using nn::ElementType;
  network.constants["floats"] = {
      {2, 2}, ElementType::floating, std::vector<float>{1.5F, -0.0F, 1e-40F, 3e38F}};
  network.constants["doubles"] = {{3}, ElementType::floating, std::vector<double>{0.25, inf, -0x1p127}};
  network.metadata = {{"author", "some\none"}, {"empty", ""}};
  network.constants["integers"] = {
      {5}, ElementType::integer, std::vector<double>{-5, 1e15, 0x1p63, -0x1p63, 0}};
  network.constants["truths"] = {{2}, ElementType::boolean, std::vector<double>{1, 0}};
  network.constants["scalar"] = {{}, ElementType::floating, std::vector<float>{7}};
  network.constants["none"] = {{0, 3}, ElementType::floating, std::vector<float>{}};
  nn::Node node{"a node", "Pretend", {"picture", "", "floats"}, {"out"}, {}};
  node.attributes["integer"] = std::int64_t(-1) << 40;
  node.attributes["fraction"] = 0.375;
  node.attributes["text"] = std::string("linear\0x", 8);
  node.attributes["integers"] = std::vector<std::int64_t>{-1, 0, 1};
  node.attributes["fractions"] = std::vector<double>{0.5, -2};
  node.attributes["texts"] = std::vector<std::string>{"a", ""};
  node.attributes["tensor"] = network.constants["integers"];
  network.nodes = {node};

  const test::TemporaryFolder folder;
  const std::string path = folder.path("network.onnx");
  io::write_onnx(path, network);
  check_same(network, io::read_onnx(path));
}

TEST_CASE("HardMish is written as operators of ONNX, with its values and slopes", "[io][onnx][writer]") {
  nn::NetworkDescription description;
  description.opset = 18;
  description.inputs = {{"x", {7}}};
  description.nodes = {{"n", "HardMish", {"x"}, {"y"}, {}}};
  description.outputs = {"y"};
  const nn::Network<double> written(io::parse_onnx(io::onnx_bytes(description), "a.onnx"), {}, false, false);
  const nn::Network<double> own(description);
  nn::Buffer<double> x;
  x.resize(7);
  const double values[] = {-4, -2.25, -1.75, -1, -0.25, 0.25, 3};
  std::copy_n(values, 7, x.data());
  nn::NetworkPass<double> a, b;
  written.forward({x.data()}, a, nn::Mode::input_gradient);
  own.forward({x.data()}, b, nn::Mode::input_gradient);
  std::vector<double> ones(7, 1.0), slopes(7, 0.0), own_slopes(7, 0.0);
  written.adjoint(a, {ones.data()}, {slopes.data()});
  own.adjoint(b, {ones.data()}, {own_slopes.data()});
  for (std::size_t i = 0; i < 7; ++i) {
    const double v = values[i];
    const double expected = v > 0 ? v : v > -2 ? v * v / 2 + v : 0;  // Darknet's hard_mish
    CHECK(a.output(0)[i] == expected);
    CHECK(b.output(0)[i] == expected);
    CHECK(slopes[i] == (v > 0 ? 1 : v > -2 ? v + 1 : 0));
    CHECK(own_slopes[i] == slopes[i]);
  }
}

TEST_CASE("a model of doubles is written in single precision throughout", "[io][onnx][writer]") {
  nn::NetworkDescription network;
  network.opset = 17;
  network.inputs = {{"x", {2}}};
  network.constants["w"] = {{2}, nn::ElementType::floating, std::vector<double>{0.1, -1.0 / 3}};
  network.nodes = {{"", "Cast", {"x"}, {"wide"}, {{"to", std::int64_t(onnx::float64)}}},
                   {"", "Mul", {"wide", "w"}, {"y"}, {}},
                   {"", "Cast", {"y"}, {"short"}, {{"to", std::int64_t(onnx::int32)}}}};
  network.outputs = {"y", "short"};
  const auto read = io::parse_onnx(io::onnx_bytes(network), "own.onnx");
  const nn::Constant& w = read.constants.at("w");
  REQUIRE(std::holds_alternative<std::vector<float>>(w.values));  // FLOAT, as the input
  CHECK(std::get<std::vector<float>>(w.values) == std::vector<float>{0.1F, -1.0F / 3});
  CHECK(std::get<std::int64_t>(read.nodes[0].attributes.at("to")) == onnx::float32);
  CHECK(std::get<std::int64_t>(read.nodes[2].attributes.at("to")) == onnx::int64);
  network.constants["w"].values = std::vector<double>{1e300, 0};
  CHECK_THROWS_WITH(io::onnx_bytes(network),
                    contains("write_onnx: 'w' holds 1") && contains("beyond single precision"));
}

TEST_CASE("a model that cannot be written leaves the old file", "[io][onnx][writer][bad_input]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(io::write_onnx(folder.path("absent/network.onnx"), {}), FileError);
}
