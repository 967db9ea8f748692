#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/staged_network.hpp>

#include "../../support/operator_case.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;
using Names = std::vector<std::string>;

nn::Constant whole(double value) { return {{}, nn::ElementType::integer, Numbers{value}}; }
nn::Constant truth(bool value) { return {{}, nn::ElementType::boolean, Numbers{value ? 1.0 : 0.0}}; }
nn::Constant real(double value) { return {{}, nn::ElementType::floating, Numbers{value}}; }

std::shared_ptr<const nn::Subgraph> graph(Names inputs, std::vector<nn::Node> nodes, Names outputs,
                                          Names captured,
                                          std::map<std::string, nn::Constant> constants = {}) {
  return std::make_shared<const nn::Subgraph>(nn::Subgraph{
      std::move(inputs), std::move(outputs), std::move(constants), std::move(nodes), std::move(captured)});
}

nn::NetworkDescription described(std::vector<nn::Node> nodes, Names outputs, nn::Shape shape = {4}) {
  nn::NetworkDescription network;
  network.path = "net.onnx";
  network.opset = 18;
  network.inputs = {{"x", {shape.begin(), shape.end()}}};
  network.nodes = std::move(nodes);
  network.outputs = std::move(outputs);
  return network;
}

/// A network with one pass.
struct Run {
  nn::StagedNetwork<double> network;
  nn::StagedPass<double> pass{};
  Numbers x{};

  explicit Run(const nn::NetworkDescription& description) : network(description) {}

  Numbers operator()(Numbers values, std::size_t output = 0) {
    x = std::move(values);
    x.resize(x.size() + 16);
    network.forward({x.data()}, pass, nn::Mode::input_gradient);
    const double* const first = pass.output(output);
    return Numbers(first, first + nn::size_of(pass.output_shape(output)));
  }
  /// Of the sum of the first result.
  Numbers gradient() {
    const Numbers ones(nn::size_of(pass.output_shape(0)) + 16, 1.0);
    std::vector<const double*> adjoints(pass.output_count(), nullptr);
    adjoints[0] = ones.data();
    Numbers sum(nn::size_of(network.input_shape(0)));
    network.adjoint(pass, adjoints, {sum.data()});
    return sum;
  }
};

/// y = sin x if Σ x > 0, else 3 x.
nn::NetworkDescription sine_or_triple() {
  nn::NetworkDescription network = described(
      {{"", "ReduceSum", {"x"}, {"sum"}, {{"keepdims", std::int64_t(0)}}},
       {"", "Greater", {"sum", "zero"}, {"is positive"}, {}},
       {"",
        "If",
        {"is positive", "x", "three", "x"},
        {"y"},
        {{"else_branch", graph({}, {{"", "Mul", {"x", "three"}, {"z"}, {}}}, {"z"}, {"x", "three"})},
         {"then_branch", graph({}, {{"", "Sin", {"x"}, {"z"}, {}}}, {"z"}, {"x"})}}}},
      {"y"});
  network.constants = {{"zero", real(0)}, {"three", real(3)}};
  return network;
}

/// Doubles v until Σ v is over 10, or `most` times; y = v, and all sums.
nn::NetworkDescription doubled(double most) {
  const auto body = graph({"i", "goes on", "v"},
                          {{"", "Add", {"v", "v"}, {"twice"}, {}},
                           {"", "ReduceSum", {"twice"}, {"sum"}, {{"keepdims", std::int64_t(0)}}},
                           {"", "Less", {"sum", "ten"}, {"is small"}, {}}},
                          {"is small", "twice", "sum"}, {"ten"});
  nn::NetworkDescription network =
      described({{"", "Loop", {"most", "", "x", "ten"}, {"y", "sums"}, {{"body", body}}}}, {"y", "sums"});
  network.constants = {{"most", whole(most)}, {"ten", real(10)}};
  return network;
}
}  // namespace

