#pragma once
#include <tapestry/nn/detail/network/operators/kernel_attributes.hpp>

namespace tapestry::nn {
/// Pixels of blocks of a picture as channels of one pixel: channels j · C … of pixel (y, x) are pixel
/// (y · rows + row_j, x · columns + column_j).
struct PixelBlocks {
  /// Place of a pixel within its block.
  struct Place {
    std::size_t row, column;
  };
  std::size_t rows = 1, columns = 1;
  std::vector<Place> places{};
};

/// Blocks of pixels laid side by side as channels.
template <std::floating_point T>
class PixelUnshuffle : public Operation<T> {
 public:
  /// \param shape  [N, H, W, C] of whole blocks
  PixelUnshuffle(const Shape& shape, PixelBlocks blocks)
      : Operation<T>(
            {{{shape[0], shape[1] / blocks.rows, shape[2] / blocks.columns, shape[3] * blocks.places.size()},
              ElementType::floating}}),
        shape_(shape),
        blocks_(std::move(blocks)) {}

  [[nodiscard]] std::optional<MapWindow> window_reached(Engine, std::span<const MapWindow> changed,
                                                        bool) const override {
    return blocks_of_pixels(changed[0], blocks_.rows, blocks_.columns);
  }
  [[nodiscard]] MapWindow window_read(Engine, std::size_t, const MapWindow& computed) const override {
    return pixels_of_blocks(computed, blocks_.rows, blocks_.columns);
  }

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    if (shape_[3] == 3) {  // a copy of constant length is a few instructions
      for_each_pixel([&](std::size_t i, std::size_t o) { std::memcpy(out + o, in + i, 3 * sizeof(T)); });
    } else {
      const std::size_t bytes = shape_[3] * sizeof(T);
      for_each_pixel([&](std::size_t i, std::size_t o) { std::memcpy(out + o, in + i, bytes); });
    }
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const from = call.output_adjoints[0].values;
    T* const to = call.accumulate(0);
    for_each_pixel([&](std::size_t i, std::size_t o) {
      for (std::size_t c = 0; c < shape_[3]; ++c) to[i + c] += from[o + c];
    });
  }

 private:
  /// Calls body(first element of an input pixel, its place in the result), rows of the result side by side.
  template <class Body>
  void for_each_pixel(Body body) const {
    const Shape& out = this->result_shape();
    const std::size_t channels = shape_[3], count = blocks_.places.size();
    parallel_for(out[0] * out[1], [&](std::size_t row) {
      const std::size_t first_row = row / out[1] * shape_[1] + row % out[1] * blocks_.rows;
      for (std::size_t x = 0; x < out[2]; ++x)
        for (std::size_t j = 0; j < count; ++j) {
          const std::size_t y = first_row + blocks_.places[j].row;
          const std::size_t column = x * blocks_.columns + blocks_.places[j].column;
          body((y * shape_[2] + column) * channels, ((row * out[2] + x) * count + j) * channels);
        }
    });
  }

  Shape shape_;
  PixelBlocks blocks_;
};

/// PixelUnshuffle, which simplified() makes of a Concat of Slices that take, for example, every second row
/// and column. Attributes: `block`, its rows and columns, and `places`, a row and a column each.
template <std::floating_point T>
void add_pixel_unshuffle(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    const Shape& shape = picture_shape(context);
    PixelBlocks blocks;
    std::size_t block[2] = {1, 1};
    detail::read_extents(context, "block", 2, block);
    blocks.rows = block[0];
    blocks.columns = block[1];
    const auto places = context.integers("places");
    for (std::size_t i = 0; i + 1 < places.size(); i += 2)
      blocks.places.push_back({static_cast<std::size_t>(places[i]), static_cast<std::size_t>(places[i + 1])});
    for (const auto& place : blocks.places)
      if (place.row >= block[0] || place.column >= block[1])
        throw DomainError("attribute 'places' reaches beyond a block");
    if (blocks.places.empty() || shape[1] % block[0] != 0 || shape[2] % block[1] != 0)
      throw ShapeError({"a picture ", shape, " is not one of whole blocks"});
    return std::make_unique<PixelUnshuffle<T>>(shape, std::move(blocks));
  };
  table["PixelUnshuffle"] = {LayoutRule::channels_last,
                             1,
                             false,
                             {{1, 1}},
                             make,
                             {{"block", 1, largest_window}, {"places", 0, largest_window}}};
}
}  // namespace tapestry::nn
