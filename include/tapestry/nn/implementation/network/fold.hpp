#pragma once
#include <tapestry/nn/detail/network/broadcast.hpp>
#include <tapestry/nn/detail/network/layout_conversion.hpp>
#include <tapestry/nn/detail/network/operators/binary_functions.hpp>
#include <tapestry/nn/detail/network/operators/piecewise_functions.hpp>
#include <tapestry/nn/network/program_builder.hpp>

namespace tapestry::nn::detail {
/// Extents first … end − 1 of an operand, which may count from the end.
[[nodiscard]] inline Constant shape_constant(const Node& node, std::int64_t opset, const Shape& shape) {
  OperatorContext context(node, opset, {}, false);
  const auto rank = static_cast<std::int64_t>(shape.size());
  const auto place = [&](std::int64_t axis) {
    return std::clamp<std::int64_t>(axis < 0 ? axis + rank : axis, 0, rank);
  };
  const std::int64_t first = place(context.integer("start", 0)), end = place(context.integer("end", rank));
  context.require_all_asked();
  std::vector<double> extents;
  for (std::int64_t i = first; i < end; ++i)
    extents.push_back(static_cast<double>(shape[static_cast<std::size_t>(i)]));
  const std::size_t count = extents.size();
  return integers(std::move(extents), {count});
}

template <std::floating_point T>
bool is_channels_last(const Operator<T>& kind, const std::vector<FoldOperand>& operands) {
  if (kind.layout != LayoutRule::channels_last) return false;
  bool has_four = false, fits = true;
  for (std::size_t i = 0; i < std::min(kind.data_inputs, operands.size()); ++i) {
    has_four = has_four || (operands[i].is_there && operands[i].shape.size() == 4);
    fits = fits && (!operands[i].is_there || operands[i].shape.size() == 4);
  }
  return has_four && fits;
}

/// A function of elements that is computed in double, whatever the network's scalar: of one, or from left to
/// right of several. Both null: none.
struct ElementFunction {
  double (*one)(double, double, double) = nullptr;
  double (*two)(double, double) = nullptr;
  bool reduces = false;  ///< all elements of one operand, instead of one of each
};

/// The greater number, or NaN if one is NaN; then the lesser.
[[nodiscard]] inline double greater_of(double a, double b) { return a > b || a != a ? a : b; }
[[nodiscard]] inline double lesser_of(double a, double b) { return a < b || a != a ? a : b; }

/// Functions of operators that compute one for any operands.
[[nodiscard]] inline const std::map<std::string, ElementFunction, std::less<>>& element_functions() {
  static const std::map<std::string, ElementFunction, std::less<>> functions{
      {"Abs", {&unary::Abs<double>::value}},
      {"Neg", {&unary::Neg<double>::value}},
      {"Floor", {&unary::Floor<double>::value}},
      {"Ceil", {&unary::Ceil<double>::value}},
      {"Round", {&unary::Round<double>::value}},
      {"Sign", {&unary::Sign<double>::value}},
      {"Sqrt", {&unary::OfTape<double, tapestry::detail::Sqrt>::value}},
      {"Reciprocal", {&unary::Reciprocal<double>::value}},
      {"Not", {&unary::Not<double>::value}},
      {"Add", {nullptr, &binary::Add<double>::value}},
      {"Sub", {nullptr, &binary::Sub<double>::value}},
      {"Mul", {nullptr, &binary::Mul<double>::value}},
      {"Equal", {nullptr, &binary::Test<double, std::equal_to>::value}},
      {"Greater", {nullptr, &binary::Test<double, std::greater>::value}},
      {"GreaterOrEqual", {nullptr, &binary::Test<double, std::greater_equal>::value}},
      {"Less", {nullptr, &binary::Test<double, std::less>::value}},
      {"LessOrEqual", {nullptr, &binary::Test<double, std::less_equal>::value}},
      {"And", {nullptr, &binary::Test<double, std::logical_and>::value}},
      {"Or", {nullptr, &binary::Test<double, std::logical_or>::value}},
      {"Xor", {nullptr, &binary::Xor<double>::value}},
      {"Max", {nullptr, &greater_of}},
      {"Min", {nullptr, &lesser_of}},
      {"Sum", {nullptr, &binary::Add<double>::value}},
      {"ReduceSum", {nullptr, &binary::Add<double>::value, true}},
      {"ReduceProd", {nullptr, &binary::Mul<double>::value, true}},
      {"ReduceMax", {nullptr, &greater_of, true}},
      {"ReduceMin", {nullptr, &lesser_of, true}},
  };
  return functions;
}

/// \param from  type of the first operand
/// \param to    type of the result
[[nodiscard]] inline ElementFunction element_function(const Node& node, ElementType from, ElementType to) {
  const bool is_integer = from == ElementType::integer;
  if (node.operation == "Div")
    return {nullptr, is_integer ? &binary::IntegerDiv<double>::value : &binary::Div<double>::value};
  if (node.operation == "Pow")
    return {nullptr, is_integer ? &binary::IntegerPow<double>::value : &binary::Pow<double>::value};
  if (node.operation == "Mod") {
    const auto found = node.attributes.find("fmod");
    const auto* const is_set =
        found == node.attributes.end() ? nullptr : std::get_if<std::int64_t>(&found->second);
    const bool has_sign_of_first = is_set != nullptr && *is_set != 0;
    return {nullptr, has_sign_of_first ? &binary::Fmod<double>::value : &binary::IntegerMod<double>::value};
  }
  if (node.operation == "Cast" || node.operation == "CastLike") {
    if (to == ElementType::boolean && from != to) return {&unary::IsTrue<double>::value};
    if (to == ElementType::integer && from == ElementType::floating) return {&unary::Truncate<double>::value};
  }
  const auto found = element_functions().find(node.operation);
  return found == element_functions().end() ? ElementFunction{} : found->second;
}

/// Elements of a result of `shape`, with the operands repeated to it.
[[nodiscard]] inline std::vector<double> combined(const ElementFunction& function,
                                                  const std::vector<Constant>& operands, const Shape& shape) {
  std::vector<double> result(size_of(shape));
  for (const Constant& operand : operands) {
    const bool is_first = &operand == &operands.front();
    const auto nest = broadcast_nest<1>(shape, {&operand.shape});
    const std::ptrdiff_t step = nest.loops.back().strides[1];
    for_each_run(nest, [&](const auto& at, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        double& to = result[static_cast<std::size_t>(at[0]) + i];
        const double x = operand.at(static_cast<std::size_t>(at[1] + static_cast<std::ptrdiff_t>(i) * step));
        to = is_first ? x : function.two(to, x);
      }
    });
    if (function.one == nullptr) continue;
    for (double& value : result) value = function.one(value, 0, 0);
    break;
  }
  return result;
}

