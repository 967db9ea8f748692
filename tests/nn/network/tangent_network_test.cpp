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
