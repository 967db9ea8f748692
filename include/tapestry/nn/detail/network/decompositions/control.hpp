#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// Names of the values that a subgraph captures; they begin at `first` among the node's inputs.
[[nodiscard]] inline std::map<std::string, std::string> captured_names(const Subgraph& graph,
                                                                       const Node& node, std::size_t first) {
  std::map<std::string, std::string> names;
  for (std::size_t i = 0; i < graph.captured.size(); ++i)
    names[graph.captured[i]] = node.inputs.at(first + i);
  return names;
}

[[nodiscard]] inline bool truth_of(const OperatorContext& context, std::size_t i) {
  const Constant& constant = context.constant(i);
  if (constant.size() != 1) throw ShapeError({"input ", i, " is ", constant.shape, ", expected one truth"});
  return constant.at(0) != 0;
}

/// If becomes the branch that its condition chooses. Source: onnx.ai, Operators.md.
inline void decompose_if(OperatorContext& context, Decomposer& parts) {
  const auto &otherwise = context.graph("else_branch"), &then = context.graph("then_branch");
  const bool holds = truth_of(context, 0);
  const Node& node = parts.node();
  if (node.inputs.size() != 1 + otherwise->captured.size() + then->captured.size())
    throw DomainError({"the node has ", node.inputs.size(), " inputs with those of its branches"});
  const auto &types = then->output_types, &other_types = otherwise->output_types;
  for (std::size_t i = 0; i < std::min(types.size(), other_types.size()); ++i)
    if (types[i] != other_types[i])
      throw DomainError({"result ", i, " is of another type in the other branch"});
  const Subgraph& branch = holds ? *then : *otherwise;
  // Attributes are in the order of their names: values captured by "else_branch" come first.
  const std::size_t first = 1 + (holds ? otherwise->captured.size() : 0);
  const auto results = parts.inlined(branch, captured_names(branch, node, first));
  if (results.size() != node.outputs.size())
    throw ShapeError({"a branch has ", results.size(), " results, expected ", node.outputs.size()});
  for (std::size_t i = 0; i < results.size(); ++i) parts.finish(i, "Identity", {results[i]});
}

/// Loop becomes its first round and a Loop of the others. Scanned results of finished rounds follow the other
/// carried values, in pieces of 32 rounds: long loops then neither copy all results at every round nor carry
/// a name for each. Source: onnx.ai, Operators.md.
class LoopParts {
 public:
  LoopParts(OperatorContext& context, Decomposer& parts)
      : context_(context), parts_(parts), node_(parts.node()), body_(context.graph("body")) {
    round_ = context.integer(round_name, 0);
    if (round_ < 0 || round_ > most_rounds) throw DomainError({"round ", round_, " of a loop"});
    if (body_->inputs.size() < 2 || body_->outputs.empty()) throw ShapeError("the body has too few values");
    carried_ = body_->inputs.size() - 2;
    if (body_->outputs.size() < 1 + carried_) throw ShapeError("the body has too few results");
    scanned_ = body_->outputs.size() - 1 - carried_;
    if (node_.outputs.size() > carried_ + scanned_) throw ShapeError("the body has too few results");
    captures_at_ = 2 + carried_ + scanned_ * piece_count();
    if (node_.inputs.size() != captures_at_ + body_->captured.size())
      throw ShapeError({"the body takes ", carried_, " values, and the node has ", node_.inputs.size()});
  }

  void write() {
    const bool is_counted = context_.has_input(0);
    if (is_counted && context_.constant(count_input).size() != 1)
      throw ShapeError(
          {"the number of rounds has ", context_.constant(count_input).size(), " elements, expected 1"});
    const std::int64_t left = is_counted ? context_.integers(count_input)[0] : most_rounds + 1;
    const bool goes_on = !context_.has_input(1) || truth_of(context_, 1);
    if (left <= 0 || !goes_on) return end();
    if (round_ == most_rounds) throw DomainError({"a loop of more than ", most_rounds, " rounds"});
    auto names = captured_names(*body_, node_, captures_at_);
    names[body_->inputs[0]] = parts_.constant(number(static_cast<double>(round_)));
    names[body_->inputs[1]] = parts_.constant({{}, ElementType::boolean, std::vector<double>{1}});
    for (std::size_t i = 0; i < carried_; ++i) names[body_->inputs[2 + i]] = node_.inputs[2 + i];
    auto results = parts_.inlined(*body_, std::move(names));
    Decomposer::Names rest{is_counted ? parts_.constant(number(static_cast<double>(left - 1))) : "",
                           results[0]};
    for (std::size_t i = 0; i < carried_; ++i) rest.push_back(results[1 + i]);
    for (std::size_t i = 0; i < scanned_; ++i) {
      const Decomposer::Names pieces = with_scanned(i, results[1 + carried_ + i]);
      rest.insert(rest.end(), pieces.begin(), pieces.end());
    }
    for (std::size_t i = captures_at_; i < node_.inputs.size(); ++i) rest.push_back(node_.inputs[i]);
    parts_.finish_all("Loop", std::move(rest), {{"body", body_}, {round_name, round_ + 1}});
  }

 private:
  static constexpr std::int64_t most_rounds = 1000, rounds_a_piece = 32;
  static constexpr std::size_t count_input = 0;
  static constexpr const char* round_name = "tapestry.round";

  [[nodiscard]] static Constant number(double value) {
    return {{}, ElementType::integer, std::vector<double>{value}};
  }

  /// Pieces of each scanned value before this round.
  [[nodiscard]] std::size_t piece_count() const {
    return static_cast<std::size_t>(round_ / rounds_a_piece + round_ % rounds_a_piece);
  }
  [[nodiscard]] Decomposer::Names pieces_of(std::size_t i) const {
    const auto first = node_.inputs.begin() + static_cast<std::ptrdiff_t>(2 + carried_ + i * piece_count());
    return {first, first + static_cast<std::ptrdiff_t>(piece_count())};
  }

  /// Appends one round to earlier scanned results, along a new first axis.
  [[nodiscard]] Decomposer::Names with_scanned(std::size_t i, const std::string& value) {
    Decomposer::Names pieces = pieces_of(i);
    pieces.push_back(parts_.raised(value));
    if ((round_ + 1) % rounds_a_piece != 0) return pieces;
    const Decomposer::Names last(pieces.end() - rounds_a_piece, pieces.end());
    pieces.resize(pieces.size() - rounds_a_piece);
    pieces.push_back(parts_.add("Concat", last, {{"axis", std::int64_t{0}}}));
    return pieces;
  }

  void end() {
    for (std::size_t i = 0; i < node_.outputs.size(); ++i) {
      if (node_.outputs[i].empty()) continue;
      if (i >= carried_ && round_ == 0) throw DomainError("a loop of no rounds has no extents to scan");
      if (i < carried_)
        parts_.finish(i, "Identity", {node_.inputs[2 + i]});
      else
        parts_.finish(i, "Concat", pieces_of(i - carried_), {{"axis", std::int64_t{0}}});
    }
  }

  OperatorContext& context_;
  Decomposer& parts_;
  const Node& node_;
  std::shared_ptr<const Subgraph> body_;
  std::int64_t round_ = 0;
  std::size_t carried_ = 0, scanned_ = 0, captures_at_ = 0;
};

inline void decompose_loop(OperatorContext& context, Decomposer& parts) { LoopParts(context, parts).write(); }
}  // namespace tapestry::nn::detail
