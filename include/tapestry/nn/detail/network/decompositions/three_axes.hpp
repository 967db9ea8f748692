#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// Whether a convolution or pooling runs along one axis, [N, C, L].
[[nodiscard]] inline bool has_one_axis(const OperatorContext& context) {
  return context.has_input(0) && context.input(0).shape.size() == 3;
}

/// The same along a row of a picture of height 1, [N, C, 1, L].
inline void decompose_along_one_axis(OperatorContext& context, Decomposer& parts) {
  const Node& node = parts.node();
  for (std::size_t i = 1; i < node.outputs.size(); ++i)
    if (!node.outputs[i].empty()) throw DomainError({"result ", i, " is not supported along one axis"});
  const auto raised = [&](std::size_t i) {
    const Shape& shape = context.input(i).shape;
    if (shape.size() != 3) throw ShapeError({"input ", i, " is ", shape, ", expected three axes"});
    return parts.reshaped(parts.input(i), {shape[0], shape[1], 1, shape[2]});
  };
  Decomposer::Names inputs{raised(0)};
  if (context.has_input(1)) inputs.push_back(raised(1));
  for (std::size_t i = 2; i < node.inputs.size(); ++i) inputs.push_back(node.inputs[i]);
  Decomposer::Attributes attributes = node.attributes;
  for (auto& [name, value] : attributes) {
    context.ignore(name);
    auto* const numbers = std::get_if<std::vector<std::int64_t>>(&value);
    if (numbers == nullptr) continue;
    const std::size_t expected = name == "pads" ? 2 : 1;
    if (numbers->size() != expected)
      throw ShapeError(
          {"attribute ", in_quotes(name), " has ", numbers->size(), " numbers, expected ", expected});
    const std::int64_t neutral = name == "pads" || name == "output_padding" ? 0 : 1;
    if (name == "pads")
      *numbers = {0, (*numbers)[0], 0, (*numbers)[1]};
    else
      numbers->insert(numbers->begin(), neutral);
  }
  const std::string flat = parts.add(node.operation.c_str(), std::move(inputs), std::move(attributes));
  parts.squeeze(0, flat, 2);
}

/// Whether a convolution or pooling runs along one or three axes, [N, C, L] or [N, C, D, H, W].
[[nodiscard]] inline bool has_odd_axes(const OperatorContext& context) {
  if (!context.has_input(0)) return false;
  const std::size_t rank = context.input(0).shape.size();
  return rank == 3 || rank == 5;
}

/// Convolutions and pools of three axes become several of pictures, [N, C, H, W].
class ThreeAxesParts {
 public:
  ThreeAxesParts(OperatorContext& context, Decomposer& parts)
      : context_(context), parts_(parts), node_(parts.node()), x_(context.input(0).shape) {
    for (std::size_t i = 1; i < node_.outputs.size(); ++i)
      if (!node_.outputs[i].empty()) throw DomainError({"result ", i, " is not supported along three axes"});
  }

  /// Along the depth, then along rows and columns: largest and mean are separable.
  void pool() {
    const std::string columns = parts_.reshaped(parts_.input(0), {x_[0], x_[1], x_[2], x_[3] * x_[4]});
    const std::string deep = parts_.add(node_.operation.c_str(), {columns}, attributes(true));
    const std::string pictures =
        parts_.add("Reshape", {deep, parts_.integers({whole(x_[0]), -1, whole(x_[3]), whole(x_[4])})});
    finish_with_pixels(parts_.add(node_.operation.c_str(), {pictures}, attributes(false)),
                       {whole(x_[0]), whole(x_[1]), -1});
  }

