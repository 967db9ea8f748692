// Networks whose extents depend on values, forward and backward, where loops, branches and indices live.
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/nn/network/staged_network.hpp>

#include "../support/looping_models.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;

/// Small enough for the limits of tests/fuzz.sh, whatever a file demands.
nn::PlanBudget small_budget() {
  nn::PlanBudget budget;
  budget.nodes = budget.planned = 2048;
  budget.stages = 32;
  budget.bytes = budget.values = std::size_t(1) << 22U;
  budget.reads = std::size_t(1) << 24U;
  budget.folded = std::size_t(1) << 16U;
  return budget;
}

void run(const std::string& bytes) {
  const nn::StagedNetwork<float> network(io::parse_onnx(bytes, fuzz::folder().path("a.onnx")), {},
                                         small_budget());
  std::vector<nn::Buffer<float>> inputs, slopes, ones;
  std::vector<const float*> values, adjoints;
  std::vector<float*> goals;
  for (std::size_t i = 0; i < network.input_count(); ++i) {
    const std::size_t count = nn::size_of(network.input_shape(i));
    if (count > 1024) return;  // 4,096 results are allowed for each
    inputs.emplace_back(count).fill_zero();
    std::fill_n(inputs.back().data(), count, 0.5F);
    slopes.emplace_back(count).fill_zero();
    values.push_back(inputs.back().data());
    goals.push_back(slopes.back().data());
  }
  nn::StagedPass<float> pass;
  network.forward(values, pass, nn::Mode::input_gradient);
  for (std::size_t i = 0; i < pass.output_count(); ++i) {
    ones.emplace_back(nn::size_of(pass.output_shape(i)));
    std::fill_n(ones.back().data(), ones.back().size(), 1.0F);
  }
  for (const auto& one : ones) adjoints.push_back(one.data());
  network.adjoint(pass, adjoints, goals);
}

/// Boxes of x, [3, 4], that suppression leaves, their features, and a branch by their sum.
std::string boxes_model() {
  using namespace test::onnx;
  const auto branch = [](const char* operation) {
    ModelParts parts;
    parts.nodes = {node(operation, {"features"}, {"z"})};
    parts.outputs = {value("z", float32, {})};
    return graph(parts);
  };
  ModelParts parts;
  parts.opsets = {{"", 18}};
  parts.inputs = {value("x", float32, {Extent(3), Extent(4)})};
  parts.outputs = {value("y", float32, {}), value("places", int64, {})};
  parts.initialisers = {int64_tensor("first", {1}, {0}),
                        int64_tensor("most", {1}, {2}),
                        int64_tensor("column", {}, {2}),
                        int64_tensor("images", {1}, {0}),
                        float_tensor("corners", {1, 3, 4}, {0, 0, 2, 2, 0, 0, 2, 1, 1, 1, 3, 3}),
                        float_tensor("scores", {1, 1, 3}, {0.5F, 0.25F, 0.75F}),
                        float_tensor("maps", {1, 1, 2, 3}, {1, 2, 3, 4, 5, 6})};
  parts.nodes = {
      node("Unsqueeze", {"x", "first"}, {"moved"}),
      node("Add", {"moved", "corners"}, {"boxes"}),
      node("NonMaxSuppression", {"boxes", "scores", "most"}, {"rows"}),
      node("Gather", {"rows", "column"}, {"left"}, {int_attribute("axis", 1)}),
      node("Gather", {"boxes", "left"}, {"some"}, {int_attribute("axis", 1)}),
      node("Squeeze", {"some", "first"}, {"kept"}),
      node("Gather", {"rows", "first"}, {"pictures"}, {int_attribute("axis", 1)}),
      node("Squeeze", {"pictures"}, {"picture"}),
      node("RoiAlign", {"maps", "kept", "picture"}, {"features"}),
      node("ReduceSum", {"features"}, {"sum"}, {int_attribute("keepdims", 0)}),
      node("Cast", {"sum"}, {"is positive"}, {int_attribute("to", boolean)}),
      node("If", {"is positive"}, {"y"},
           {graph_attribute("then_branch", branch("Sin")), graph_attribute("else_branch", branch("Neg"))}),
      node("NonZero", {"is positive"}, {"places"})};
  return model(parts);
}

const fuzz::Registered staged(
    {"onnx_staged", run, [] {
       using namespace test::onnx;
       return std::vector{boxes_model(), nested_loops(2, 3), doubling_loop_by_value(3), scanning_loop(3, 2)};
     }});
}  // namespace
