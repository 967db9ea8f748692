#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <vector>

namespace tapestry::nn::detail {

/// x · σ(alpha · x), as ONNX Runtime's optimiser writes SiLU.
inline void decompose_quick_gelu(OperatorContext& context, Decomposer& parts) {
  const double alpha = context.number("alpha", 1.702);
  const std::string& x = parts.input(0);
  const std::string inner = alpha == 1 ? x : parts.add("Mul", {x, parts.number(alpha)});
  parts.finish(0, "Mul", {x, parts.add("Sigmoid", {inner})});
}

/// x / √(mean of x² + epsilon) · scale over the axes from `axis` on. Source: onnx.ai, RMSNormalization.
inline void decompose_rms_normalization(OperatorContext& context, Decomposer& parts) {
  const auto rank = static_cast<std::int64_t>(context.input(0).shape.size());
  const auto first =
      static_cast<std::int64_t>(context.axis(context.integer("axis", -1), context.input(0).shape.size()));
  const double epsilon = context.number("epsilon", 1e-5);
  context.ignore("stash_type");
  std::vector<std::int64_t> axes;
  for (std::int64_t axis = first; axis < rank; ++axis) axes.push_back(axis);
  const std::string& x = parts.input(0);
  const std::string mean = parts.add("ReduceMean", {parts.add("Mul", {x, x}), parts.integers(axes)});
  const std::string root = parts.add("Sqrt", {parts.add("Add", {mean, parts.number(epsilon)})});
  parts.finish(0, "Mul", {parts.add("Div", {x, root}), parts.input(1)});
}

/// softmax(Q·Kᵀ·scale + mask)·V of heads, [batch, heads, length, width], or [batch, length, heads · width].
/// Source: onnx.ai, Attention of opset 23.
inline void decompose_attention(OperatorContext& context, Decomposer& parts) {
  const Shape &q_shape = context.input(0).shape, &k_shape = context.input(1).shape;
  for (const std::size_t past : {4U, 5U})
    if (context.has_input(past)) throw DomainError({"past keys, input ", past, ", are not supported"});
  if (context.number("softcap", 0) != 0) throw DomainError("attribute 'softcap' is not supported");
  context.ignore("qk_matmul_output_mode");  // of a result that is refused below
  context.ignore("softmax_precision");
  const bool is_causal = context.integer("is_causal", 0) != 0;
  if (q_shape.size() != k_shape.size() || (q_shape.size() != 3 && q_shape.size() != 4))
    throw ShapeError({"queries ", q_shape, " and keys ", k_shape, ", expected three or four axes each"});
  const bool is_flat = q_shape.size() == 3;
  const auto heads_of = [&](const char* name, const Shape& shape) {
    const std::int64_t stated = context.integer(name, is_flat ? 0 : static_cast<std::int64_t>(shape[1]));
    if (stated <= 0 || (is_flat && shape[2] % static_cast<std::size_t>(stated) != 0))
      throw DomainError({"attribute ", in_quotes(name), " is ", stated});
    return static_cast<std::size_t>(stated);
  };
  const std::size_t heads = heads_of("q_num_heads", q_shape), key_heads = heads_of("kv_num_heads", k_shape);
  if (heads % key_heads != 0) throw ShapeError({heads, " heads of queries for ", key_heads, " of keys"});
  const std::size_t batch = q_shape[0], length = q_shape[is_flat ? 1 : 2], keys = k_shape[is_flat ? 1 : 2];
  const auto split = [&](std::size_t i, std::size_t count) {  // [batch, heads, length, width]
    const Shape& shape = context.input(i).shape;
    if (!is_flat) return parts.input(i);
    return parts.transposed(parts.reshaped(parts.input(i), {batch, shape[1], count, shape[2] / count}),
                            {0, 2, 1, 3});
  };
  const auto repeated = [&](std::size_t i) {  // keys and values for each head of the queries
    const std::string own = split(i, key_heads);
    if (key_heads == heads) return own;
    std::vector<std::int64_t> places;
    for (std::size_t h = 0; h < heads; ++h)
      places.push_back(static_cast<std::int64_t>(h / (heads / key_heads)));
    return parts.add("Gather", {own, parts.integers(places)}, {{"axis", std::int64_t{1}}});
  };
  const std::size_t width = is_flat ? q_shape[2] / heads : q_shape[3];
  const double scale = context.number("scale", 1 / std::sqrt(static_cast<double>(width)));
  std::string scores = parts.add("MatMul", {split(0, heads), parts.transposed(repeated(1), {0, 1, 3, 2})});
  scores = parts.add("Mul", {scores, parts.number(scale)});
  const double nothing = -std::numeric_limits<double>::infinity();
  if (context.has_input(3)) {
    const bool is_truth = context.input(3).type == ElementType::boolean;
    scores = is_truth ? parts.add("Where", {parts.input(3), scores, parts.number(nothing)})
                      : parts.add("Add", {scores, parts.input(3)});
  }
  if (is_causal) {
    Constant mask{{length, keys}, ElementType::floating, std::vector<double>(length * keys)};
    for (std::size_t i = 0; i < length * keys; ++i)
      if (i % keys > i / keys) std::get<std::vector<double>>(mask.values)[i] = nothing;
    scores = parts.add("Add", {scores, parts.constant(std::move(mask))});
  }
  const std::string shares = parts.add("Softmax", {scores}, {{"axis", std::int64_t{-1}}});
  if (!is_flat) return parts.finish(0, "MatMul", {shares, repeated(2)});
  const std::string heads_apart = parts.transposed(parts.add("MatMul", {shares, repeated(2)}), {0, 2, 1, 3});
  const auto flat = static_cast<std::int64_t>(heads * (context.input(2).shape[2] / key_heads));
  parts.finish(0, "Reshape",
               {heads_apart,
                parts.integers({static_cast<std::int64_t>(batch), static_cast<std::int64_t>(length), flat})});
}

/// Columns of patches added up to a picture, [N, C, H, W]. Source: onnx.ai, Col2Im.
inline void decompose_col2im(OperatorContext& context, Decomposer& parts) {
  const Shape& x = context.input(0).shape;
  const auto image = context.integers(1), block = context.integers(2);
  const std::size_t axes = image.size();
  const auto ones = std::vector<std::int64_t>(axes, 1);
  const auto dilations = context.integers("dilations", ones), strides = context.integers("strides", ones);
  const auto pads = context.integers("pads", std::vector<std::int64_t>(2 * axes, 0));
  if (x.size() != 3 || block.size() != axes || dilations.size() != axes || strides.size() != axes ||
      pads.size() != 2 * axes || axes == 0)
    throw ShapeError({"input 0 is ", x, " for a picture of ", axes, " axes"});
  std::size_t taps = 1, patches = 1, pixels = 1;
  std::vector<std::size_t> counts;
  for (std::size_t a = 0; a < axes; ++a) {
    const std::int64_t room = image[a] + pads[a] + pads[axes + a] - dilations[a] * (block[a] - 1) - 1;
    if (image[a] <= 0 || block[a] <= 0 || strides[a] <= 0 || dilations[a] <= 0 || room < 0 ||
        image[a] > largest_extent || block[a] > largest_extent)
      throw ShapeError({"patches of ", block[a], " in a picture of ", image[a], " pixels"});
    counts.push_back(static_cast<std::size_t>(room / strides[a] + 1));
    taps *= static_cast<std::size_t>(block[a]);
    patches *= counts.back();
    pixels *= static_cast<std::size_t>(image[a]);
    require_room({taps, patches});
    require_room({pixels});
  }
  if (x[1] % taps != 0 || x[2] != patches)
    throw ShapeError({"input 0 is ", x, ", expected ", patches, " patches of a multiple of ", taps});
  const std::size_t channels = x[1] / taps;
  std::vector<std::int64_t> places;  // of each tap of each patch; those beside the picture go to its end
  for (std::size_t tap = 0; tap < taps; ++tap)
    for (std::size_t patch = 0; patch < patches; ++patch) {
      std::size_t of_tap = tap, of_patch = patch, place = 0, step = 1;
      bool is_inside = true;
      for (std::size_t a = axes; a-- > 0;) {
        const auto at = static_cast<std::int64_t>(of_patch % counts[a]) * strides[a] - pads[a] +
                        static_cast<std::int64_t>(of_tap % static_cast<std::size_t>(block[a])) * dilations[a];
        is_inside = is_inside && at >= 0 && at < image[a];
        if (is_inside) place += static_cast<std::size_t>(at) * step;
        step *= static_cast<std::size_t>(image[a]);
        of_tap /= static_cast<std::size_t>(block[a]);
        of_patch /= counts[a];
      }
      places.push_back(static_cast<std::int64_t>(is_inside ? place : pixels));
    }
  // Scattered along the first axis: [taps · patches, N · channels].
  const std::string columns = parts.reshaped(
      parts.transposed(parts.reshaped(parts.input(0), {x[0] * channels, taps * patches}), {1, 0}),
      {taps * patches, x[0] * channels});
  Constant indices{
      {taps * patches, 1}, ElementType::integer, std::vector<double>(places.begin(), places.end())};
  const std::string nothing = parts.constant({{pixels + 1, x[0] * channels},
                                              ElementType::floating,
                                              std::vector<double>((pixels + 1) * x[0] * channels)});
  const std::string sums = parts.add("ScatterND", {nothing, parts.constant(std::move(indices)), columns},
                                     {{"reduction", std::string("add")}});
  const std::string inside = parts.add(
      "Slice",
      {sums, parts.integers({0}), parts.integers({static_cast<std::int64_t>(pixels)}), parts.integers({0})});
  std::vector<std::int64_t> shape{static_cast<std::int64_t>(x[0]), static_cast<std::int64_t>(channels)};
  shape.insert(shape.end(), image.begin(), image.end());
  parts.finish(0, "Reshape", {parts.transposed(inside, {1, 0}), parts.integers(shape)});
}

}  // namespace tapestry::nn::detail