/// The elements of an operand, as one.
[[nodiscard]] inline std::vector<double> reduced(const ElementFunction& function, const Constant& operand) {
  double result = operand.at(0);
  for (std::size_t i = 1; i < operand.size(); ++i) result = function.two(result, operand.at(i));
  return {result};
}

/// Operands, a bit each, whose elements an operator moves unchanged to its results.
[[nodiscard]] inline std::uint64_t moved_operands(const Node& node) {
  constexpr std::uint64_t all = ~std::uint64_t(0);
  static const std::map<std::string_view, std::uint64_t> moved{
      {"Identity", 1}, {"Cast", 1},    {"CastLike", 1},  {"Reshape", 1}, {"Flatten", 1},
      {"Squeeze", 1},  {"Slice", 1},   {"Unsqueeze", 1}, {"Split", 1},   {"Transpose", 1},
      {"Expand", 1},   {"Tile", 1},    {"Concat", all},  {"Gather", 1},  {"GatherElements", 1},
      {"GatherND", 1}, {"Scatter", 5}, {"ScatterND", 5}, {"Where", 6},   {"ScatterElements", 5},
  };
  const auto found = moved.find(node.operation);
  return found == moved.end() || node.attributes.contains("reduction") ? 0 : found->second;
}

/// The results of an operation.
template <std::floating_point T>
[[nodiscard]] std::vector<std::vector<double>> run_once(Operation<T>& operation,
                                                        const std::vector<Constant>& operands,
                                                        const std::vector<FoldOperand>& given) {
  std::vector<Buffer<T>> values(operands.size()), results;
  std::vector<TensorView<const T>> views(operands.size());
  std::vector<TensorView<T>> result_views;
  for (std::size_t i = 0; i < operands.size(); ++i) {
    if (!given[i].is_there) continue;
    values[i].resize(operands[i].size());
    for (std::size_t k = 0; k < values[i].size(); ++k)
      values[i].data()[k] = static_cast<T>(operands[i].at(k));
    views[i] = {&operands[i].shape, values[i].data()};
  }
  for (const auto& result : operation.results()) {
    results.emplace_back(size_of(result.shape));
    result_views.push_back({&result.shape, results.back().data()});
  }
  operation.prepare(views);
  OperationState<T> state;
  operation.forward({views, result_views, state, false, Engine::automatic});
  std::vector<std::vector<double>> all;
  for (const auto& result : results) all.emplace_back(result.data(), result.data() + result.size());
  return all;
}

