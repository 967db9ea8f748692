#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network_config/decode_choice.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/detect/network_config/shape.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

namespace tapestry::detect {
namespace detail {
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

/// How pictures go into a network's input: as letter_box says, whose 1 means a letterbox and 0 means that
/// they are stretched, and where a cfg does not say it, in a letterbox. Source: the option letter_box in
/// AlexeyAB's Darknet, which stretches where it is left out; the first Darknet has no such option and a
/// letterbox always.
[[nodiscard]] inline image::Fit fit_of(const NetworkConfig& config) {
  return image::fit_by_name(config.letter_box.value_or(true) ? "letterbox" : "stretch");
}

/// Checks that a description is a detector's: layers that fit each other at the size it names, at least one
/// head, no two heads of the same grid, and all of one decode family. A reader of files calls it; so should
/// who writes a description by hand.
/// \throws FileError  as infer_shapes(), and mismatch for the heads, with the description's name and line
inline void check_network(const NetworkConfig& config) {
  detail::check_heads(config, infer_shapes(config, config.height, config.width));
  detail::check_decode(config);
}

/// Checks that a description is that of a network without heads, whose last layer is what it tells: a
/// classifier, or the beginning of a detector.
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
