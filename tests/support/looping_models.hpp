#pragma once
#include "onnx_builder.hpp"

/// Models of a few hundred bytes whose loops grow.
namespace tapestry::test::onnx {
/// The body of a loop: its nodes, with "i", "go" and "v" as inputs, and as outputs the new
/// v, then the scanned values.
inline std::string loop_body(const std::vector<std::string>& nodes, const std::vector<std::string>& results,
                             const std::string& goes_on = "go") {
  ModelParts parts;
  parts.nodes = nodes;
  parts.inputs = {value("i", int64, {}), value("go", boolean, {}), value("v", float32, {Extent()})};
  parts.outputs = {value(goes_on, boolean, {})};
  for (const std::string& result : results) parts.outputs.push_back(value(result, float32, {Extent()}));
  return graph(parts);
}

/// A model of one loop, of `rounds` or until its body ends it, from x of so many values.
inline std::string looping_model(const std::string& body, std::int64_t rounds, std::int64_t extent,
                                 const std::vector<std::string>& outputs = {"y"}) {
  ModelParts parts;
  parts.opsets = {{"", 18}};
  parts.inputs = {value("x", float32, {Extent(extent)})};
  for (const std::string& output : outputs) parts.outputs.push_back(value(output, float32, {}));
  parts.initialisers = {int64_tensor("rounds", {}, {rounds}), float_tensor("one", {}, {1}),
                        float_tensor("much", {}, {1e30F})};
  parts.nodes = {node("Loop", {"rounds", "", "x"}, outputs, {graph_attribute("body", body)})};
  return model(parts);
}

/// Loops of `rounds` within each other, the innermost adding 1.
inline std::string nested_loops(std::size_t depth, std::int64_t rounds) {
  std::string body = loop_body({node("Add", {"v", "one"}, {"w"})}, {"w"});
  for (std::size_t level = 1; level < depth; ++level)
    body = loop_body({node("Loop", {"rounds", "", "v"}, {"w"}, {graph_attribute("body", body)})}, {"w"});
  return looping_model(body, rounds, 4);
}

/// A loop that appends v to itself in each round.
inline std::string doubling_loop(std::int64_t rounds, std::int64_t extent = 4) {
  return looping_model(loop_body({node("Concat", {"v", "v"}, {"w"}, {int_attribute("axis", 0)})}, {"w"}),
                       rounds, extent);
}

/// The same, whose end depends on values.
inline std::string doubling_loop_by_value(std::int64_t rounds, std::int64_t extent = 4) {
  return looping_model(loop_body({node("Concat", {"v", "v"}, {"w"}, {int_attribute("axis", 0)}),
                                  node("ReduceSum", {"w"}, {"sum"}, {int_attribute("keepdims", 0)}),
                                  node("Less", {"sum", "much"}, {"goes on"})},
                                 {"w"}, "goes on"),
                       rounds, extent);
}

/// A loop that adds 1 to v and scans it.
inline std::string scanning_loop(std::int64_t rounds, std::int64_t extent) {
  return looping_model(loop_body({node("Add", {"v", "one"}, {"w"})}, {"w", "w"}), rounds, extent,
                       {"y", "scanned"});
}
}  // namespace tapestry::test::onnx