TEST_CASE("If runs the branch that its condition chooses, anew each time", "[nn][network][staged]") {
  Run run(sine_or_triple());
  const Numbers positive{1, 2, -0.5, 0.25}, negative{-1, -2, 0.5, 0.25};
  CHECK(run(positive) == Numbers{std::sin(1.0), std::sin(2.0), std::sin(-0.5), std::sin(0.25)});
  CHECK(run.gradient() == Numbers{std::cos(1.0), std::cos(2.0), std::cos(-0.5), std::cos(0.25)});
  CHECK(run(negative) == Numbers{-3, -6, 1.5, 0.75});
  CHECK(run.pass.made_count() == 1);
  CHECK(run.gradient() == Numbers{3, 3, 3, 3});
  CHECK(run(negative) == Numbers{-3, -6, 1.5, 0.75});
  CHECK(run.pass.made_count() == 0);
}

TEST_CASE("a condition that is known beforehand leaves one network of fixed extents",
          "[nn][network][staged]") {
  nn::NetworkDescription network = sine_or_triple();
  network.nodes.erase(network.nodes.begin(), network.nodes.begin() + 2);
  network.constants["is positive"] = truth(true);
  Run run(network);
  CHECK(run({1, 2, 3, 4})[0] == std::sin(1.0));
  CHECK(run.pass.stage_count() == 1);
  const nn::Network<double> fixed(network);
  CHECK(fixed.output_shape(0) == nn::Shape{4});
}

TEST_CASE("Loop takes as many rounds as its condition allows, and stacks what they scan",
          "[nn][network][staged]") {
  Run run(doubled(1e18));
  CHECK(run({1, 0, 0.5, 0.5}) == Numbers{8, 0, 4, 4});
  CHECK(run.gradient() == Numbers{8, 8, 8, 8});
  CHECK(run({1, 0, 0.5, 0.5}, 1) == Numbers{4, 8, 16});
  CHECK(run.pass.output_shape(1) == nn::Shape{3});
  CHECK(run({3, 3, 3, 3}) == Numbers{6, 6, 6, 6});
  Run counted(doubled(2));
  CHECK(counted({1, 0, 0.5, 0.5}, 1) == Numbers{4, 8});
}

TEST_CASE("a loop that does not end, and one without extents, are refused",
          "[nn][network][staged][repeated]") {
  Run endless(doubled(1e18));
  CHECK_THROWS_WITH(endless({-1, 0, 0, 0}), contains("a loop of more than 1000 rounds"));
  CHECK_THROWS_WITH(Run(doubled(0)), contains("a loop of no rounds has no extents to scan"));
}

TEST_CASE("long loops scan in order, and gradients run through every round", "[nn][network][staged]") {
  const auto body = graph({"i", "goes on", "v"},
                          {{"", "Add", {"v", "one"}, {"w"}, {}},
                           {"", "ReduceSum", {"w"}, {"sum"}, {{"keepdims", std::int64_t(0)}}}},
                          {"goes on", "w", "sum", "w"}, {}, {{"one", real(1)}});
  for (const double rounds : {1.0, 31.0, 32.0, 33.0, 70.0, 1000.0}) {
    CAPTURE(rounds);
    nn::NetworkDescription network = described(
        {{"", "Loop", {"rounds", "", "x"}, {"y", "sums", "all"}, {{"body", body}}}}, {"sums", "all", "y"});
    network.constants = {{"rounds", whole(rounds)}};
    Run run(network);
    const Numbers x{1, 0, 0.5, 0.25};
    Numbers sums, all;
    for (double round = 1; round <= rounds; ++round) {
      sums.push_back(1.75 + 4 * round);
      for (const double value : x) all.push_back(value + round);
    }
    CHECK(run(x) == sums);
    CHECK(run(x, 1) == all);
    CHECK(run.pass.output_shape(1) == nn::Shape{static_cast<std::size_t>(rounds), 4});
    CHECK(run(x, 2)[3] == 0.25 + rounds);
    CHECK(run.gradient() == Numbers(4, rounds));
    CHECK(run.pass.stage_count() == 1);
  }
}

TEST_CASE("constants within a loop's body are written once", "[nn][network][staged]") {
  const nn::Constant many{{100000}, nn::ElementType::floating, std::vector<float>(100000, 1.0F)};
  const auto body = graph({"i", "goes on", "v"},
                          {{"", "Mul", {"many", "v"}, {"w"}, {}},
                           {"", "ReduceMax", {"w"}, {"most"}, {{"keepdims", std::int64_t(0)}}}},
                          {"goes on", "most"}, {}, {{"many", many}});
  nn::NetworkDescription network =
      described({{"", "Loop", {"rounds", "", "x"}, {"y"}, {{"body", body}}}}, {"y"}, {1});
  network.constants = {{"rounds", whole(100)}};
  nn::ProgramBuilder<double> builder(network, {{"x", {1}}}, false);
  CHECK(builder.build().constants.size() < 110000);
}

