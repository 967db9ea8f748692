#include "../../support/tangent_check.hpp"
#include "../../support/vocabulary_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
std::vector<double> joined(const std::vector<std::vector<double>>& parts) {
  std::vector<double> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// Operators with forms whose second order is not known: boxes and grids that move, values that compete for a
/// place, exponents that vary, norms of windows, and third order.
const std::set<std::string> unknown{
    "DeformConv", "FusedConv", "GlobalLpPool", "GridSample",      "LpPool",  "Mod",
    "Pow",        "RoiAlign",  "ScatterND",    "ScatterElements", "Tangent", "TangentPool"};
}  // namespace

TEST_CASE("The second order of every operator is that of central differences, whichever operands vary",
          "[nn][network][gradient][repeated]") {
  std::set<std::string> refused;
  for (const bool simplifies : {true, false})
    for (const VocabularyCase& given : vocabulary_cases())
      for (const std::uint64_t computed : computed_sets(given)) {
        CAPTURE(simplifies, given.operation, given.operands.front().shape, given.opset, computed);
        for (const auto& [name, value] : given.attributes) UNSCOPED_INFO(name);
        const Behind network(given, computed);
        const nn::Network<double> plain(network.description, {}, false, simplifies);
        try {
          const TangentCheck check(plain, joined(network.values));
          const bool is_top = given.operation == "TopK";  // its second result is positions
          const auto errors = check.errors(is_top ? 1 : plain.output_count());
          CAPTURE(errors.value, errors.tangent, errors.gradient, errors.second);
          CHECK(errors.largest() <= 1e-7);
        } catch (const tapestry::DomainError& error) {
          CHECK(std::string(error.what()).starts_with("second order of "));
          refused.insert(given.operation);
        }
      }
  CHECK(refused == unknown);
}

namespace {
/// Two convolutions, the first with this activation, and a product, with outputs that do not depend on x.
nn::NetworkDescription small_network(const std::string& activation) {
  nn::NetworkDescription network;
  network.path = "net.onnx";
  network.opset = 13;
  network.inputs = {{"x", {1, 2, 5, 4}}, {"places", {2}, nn::ElementType::integer}};
  network.outputs = {"y", "v", "kept", "numbers"};
  const auto constant = [&](const char* name, const nn::Shape& shape, std::uint64_t seed) {
    network.constants[name] = numbers(shape, random_values(nn::size_of(shape), seed));
  };
  constant("w", {3, 2, 3, 3}, 1);
  constant("b", {3}, 2);
  constant("v", {2, 3, 1, 1}, 3);
  constant("m", {6, 4}, 4);
  network.constants["extents"] = integers({2, 6});
  network.nodes = {{"", "Conv", {"x", "w", "b"}, {"z"}, {}},
                   {"", activation, {"z"}, {"a"}, {}},
                   {"", "Conv", {"a", "v"}, {"c"}, {}},
                   {"", "Reshape", {"c", "extents"}, {"r"}, {}},
                   {"", "Transpose", {"m"}, {"t"}, {}},
                   {"", "Gemm", {"r", "t"}, {"y"}, {{"transB", std::int64_t(1)}}},
                   {"", "Identity", {"places"}, {"kept"}, {}},
                   {"", "Cast", {"places"}, {"numbers"}, {{"to", std::int64_t(1)}}}};
  return network;
}

/// The small network at x + step · u and weights + step · v: gradients by x and by the weights, then y.
struct Moved {
  std::vector<double> weights, v, x = random_values(40, 23), u = random_values(40, 24),
                                  seeds = random_values(8, 25);
  std::vector<double> places{3, 4};
  std::vector<double> operator()(nn::Network<double>& network, double step) const {
    std::vector<double> moved = x, at = weights, found(x.size() + weights.size());
    for (std::size_t i = 0; i < x.size(); ++i) moved[i] += step * u[i];
    for (std::size_t i = 0; i < at.size(); ++i) at[i] += step * v[i];
    moved.resize(x.size() + 32);
    network.set_weights(at);
    nn::NetworkPass<double> pass;
    network.forward({moved.data(), places.data()}, pass, nn::Mode::training);
    network.adjoint(pass, {seeds.data(), nullptr, nullptr, nullptr}, {found.data(), nullptr},
                    found.data() + x.size());
    found.insert(found.end(), pass.output(0), pass.output(0) + seeds.size());
    return found;
  }
};
}  // namespace

TEST_CASE("Weights have tangents, and a network with tangents takes over what set_weights() gave",
          "[nn][network][gradient]") {
  const auto activation = GENERATE(std::string("LeakyRelu"), std::string("Sigmoid"));
  CAPTURE(activation);
  nn::Network<double> plain(small_network(activation));
  const std::size_t count = plain.weights().size();
  const Moved moved{random_values(count, 21), random_values(count, 22)};
  plain.set_weights(moved.weights);
  auto both = plain.with_tangents(true);
  REQUIRE(both.input_count() == 3);  // integers have no tangent
  REQUIRE(both.output_count() == 8);
  REQUIRE(both.weights().size() == 2 * count);
  std::vector<double> all(both.weights().begin(), both.weights().end());
  std::vector<std::size_t> places(count, all.size());  // of plain's weights
  for (const nn::WeightBlock& block : plain.weight_blocks())
    for (const nn::WeightBlock& other : both.weight_blocks())
      for (std::size_t i = 0; i < nn::size_of(block.shape); ++i) {
        if (other.name == block.name) places[block.offset + i] = other.offset + i;
        if (other.name == block.name + "#0") all[other.offset + i] = moved.v[block.offset + i];
      }
  for (std::size_t i = 0; i < count; ++i) REQUIRE(all.at(places[i]) == moved.weights[i]);
  both.set_weights(all);
  const double h = 6e-6;
  const auto up = moved(plain, h), down = moved(plain, -h);
  const auto slope = [&](std::size_t i) { return Approx((up[i] - down[i]) / (2 * h)).margin(1e-7); };
  std::vector<double> x = moved.x, u = moved.u, of_x(40), of_u(40), of_weights(all.size());
  x.resize(72);
  u.resize(72);
  nn::NetworkPass<double> pass;
  both.forward({x.data(), moved.places.data(), u.data()}, pass, nn::Mode::training);
  std::vector<const double*> adjoints(8, nullptr);
  adjoints[4] = moved.seeds.data();
  both.adjoint(pass, adjoints, {of_x.data(), nullptr, of_u.data()}, of_weights.data());
  for (std::size_t i = 0; i < 40; ++i) CHECK(of_x[i] == slope(i));
  for (std::size_t i = 0; i < count; ++i) CHECK(of_weights[places[i]] == slope(40 + i));
  for (std::size_t i = 0; i < 8; ++i) CHECK(pass.output(4)[i] == slope(40 + count + i));
  for (std::size_t i = 0; i < 2; ++i) CHECK(pass.output(6)[i] == 0);  // of integers
  for (std::size_t i = 0; i < 2; ++i) CHECK(pass.output(7)[i] == 0);  // of what depends on no numbers
}