  /// Sum over the depth's taps of convolutions of the pictures under each tap.
  void convolve() {
    const Shape& w = context_.input(1).shape;
    if (w.size() != 5) throw ShapeError({"input 1 is ", w, ", expected five axes"});
    const auto strides = three("strides"), dilations = three("dilations");
    auto pads = context_.integers("pads", std::vector<std::int64_t>(6, 0));
    if (pads.size() != 6) throw ShapeError({"attribute 'pads' has ", pads.size(), " numbers, expected 6"});
    if (const auto kind = context_.text("auto_pad", "NOTSET"); kind != "NOTSET" && kind != "VALID")
      throw DomainError({"attribute 'auto_pad' is ", in_quotes(kind), " along three axes"});
    const std::int64_t depth = whole(x_[2]) + pads[0] + pads[3], reach = dilations[0] * (whole(w[2]) - 1);
    if (pads[0] < 0 || pads[3] < 0 || depth > largest_extent || depth <= reach)
      throw ShapeError({"a depth of ", depth, " for a filter of ", reach + 1});
    const std::int64_t count = (depth - reach - 1) / strides[0] + 1;
    const std::string x = padded(pads[0], pads[3]);
    Decomposer::Names sums;
    for (std::int64_t tap = 0; tap < whole(w[2]); ++tap) {
      const std::int64_t first = tap * dilations[0];
      const std::string met = parts_.sliced(x, first, first + (count - 1) * strides[0] + 1, 2, strides[0]);
      const std::string pictures =
          parts_.add("Reshape", {parts_.transposed(met, {0, 2, 1, 3, 4}),
                                 parts_.integers({-1, whole(x_[1]), whole(x_[3]), whole(x_[4])})});
      const std::string filter =
          parts_.reshaped(parts_.sliced(parts_.input(1), tap, tap + 1, 2), {w[0], w[1], w[3], w[4]});
      Decomposer::Names inputs{pictures, filter};
      if (tap == 0 && context_.has_input(2)) inputs.push_back(parts_.input(2));
      sums.push_back(parts_.add("Conv", std::move(inputs), attributes(false)));
    }
    const std::string sum = sums.size() == 1 ? sums[0] : parts_.add("Sum", std::move(sums));
    const std::string deep = with_pixels(sum, {whole(x_[0]), -1, whole(w[0])});
    parts_.finish(0, "Transpose", {deep}, {{"perm", std::vector<std::int64_t>{0, 2, 1, 3, 4}}});
  }

 private:
  static std::int64_t whole(std::size_t n) { return static_cast<std::int64_t>(n); }

  [[nodiscard]] std::vector<std::int64_t> three(const char* name) {
    const auto all = context_.integers(name, {1, 1, 1});
    if (all.size() != 3)
      throw ShapeError({"attribute ", in_quotes(name), " has ", all.size(), " numbers, expected 3"});
    for (const std::int64_t one : all)
      if (one < 1 || one > largest_extent) throw ShapeError({"attribute ", in_quotes(name), " has ", one});
    return all;
  }

  /// The node's attributes, of the depth as rows of columns, or of the pictures.
  [[nodiscard]] Decomposer::Attributes attributes(bool is_depth) {
    Decomposer::Attributes own = node_.attributes;
    for (auto& [name, value] : own) {
      context_.ignore(name);
      auto* const all = std::get_if<std::vector<std::int64_t>>(&value);
      if (all == nullptr) continue;
      const bool is_pad = name == "pads";
      if (all->size() != (is_pad ? 6 : 3))
        throw ShapeError(
            {"attribute ", in_quotes(name), " has ", all->size(), " numbers, expected ", is_pad ? 6 : 3});
      const auto& n = *all;
      if (is_pad)
        *all = is_depth ? std::vector<std::int64_t>{n[0], 0, n[3], 0}
                        : std::vector<std::int64_t>{n[1], n[2], n[4], n[5]};
      else
        *all = is_depth ? std::vector<std::int64_t>{n[0], 1} : std::vector<std::int64_t>{n[1], n[2]};
    }
    return own;
  }

  [[nodiscard]] std::string padded(std::int64_t before, std::int64_t behind) {
    if (before == 0 && behind == 0) return parts_.input(0);
    return parts_.padded(parts_.input(0), {0, 0, before, 0, 0, 0, 0, behind, 0, 0});
  }

  /// A value whose last two axes are rows and columns, with other extents before these.
  [[nodiscard]] std::string with_pixels(const std::string& value, const std::vector<std::int64_t>& first) {
    const std::string pixels = parts_.add("Gather", {parts_.add("Shape", {value}), parts_.integers({2, 3})},
                                          {{"axis", std::int64_t{0}}});
    const std::string shape =
        parts_.add("Concat", {parts_.integers(first), pixels}, {{"axis", std::int64_t{0}}});
    return parts_.add("Reshape", {value, shape});
  }
  void finish_with_pixels(const std::string& value, const std::vector<std::int64_t>& first) {
    parts_.finish(0, "Identity", {with_pixels(value, first)});
  }

  OperatorContext& context_;
  Decomposer& parts_;
  const Node& node_;
  const Shape x_;
};

/// Convolution, transposed convolution or pooling along one or three axes.
inline void decompose_odd_axes(OperatorContext& context, Decomposer& parts) {
  const std::string& operation = parts.node().operation;
  if (has_one_axis(context)) return decompose_along_one_axis(context, parts);
  if (operation == "ConvTranspose") throw DomainError("three axes are not supported");
  ThreeAxesParts three(context, parts);
  if (operation == "Conv") return three.convolve();
  three.pool();
}
}  // namespace tapestry::nn::detail
