#include <tapestry/nn/network/network.hpp>

#include "../../support/catch.hpp"

namespace nn = tapestry::nn;
using tapestry::test::contains;

namespace {
constexpr double odd = 16777217;  // 2^24 + 1, the first integer that float does not have

nn::Constant whole(std::vector<double> values) {
  return {{values.size()}, nn::ElementType::integer, std::move(values)};
}

/// Value "y" that a network of constants alone computes beforehand.
template <class T>
std::vector<T> computed(std::vector<nn::Node> nodes, std::map<std::string, nn::Constant> constants) {
  nn::NetworkDescription description;
  description.opset = 13;
  description.inputs = {{"x", {1}}};
  description.outputs = {"y"};
  description.constants = std::move(constants);
  description.nodes = std::move(nodes);
  const nn::Network<T> network(description);
  nn::Buffer<T> x(1);
  nn::NetworkPass<T> pass;
  network.forward({x.data()}, pass);
  return {pass.output(0), pass.output(0) + nn::size_of(network.output_shape(0))};
}
}  // namespace

TEMPLATE_TEST_CASE("integers beyond 2^24 that extents are computed from are exact in float, too",
                   "[nn][network]", float, double) {
  const std::map<std::string, nn::Constant> constants{
      {"a", whole({3, odd, 4097})}, {"b", whole({odd - 1})}, {"one", whole({1})}, {"two", whole({2})}};
  const auto with = [](std::vector<nn::Node> nodes, const std::string& made) {
    nodes.push_back({"", "Sub", {made, "b"}, {"y"}, {}});  // small again
    return nodes;
  };
  const nn::Node pick{"", "Gather", {"a", "one"}, {"odd"}, {}};
  CHECK(computed<TestType>(with({pick}, "odd"), constants) == std::vector<TestType>{1});
  CHECK(computed<TestType>(with({{"", "Concat", {"two", "a"}, {"all"}, {{"axis", std::int64_t(0)}}},
                                 {"", "Gather", {"all", "two"}, {"odd"}, {}}},
                                "odd"),
                           constants) == std::vector<TestType>{1});
  CHECK(computed<TestType>(with({pick,
                                 {"", "Mul", {"odd", "two"}, {"even"}, {}},
                                 {"", "Div", {"even", "two"}, {"odd again"}, {}}},
                                "odd again"),
                           constants) == std::vector<TestType>{1});
  CHECK(computed<TestType>({{"", "Mod", {"a", "two"}, {"y"}, {}}}, constants) ==
        std::vector<TestType>{1, 1, 1});
  CHECK(computed<TestType>({pick, {"", "Greater", {"odd", "b"}, {"y"}, {}}}, constants) ==
        std::vector<TestType>{1});
  CHECK(computed<TestType>(with({{"", "ReduceMax", {"a"}, {"odd"}, {}}}, "odd"), constants) ==
        std::vector<TestType>{1});
  CHECK(computed<TestType>(with({pick, {"", "Where", {"one", "odd", "two"}, {"chosen"}, {}}}, "chosen"),
                           constants) == std::vector<TestType>{1});
}

TEMPLATE_TEST_CASE("a product of extents beyond 2^24 is exact", "[nn][network]", float, double) {
  // 4097² = 16785409, which float rounds to 16785408.
  CHECK(computed<TestType>({{"", "ReduceProd", {"sides"}, {"area"}, {{"keepdims", std::int64_t(1)}}},
                            {"", "Sub", {"area", "close"}, {"y"}, {}}},
                           {{"sides", whole({4097, 4097})}, {"close", whole({16785408})}}) ==
        std::vector<TestType>{1});
}

TEST_CASE("integers that float cannot compute beforehand are refused", "[nn][network]") {
  const std::vector<nn::Node> nodes{{"", "CumSum", {"a", "axis"}, {"y"}, {}}};
  nn::Constant axis{{}, nn::ElementType::integer, std::vector<double>{0}};
  const std::map<std::string, nn::Constant> constants{{"a", whole({odd, 2})}, {"axis", axis}};
  CHECK(computed<double>(nodes, constants) == std::vector<double>{odd, odd + 2});
  CHECK_THROWS_WITH(computed<float>(nodes, constants),
                    contains("a constant integer beyond 2^24, which CumSum computes in float"));
}

TEST_CASE("arithmetic of constants is rounded to float once", "[nn][network]") {
  const auto number = [](double value) {
    return nn::Constant{{1}, nn::ElementType::floating, std::vector<double>{value}};
  };
  const auto result = computed<float>({{"", "Div", {"one", "three"}, {"third"}, {}},
                                       {"", "Add", {"third", "large"}, {"sum"}, {}},
                                       {"", "Sub", {"sum", "large"}, {"y"}, {}}},
                                      {{"one", number(1)}, {"three", number(3)}, {"large", number(4096)}});
  CHECK(std::abs(static_cast<double>(result[0]) - 1.0 / 3) < 1e-7);  // float's spacing at 4096 is 5e-4
}
