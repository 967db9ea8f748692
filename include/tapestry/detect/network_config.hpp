#pragma once
#include <tapestry/core/array_limit.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/image/letterbox.hpp>

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
/// All heads are of one family with anchors; heads of the family scaled read activations.
void check_decode(const NetworkConfig& config);

inline constexpr std::uint64_t largest_element_count =
    std::min<std::uint64_t>(std::uint64_t(1) << 31U, array_limit);

[[nodiscard]] std::string to_text(const FeatureShape& shape);

[[nodiscard]] FileError misfit(const NetworkConfig& config, std::size_t index, const std::string& what,
                               const std::string& expected, const std::string& found);

/// The head that a layer is, whose output has this shape.
[[nodiscard]] Head head_of(const LayerConfig& layer, const FeatureShape& shape);

/// A detector has at least one head, and no two heads of the same grid.
inline void check_heads(const NetworkConfig& config, const std::vector<FeatureShape>& shapes) {
  std::vector<std::size_t> heads;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    if (!is_head(config.layers[i].kind)) continue;
    for (const std::size_t earlier : heads) {
      if (shapes[earlier].row_reduction == shapes[i].row_reduction) {
        throw misfit(config, i, "another head has the same grid", "one head for each scale",
                     "the one on line " + std::to_string(config.layers[earlier].line));
      }
    }
    heads.push_back(i);
  }
  if (heads.empty()) {
    throw cfg_error(config.name, config.line, "no [yolo] or [region] section, so this is not a detector", "",
                    "", ErrorKind::mismatch);
  }
}
}  // namespace detail

/// The decode family of a network's heads; darknet where there is none.
[[nodiscard]] DecodeFamily decode_family_of(const NetworkConfig& config);

/// The same network with heads of this decode family. A cfg with new_coords=1 is scaled and stays so; one
/// without that option leaves the choice open. A [region] is of the family darknet.
///
/// \throws FileError (mismatch) for a family that contradicts new_coords=1 or [region] or has no anchors, and
///         for scaled unless each head reads a convolution with activation=logistic
[[nodiscard]] NetworkConfig with_decode(NetworkConfig config, DecodeFamily family);

/// One remark for each head that applies σ to values that have been through σ: Darknet computes that, too,
/// but hardly any detector intends it.
[[nodiscard]] std::vector<std::string> decode_warnings(const NetworkConfig& config);

/// Output extents of every layer for an input of `height` × `width` pixels.
///
/// Convolution and pooling round down; a maxpool's padding lies half before (rounded down) and the rest
/// after its input, as in Darknet since 2018.
/// \throws FileError  mismatch where layers do not fit each other or the input, limit where a product
///                    passes 2³¹, with the path and line of the layer
[[nodiscard]] std::vector<FeatureShape> infer_shapes(const NetworkConfig& config, std::size_t height,
                                                     std::size_t width);

/// How pictures go into a network's input. The option letter_box decides: 1 is a letterbox, 0 stretches;
/// without the option, a letterbox. Source: the option letter_box in AlexeyAB's Darknet, which stretches
/// where it is left out; the first Darknet has no such option and always uses a letterbox.
[[nodiscard]] inline image::Fit fit_of(const NetworkConfig& config) {
  return image::fit_by_name(config.letter_box.value_or(true) ? "letterbox" : "stretch");
}

/// Checks that a description is a detector's: layers that fit each other at its size, at least one head, no
/// two heads of the same grid, and all of one decode family. A reader of files calls it; descriptions by hand
/// should be checked, too.
/// \throws FileError  as infer_shapes(), and mismatch for the heads, with the description's name and line
inline void check_network(const NetworkConfig& config) {
  detail::check_heads(config, infer_shapes(config, config.height, config.width));
  detail::check_decode(config);
}

/// Checks that a description is a network without heads, whose result is its last layer: a classifier, or the
/// beginning of a detector.
/// \throws FileError  as infer_shapes(), and mismatch for a head or where there are no layers
inline void check_classifier(const NetworkConfig& config) {
  if (config.layers.empty())
    throw cfg_error(config.name, config.line, "a network without layers", "", "", ErrorKind::mismatch);
  for (std::size_t i = 0; i < config.layers.size(); ++i)
    if (is_head(config.layers[i].kind))
      throw detail::misfit(config, i, "a head, so this is not a classifier", "none", "");
  static_cast<void>(infer_shapes(config, config.height, config.width));
}
}  // namespace tapestry::detect