TEST_CASE("values that are left over may be many or none", "[nn][network][staged]") {
  nn::NetworkDescription network = described({{"", "Greater", {"x", "half"}, {"is large"}, {}},
                                              {"", "NonZero", {"is large"}, {"places"}, {}},
                                              {"", "Squeeze", {"places", "first"}, {"place"}, {}},
                                              {"", "Mul", {"x", "x"}, {"squares"}, {}},
                                              {"", "Gather", {"squares", "place"}, {"left"}, {}}},
                                             {"left", "place"});
  network.constants = {{"half", real(0.5)}, {"first", {{1}, nn::ElementType::integer, Numbers{0}}}};
  Run run(network);
  CHECK(run({1, 0, 3, 0.25}) == Numbers{1, 9});
  CHECK(run.gradient() == Numbers{2, 0, 6, 0});
  CHECK(run({1, 0, 3, 0.25}, 1) == Numbers{0, 2});
  CHECK(run({0, 0, 0, 0}).empty());
  CHECK(run.pass.output_shape(0) == nn::Shape{0});
  CHECK(run.gradient() == Numbers{0, 0, 0, 0});
  CHECK(run({1, 1, 1, 2}) == Numbers{1, 1, 1, 4});
}

TEST_CASE("boxes that suppression leaves have gradients, and none left give nothing",
          "[nn][network][staged]") {
  nn::NetworkDescription network =
      described({{"", "Reshape", {"x", "as boxes"}, {"boxes"}, {}},
                 {"", "NonMaxSuppression", {"boxes", "scores", "most", "overlap", "least"}, {"rows"}, {}},
                 {"", "Gather", {"rows", "two"}, {"numbers"}, {{"axis", std::int64_t(1)}}},
                 {"", "Gather", {"boxes", "numbers"}, {"left"}, {{"axis", std::int64_t(1)}}}},
                {"left"}, {3, 4});
  const auto list = [](Numbers values) {
    const std::size_t count = values.size();
    return nn::Constant{{count}, nn::ElementType::integer, std::move(values)};
  };
  network.constants = {{"as boxes", list({1, 3, 4})},
                       {"scores", {{1, 1, 3}, nn::ElementType::floating, Numbers{0.9, 0.8, 0.7}}},
                       {"most", whole(9)},
                       {"overlap", real(0.5)},
                       {"least", real(0)},
                       {"two", list({2})}};
  Run run(network);
  const Numbers overlapping{0, 0, 4, 4, 0, 0, 4, 4.1, 5, 5, 6, 6};
  CHECK(run(overlapping) == Numbers{0, 0, 4, 4, 5, 5, 6, 6});
  CHECK(run.gradient() == Numbers{1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1});
  const Numbers apart{0, 0, 1, 1, 2, 2, 3, 3, 5, 5, 6, 6};
  CHECK(run(apart) == apart);
  network.constants["least"] = real(1);
  Run none(network);
  CHECK(none(apart).empty());
}

TEST_CASE("boxes that are given may be suppressed at once", "[nn][network][staged]") {
  nn::NetworkDescription network =
      described({{"", "NonMaxSuppression", {"x", "scores", "most"}, {"rows"}, {}}}, {"rows"}, {1, 3, 4});
  network.constants = {{"scores", {{1, 1, 3}, nn::ElementType::floating, Numbers{0.5, 0.9, 0.7}}},
                       {"most", whole(9)}};
  Run run(network);
  CHECK(run({0, 0, 4, 4, 5, 5, 6, 6, 0, 0, 4, 4}) == Numbers{0, 0, 1, 0, 0, 2});
}

TEST_CASE("an index out of range is refused by file and node", "[nn][network][staged]") {
  nn::NetworkDescription network = described({{"", "Cast", {"x"}, {"place"}, {{"to", std::int64_t(7)}}},
                                              {"pick", "Gather", {"x", "place"}, {"y"}, {}}},
                                             {"y"}, {1});
  Run run(network);
  CHECK_THROWS_WITH(run({-165}), "net.onnx: Gather \"pick\": index -165 of 1");
}

