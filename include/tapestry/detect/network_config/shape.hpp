#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <vector>

namespace tapestry::detect {

/// Extents of a layer's output for one image.
struct FeatureShape {
  std::size_t channels = 0;
  std::size_t height = 0;
  std::size_t width = 0;
  double row_reduction = 1;     ///< input pixels per cell, downwards
  double column_reduction = 1;  ///< and to the right

  [[nodiscard]] std::size_t size() const { return channels * height * width; }
};

namespace detail {

inline constexpr std::uint64_t largest_element_count = std::uint64_t(1) << 31U;

[[nodiscard]] std::string to_text(const FeatureShape& shape);

[[nodiscard]] FileError misfit(const NetworkConfig& config, std::size_t index, const std::string& what,
                               const std::string& expected, const std::string& found);

/// The head that a layer is, whose output has this shape.
[[nodiscard]] Head head_of(const LayerConfig& layer, const FeatureShape& shape);

}  // namespace detail

/// Output extents of every layer for an input of `height` × `width` pixels.
///
/// Convolution and pooling round down; a maxpool's padding lies half before (rounded down) and the rest
/// after its input, as in Darknet since 2018.
/// \throws FileError  mismatch where layers do not fit each other or the input, limit where a product
///                    passes 2³¹, with the path and line of the layer
[[nodiscard]] std::vector<FeatureShape> infer_shapes(const NetworkConfig& config, std::size_t height,
                                                     std::size_t width);

}  // namespace tapestry::detect
