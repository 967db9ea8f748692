#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// A convolution whose kernel has other sampling points for each pixel: bilinear lookups at moved places, 0
/// outside, times a mask, then a product with the weights. Source: onnx.ai, DeformConv; Dai et al.,
/// "Deformable Convolutional Networks" (ICCV 2017), and Zhu et al. (CVPR 2019) for the mask.
class DeformableConvolution {
 public:
  DeformableConvolution(OperatorContext& context, Decomposer& parts)
      : context_(context),
        parts_(parts),
        x_(context.input(0).shape),
        weights_(context.input(1).shape),
        offsets_(context.input(2).shape),
        strides_(context.integers("strides", {1, 1})),
        dilations_(context.integers("dilations", {1, 1})),
        pads_(context.integers("pads", {0, 0, 0, 0})),
        groups_(context.integer("group", 1)),
        offset_groups_(static_cast<std::size_t>(context.integer("offset_group", 1))) {
    context.ignore("kernel_shape");  // the weights have it
    if (x_.size() != 4 || weights_.size() != 4 || offsets_.size() != 4 || strides_.size() != 2 ||
        dilations_.size() != 2 || pads_.size() != 4)
      throw ShapeError({"maps ", x_, " and weights ", weights_, ", expected four axes each"});
    points_ = weights_[2] * weights_[3];
    if (offset_groups_ == 0 || x_[1] % offset_groups_ != 0 || offsets_[1] != offset_groups_ * points_ * 2 ||
        offsets_[0] != x_[0])
      throw ShapeError(
          {"offsets ", offsets_, " of maps ", x_, ", expected ", offset_groups_ * points_ * 2, " channels"});
  }

  void write() {
    const std::string places = unmoved(), scale = units_a_pixel();
    std::vector<std::string> groups;
    for (std::size_t group = 0; group < offset_groups_; ++group)
      groups.push_back(looked_up(group, places, scale));
    const std::string all =
        groups.size() == 1 ? groups[0] : parts_.add("Concat", groups, {{"axis", std::int64_t{1}}});
    Decomposer::Names operands{parts_.reshaped(all, {x_[0], x_[1] * points_, offsets_[2], offsets_[3]}),
                               parts_.reshaped(parts_.input(1), {weights_[0], weights_[1] * points_, 1, 1})};
    if (context_.has_input(3)) operands.push_back(parts_.input(3));
    parts_.finish(0, "Conv", std::move(operands), {{"group", groups_}});
  }

 private:
  /// Sampling points of a kernel without offsets, as GridSample counts: [1, points, rows, columns, 2], x
  /// first, −1 and 1 the edges of the map.
  [[nodiscard]] std::string unmoved() {
    const Shape shape{1, points_, offsets_[2], offsets_[3], 2};
    require_room(shape);
    std::vector<double> values;
    for (std::size_t point = 0; point < points_; ++point)
      for (std::size_t row = 0; row < offsets_[2]; ++row)
        for (std::size_t column = 0; column < offsets_[3]; ++column)
          for (const std::size_t axis : {1U, 0U}) {
            const std::size_t of_kernel = axis == 0 ? point / weights_[3] : point % weights_[3];
            const auto pixel =
                static_cast<double>(static_cast<std::int64_t>(axis == 0 ? row : column) * strides_[axis] -
                                    pads_[axis] + static_cast<std::int64_t>(of_kernel) * dilations_[axis]);
            values.push_back((2 * pixel + 1) / static_cast<double>(x_[2 + axis]) - 1);
          }
    return parts_.constant({shape, ElementType::floating, std::move(values)});
  }

  /// GridSample's units by pixels, x first.
  [[nodiscard]] std::string units_a_pixel() {
    return parts_.constant(
        {{2},
         ElementType::floating,
         std::vector<double>{2 / static_cast<double>(x_[3]), 2 / static_cast<double>(x_[2])}});
  }

  /// Looks up the channels of an offset group at each point of the kernel: [N, channels, points, rows,
  /// columns].
  [[nodiscard]] std::string looked_up(std::size_t group, const std::string& places,
                                      const std::string& scale) {
    const std::size_t n = x_[0], rows = offsets_[2], columns = offsets_[3], channels = x_[1] / offset_groups_;
    const auto of_group = [&](const std::string& value, std::size_t count) {
      if (offset_groups_ == 1) return value;
      return parts_.sliced(value, static_cast<std::int64_t>(group * count),
                           static_cast<std::int64_t>((group + 1) * count), 1);
    };
    std::string moves =
        parts_.reshaped(of_group(parts_.input(2), 2 * points_), {n, points_, 2, rows, columns});
    moves = parts_.transposed(moves, {0, 1, 3, 4, 2});
    moves = parts_.add("Gather", {moves, parts_.integers({1, 0})}, {{"axis", std::int64_t{4}}});
    const std::string grid = parts_.add("Add", {places, parts_.add("Mul", {moves, scale})});
    const std::string found = parts_.add(
        "GridSample",
        {of_group(parts_.input(0), channels), parts_.reshaped(grid, {n, points_ * rows, columns, 2})});
    std::string apart = parts_.reshaped(found, {n, channels, points_, rows, columns});
    if (context_.has_input(4))
      apart = parts_.add("Mul", {apart, parts_.reshaped(of_group(parts_.input(4), points_),
                                                        {n, 1, points_, rows, columns})});
    return apart;
  }

  OperatorContext& context_;
  Decomposer& parts_;
  Shape x_, weights_, offsets_;
  std::vector<std::int64_t> strides_, dilations_, pads_;
  std::int64_t groups_;
  std::size_t offset_groups_, points_ = 0;
};

inline void decompose_deform_conv(OperatorContext& context, Decomposer& parts) {
  DeformableConvolution(context, parts).write();
}

/// Slices along `axis` where a condition holds; without `axis`, elements. Source: onnx.ai, Compress.
inline void decompose_compress(OperatorContext& context, Decomposer& parts) {
  const std::string places =
      parts.add("Reshape", {parts.add("NonZero", {parts.input(1)}), parts.integers({-1})});
  if (context.has_attribute("axis"))
    return parts.finish(0, "Gather", {parts.input(0), places}, {{"axis", context.integer("axis", 0)}});
  parts.finish(0, "Gather", {parts.reshaped(parts.input(0), {size_of(context.input(0).shape)}), places});
}
}  // namespace tapestry::nn::detail