TEST_CASE("a setting that the network computes is a constant of the next stage", "[nn][network][staged]") {
  nn::NetworkDescription network =
      described({{"", "ReduceMax", {"x"}, {"most"}, {{"keepdims", std::int64_t(0)}}},
                 {"", "Cast", {"most"}, {"count"}, {{"to", std::int64_t(7)}}},
                 {"", "Unsqueeze", {"count", "first"}, {"k"}, {}},
                 {"", "TopK", {"x", "k"}, {"top", "places"}, {}}},
                {"top"});
  network.constants = {{"first", {{1}, nn::ElementType::integer, Numbers{0}}}};
  Run run(network);
  CHECK(run({1, 0.5, 2.5, 0.25}) == Numbers{2.5, 1});
  CHECK(run.gradient() == Numbers{1, 0, 1, 0});
  CHECK(run({1, 0.5, 3.5, 0.25}) == Numbers{3.5, 1, 0.5});
  CHECK_THROWS_WITH(run({1, 0.5, 9, 0.25}), contains("net.onnx: 1 node cannot be run: TopK"));
  CHECK(run({1, 0.5, 2.5, 0.25}) == Numbers{2.5, 1});  // after an error, too
}

TEST_CASE("graphs within nodes that do not fit are refused by the node", "[nn][network][staged]") {
  nn::NetworkDescription network = sine_or_triple();
  network.nodes[2].attributes["then_branch"] = graph({}, {{"", "Unheard", {"x"}, {"z"}, {}}}, {"z"}, {"x"});
  CHECK_THROWS_WITH(nn::StagedNetwork<double>(network),
                    "net.onnx: Unheard \"z\": the operator is not supported");
  for (const auto other : {nn::ElementType::integer, nn::ElementType::floating}) {
    nn::Subgraph typed{{}, {"z"}, {}, {{"", "Sin", {"x"}, {"z"}, {}}}, {"x"}, {other}};
    network.nodes[2].attributes["then_branch"] = std::make_shared<const nn::Subgraph>(typed);
    typed = {
        {}, {"z"}, {}, {{"", "Mul", {"x", "three"}, {"z"}, {}}}, {"x", "three"}, {nn::ElementType::floating}};
    network.nodes[2].attributes["else_branch"] = std::make_shared<const nn::Subgraph>(typed);
    Run run(network);
    if (other == nn::ElementType::floating)
      CHECK(run({-1, -1, -1, -1})[0] == -3);
    else
      CHECK_THROWS_WITH(run({-1, -1, -1, -1}), contains("If \"y\" (opset 18): result 0 is of another type"));
  }
  network.nodes[2].attributes["then_branch"] = graph({}, {}, {"x", "x"}, {"x"});
  Run two(network);
  CHECK_THROWS_WITH(two({1, 1, 1, 1}), contains("If \"y\" (opset 18): a branch has 2 results, expected 1"));
  network.nodes[2].attributes.erase("then_branch");
  CHECK_THROWS_WITH(Run(network)({1, 1, 1, 1}), contains("attribute 'then_branch' is missing"));
  network = sine_or_triple();
  network.nodes[2].inputs.insert(network.nodes[2].inputs.begin() + 1, "x");
  CHECK_THROWS_WITH(Run(network)({1, 1, 1, 1}), contains("the node has 5 inputs with those of its branches"));
  network = doubled(3);
  network.constants["most"] = {{0}, nn::ElementType::integer, Numbers{}};
  CHECK_THROWS_WITH(Run(network)({1, 1, 1, 1}), contains("the number of rounds has 0 elements, expected 1"));
  network = doubled(3);
  network.nodes[0].attributes["tapestry.round"] = std::int64_t(-1);
  CHECK_THROWS_WITH(Run(network)({1, 1, 1, 1}), contains("round -1 of a loop"));
  network = doubled(3);
  network.nodes[0].inputs.pop_back();
  CHECK_THROWS_WITH(Run(network)({1, 1, 1, 1}), contains("the body takes 1 values"));
}

TEST_CASE("one network of fixed extents refuses what depends on the picture", "[nn][network][staged]") {
  CHECK_THROWS_WITH(nn::Network<double>(sine_or_triple()),
                    contains("input 0 is computed; only a constant one is supported"));
}
