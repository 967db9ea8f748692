#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// Operators on integers of few bits, in floating-point numbers. Rounding has the derivative 1, straight
/// through; beyond the integers' range it is 0. Source: onnx.ai, Operators.md; Bengio et al., "Estimating or
/// propagating gradients through stochastic neurons" (2013).
class QuantisedParts {
 public:
  QuantisedParts(OperatorContext& context, Decomposer& parts) : context_(context), parts_(parts) {}

  /// (x − zero point) · scale of three operands from `first` on. \param axis  that a list of scales is for
  std::string dequantised(std::size_t first, std::size_t axis) {
    return parts_.add("Mul", {shifted(first, first + 2, axis), spread(first + 1, first, axis)});
  }
  /// x − zero point; the zero point may be left out.
  std::string shifted(std::size_t x, std::size_t zero, std::size_t axis) {
    const std::string value = floating(x);
    return context_.has_input(zero) ? parts_.add("Sub", {value, spread(zero, x, axis)}) : value;
  }

  /// Makes the first result: round(x / scale) + zero point, within the range of its integers.
  /// \param x     of `rank` axes
  /// \param scale operand, behind which the zero point is
  void quantise(const std::string& x, std::size_t rank, std::size_t scale, std::size_t axis) {
    const Range range = range_of(scale + 1);
    std::string value = parts_.add("StraightRound", {parts_.add("Div", {x, spread_to(scale, rank, axis)})});
    if (context_.has_input(scale + 1)) value = parts_.add("Add", {value, spread_to(scale + 1, rank, axis)});
    parts_.finish_clipped(0, value, range.least, range.most);
  }

  /// The axis that lists of scales are for.
  [[nodiscard]] std::size_t axis() {
    if (context_.integer("block_size", 0) != 0) throw DomainError("attribute 'block_size' is not supported");
    const std::size_t rank = context_.input(0).shape.size();
    const std::int64_t stated = context_.integer("axis", 1);
    const bool is_used = context_.has_input(1) && size_of(context_.input(1).shape) > 1;
    return is_used ? context_.axis(stated, rank) : 0;
  }

  [[nodiscard]] std::string floating(std::size_t i) {
    if (context_.input(i).type == ElementType::floating) return parts_.input(i);
    return parts_.add("Cast", {parts_.input(i)}, {{"to", std::int64_t{1}}});
  }
  /// A scale or zero point, of one number or of one for each place along an axis of the operand `of`.
  [[nodiscard]] std::string spread(std::size_t i, std::size_t of, std::size_t axis) {
    return spread_to(i, context_.input(of).shape.size(), axis);
  }

 private:
  struct Range {
    double least, most;
  };

  [[nodiscard]] std::string spread_to(std::size_t i, std::size_t rank, std::size_t axis) {
    const Shape& own = context_.input(i).shape;
    const std::string value = floating(i);
    if (size_of(own) == 1) return parts_.reshaped(value, {});
    if (own.size() != 1 || axis >= rank)
      throw ShapeError({"input ", i, " is ", own, ", expected one number or a list of them"});
    Shape shape(rank - axis, 1);
    shape[0] = own[0];
    return parts_.reshaped(value, shape);
  }

  /// Finds the range by output_dtype, else by the zero point's type in the file, else takes UINT8's.
  [[nodiscard]] Range range_of(std::size_t zero) {
    const std::int32_t of_zero = context_.has_input(zero) && context_.input(zero).constant != nullptr
                                     ? context_.constant(zero).file_type
                                     : 0;
    const std::int64_t stated = context_.integer("output_dtype", 0);
    const std::int64_t type = stated != 0 ? stated : of_zero;
    if (type == 0 || type == 2) return {0, 255};
    if (type == 3) return {-128, 127};
    if (type == 4) return {0, 65535};
    if (type == 5) return {-32768, 32767};
    throw DomainError({"integers of ONNX's type ", type, " are not supported"});
  }

  OperatorContext& context_;
  Decomposer& parts_;
};

inline void decompose_dequantize(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  parts.finish(0, "Identity", {own.dequantised(0, own.axis())});
}

inline void decompose_quantize(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  context.ignore("saturate");  // of types of eight bits with a point
  own.quantise(own.floating(0), context.input(0).shape.size(), 1, own.axis());
}

/// Integers of eight bits with a scale and zero point by the least and largest number, 0 among them.
inline void decompose_dynamic_quantize(OperatorContext&, Decomposer& parts) {
  const Decomposer::Attributes whole{{"keepdims", std::int64_t{0}}};
  const std::string &x = parts.input(0), zero = parts.number(0), largest = parts.number(255);
  const std::string most = parts.add("Max", {parts.add("ReduceMax", {x}, whole), zero});
  const std::string least = parts.add("Min", {parts.add("ReduceMin", {x}, whole), zero});
  const std::string scale = parts.add("Div", {parts.add("Sub", {most, least}), largest});
  const std::string point = parts.add(
      "Clip",
      {parts.add("StraightRound", {parts.add("Div", {parts.add("Neg", {least}), scale})}), zero, largest});
  const std::string steps = parts.add("StraightRound", {parts.add("Div", {x, scale})});
  parts.finish_clipped(0, parts.add("Add", {steps, point}), 0, 255);
  parts.finish(1, "Identity", {scale});
  parts.finish(2, "Identity", {point});
}

inline void decompose_conv_integer(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  for (const auto& [name, value] : parts.node().attributes) context.ignore(name);
  parts.finish(0, "Conv", {own.shifted(0, 2, 0), own.shifted(1, 3, 0)}, parts.node().attributes);
}

/// Zero points are one number, or one for each row of the first and each column of the second matrix.
inline void decompose_matmul_integer(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  const std::size_t rows = context.input(0).shape.size(), columns = context.input(1).shape.size();
  if (rows < 2 || columns < 2) throw ShapeError("operands 0 and 1 need two axes or more each");
  parts.finish(0, "MatMul", {own.shifted(0, 2, rows - 2), own.shifted(1, 3, columns - 1)});
}

inline void decompose_qlinear_conv(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  for (const auto& [name, value] : parts.node().attributes) context.ignore(name);
  Decomposer::Names inputs{own.dequantised(0, 0), own.dequantised(3, 0)};
  if (context.has_input(8)) {  // in units of both scales
    const std::string scales = parts.add("Mul", {own.spread(1, 8, 0), own.spread(4, 8, 0)});
    inputs.push_back(parts.add("Mul", {own.floating(8), scales}));
  }
  own.quantise(parts.add("Conv", std::move(inputs), parts.node().attributes), context.input(0).shape.size(),
               6, 1);
}

inline void decompose_qlinear_matmul(OperatorContext& context, Decomposer& parts) {
  QuantisedParts own(context, parts);
  const std::size_t rows = context.input(0).shape.size(), columns = context.input(3).shape.size();
  if (rows < 2 || columns < 2) throw ShapeError("operands 0 and 3 need two axes or more each");
  const std::string product =
      parts.add("MatMul", {own.dequantised(0, rows - 2), own.dequantised(3, columns - 1)});
  own.quantise(product, std::max(rows, columns), 6, std::max(rows, columns) - 2);
}
}  // namespace tapestry::nn::detail