/// The results of an operation that moves elements: it is run on the elements' places, which are exact in T.
template <std::floating_point T>
[[nodiscard]] std::vector<std::vector<double>> move_once(Operation<T>& operation,
                                                         std::vector<Constant> operands, std::uint64_t moved,
                                                         const std::vector<FoldOperand>& given) {
  std::vector<double> elements;
  for (std::size_t i = 0; i < operands.size(); ++i) {
    if (i < 64 ? (moved >> i & 1U) == 0 : ~moved != 0) continue;
    std::vector<double> places;
    for (std::size_t k = 0; k < operands[i].size(); ++k) {
      places.push_back(static_cast<double>(elements.size()));
      elements.push_back(operands[i].at(k));
    }
    operands[i].values = std::move(places);
  }
  constexpr double most = 1 / static_cast<double>(std::numeric_limits<T>::epsilon());
  if (static_cast<double>(elements.size()) > most) return {};
  auto results = run_once(operation, operands, given);
  for (auto& result : results)
    for (double& place : result) place = elements[static_cast<std::size_t>(place)];
  return results;
}

/// The results of an operation on constants.
/// \throws DomainError for a result of integers that may not be exact
template <std::floating_point T>
[[nodiscard]] std::vector<std::vector<double>> folded(const Node& node, Operation<T>& operation,
                                                      const std::vector<Constant>& operands,
                                                      const std::vector<FoldOperand>& given) {
  if (std::same_as<T, double> || operands.empty()) return run_once(operation, operands, given);
  const auto& result = operation.results().front();
  const ElementFunction function = element_function(node, operands.front().type, result.type);
  const bool is_reduced = function.reduces && size_of(result.shape) == 1 && operands.front().size() > 0;
  if (is_reduced) return {reduced(function, operands.front())};
  if (!function.reduces && (function.one != nullptr || function.two != nullptr))
    return {combined(function, operands, result.shape)};
  if (const std::uint64_t moved = moved_operands(node); moved != 0)
    if (auto results = move_once(operation, operands, moved, given); !results.empty()) return results;
  auto results = run_once(operation, operands, given);
  constexpr double most = 2 / static_cast<double>(std::numeric_limits<T>::epsilon());
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const double value : results[i])
      if (operation.results()[i].type == ElementType::integer && (value > most || value < -most))
        throw DomainError({"a constant integer beyond 2^24, which ", node.operation, " computes in float"});
  return results;
}
}  // namespace tapestry::nn::detail

namespace tapestry::nn {
template <std::floating_point T>
std::vector<Constant> fold_node(const Node& node, std::int64_t opset,
                                const std::vector<FoldOperand>& operands, std::size_t most) {
  if (node.operation == "Shape" || node.operation == "Size") {
    require_operand_count(operand_count(operands), opset, {{1, 1}});
    const Shape& shape = operands.front().shape;
    if (node.operation == "Shape") return {detail::shape_constant(node, opset, shape)};
    return {detail::integers({static_cast<double>(size_of(shape))}, {})};
  }
  const Operator<T>& kind = operators<T>().find(node.operation)->second;
  const bool is_last = detail::is_channels_last(kind, operands);
  std::vector<Constant> stored(operands.size());
  std::vector<Operand> described;
  for (std::size_t i = 0; i < operands.size(); ++i) {
    const bool is_there = operands[i].is_there;
    if (is_there)
      stored[i] =
          is_last && i < kind.data_inputs ? to_channels_last(*operands[i].constant) : *operands[i].constant;
    described.push_back({stored[i].shape, stored[i].type, is_there ? &stored[i] : nullptr, is_there});
  }
  OperatorContext context(node, opset, std::move(described), is_last);
  const auto operation = made_operation(kind, context);
  for (const auto& result : operation->results()) {
    const std::size_t count = size_of(result.shape);
    if (count > most) throw ShapeError({"a constant result ", result.shape, " is too large"});
    most -= count;
  }
  auto values = detail::folded(node, *operation, stored, operands);
  std::vector<Constant> constants;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& facts = operation->results()[i];
    Constant result{facts.shape, facts.type, std::move(values[i])};
    constants.push_back(is_last && result.shape.size() == 4 ? from_channels_last(result) : std::move(result));
  }
  return constants;
}
}  // namespace tapestry::nn
