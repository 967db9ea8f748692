#include <tapestry/nn/detail/network/decomposition.hpp>

#include "../../support/vocabulary_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

TEST_CASE("The input gradient of every operator is right whichever of its operands are computed",
          "[nn][network][gradient][repeated]") {
  for (const VocabularyCase& given : vocabulary_cases())
    for (const std::uint64_t computed : computed_sets(given)) {
      CAPTURE(given.operation, given.operands.front().shape, given.opset, computed);
      for (const auto& [name, value] : given.attributes) UNSCOPED_INFO(name);
      const Behind network(given, computed);
      OperatorRun run(network.description);
      for (std::size_t i = 0; i < run.inputs.size(); ++i)
        std::copy(network.values[i].begin(), network.values[i].end(), run.inputs[i].data());
      const bool is_top = given.operation == "TopK";  // its second result is positions
      CHECK(adjoint_error(run, is_top ? 1 : given.output_count) <= 1);
    }
}

TEST_CASE("Every operator of the vocabulary has a case or no derivative", "[nn][network]") {
  std::set<std::string> covered = operators_without_derivative();
  for (const VocabularyCase& given : vocabulary_cases()) covered.insert(given.operation);
  std::set<std::string> all;
  for (const auto& entry : nn::operators<double>()) all.insert(entry.first);
  for (const auto& entry : nn::decompositions()) all.insert(entry.first);
  CHECK(covered == all);
}
