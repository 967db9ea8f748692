#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/nearest_word.hpp>
#include <tapestry/detect/network_config/section.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Options that say how Darknet trains or draws; they do not change what the network computes.
inline constexpr auto ignored_cfg_keys = std::to_array<std::string_view>({"batch",
                                                                          "subdivisions",
                                                                          "momentum",
                                                                          "decay",
                                                                          "angle",
                                                                          "aspect",
                                                                          "saturation",
                                                                          "exposure",
                                                                          "hue",
                                                                          "learning_rate",
                                                                          "learning_rate_min",
                                                                          "burn_in",
                                                                          "max_batches",
                                                                          "policy",
                                                                          "steps",
                                                                          "scales",
                                                                          "scale",
                                                                          "step",
                                                                          "gamma",
                                                                          "power",
                                                                          "time_steps",
                                                                          "notruth",
                                                                          "random",
                                                                          "adam",
                                                                          "B1",
                                                                          "B2",
                                                                          "eps",
                                                                          "max_crop",
                                                                          "min_crop",
                                                                          "max_ratio",
                                                                          "min_ratio",
                                                                          "center",
                                                                          "flip",
                                                                          "blur",
                                                                          "mixup",
                                                                          "cutmix",
                                                                          "mosaic",
                                                                          "mosaic_bound",
                                                                          "gaussian_noise",
                                                                          "letter_box",
                                                                          "label_smooth_eps",
                                                                          "dynamic_minibatch",
                                                                          "optimized_memory",
                                                                          "workspace_size_limit_MB",
                                                                          "num_steps",
                                                                          "track",
                                                                          "augment_speed",
                                                                          "sgdr_cycle",
                                                                          "sgdr_mult",
                                                                          "loss_scale",
                                                                          "cudnn_half",
                                                                          "ema_alpha",
                                                                          "weights_reject_freq",
                                                                          "equidistant_point",
                                                                          "burnin_power",
                                                                          "jitter",
                                                                          "resize",
                                                                          "ignore_thresh",
                                                                          "truth_thresh",
                                                                          "iou_thresh",
                                                                          "iou_normalizer",
                                                                          "cls_normalizer",
                                                                          "obj_normalizer",
                                                                          "delta_normalizer",
                                                                          "iou_loss",
                                                                          "iou_thresh_kind",
                                                                          "nms_kind",
                                                                          "beta_nms",
                                                                          "max",
                                                                          "max_delta",
                                                                          "map",
                                                                          "counters_per_class",
                                                                          "focal_loss",
                                                                          "objectness_smooth",
                                                                          "stopbackward",
                                                                          "learning_rate_scale",
                                                                          "dropblock",
                                                                          "probability",
                                                                          "onlyforward",
                                                                          "train_only_bn",
                                                                          "tanh_mult"});

/// Options that would change the result and that Tapestry does not implement, with the value that is
/// harmless.
inline constexpr auto unsupported_cfg_keys =
    std::to_array<std::array<std::string_view, 2>>({{"binary", "0"},
                                                    {"xnor", "0"},
                                                    {"bin_output", "0"},
                                                    {"flipped", "0"},
                                                    {"dot", "0"},
                                                    {"antialiasing", "0"},
                                                    {"assisted_excitation", "0"},
                                                    {"share_index", ""},
                                                    {"stretch", "0"},
                                                    {"stretch_sway", "0"},
                                                    {"rotate", "0"},
                                                    {"deform", "0"},
                                                    {"sway", "0"},
                                                    {"maxpool_depth", "0"},
                                                    {"avgpool", "0"},
                                                    {"embedding_layer", ""},
                                                    {"weights_type", "none"},
                                                    {"weights_normalization", "none"},
                                                    {"cbn", "0"},
                                                    {"tree", ""},
                                                    {"spatial", "0"},
                                                    {"reverse", "0"},
                                                    {"grad_centr", "0"},
                                                    {"stride_x", ""},
                                                    {"stride_y", ""}});

/// The keys that `section` may hold and that mean something to Tapestry.
[[nodiscard]] inline std::vector<std::string_view> understood_keys(std::string_view section) {
  if (section == "net" || section == "network") return {"width", "height", "channels"};
  if (section == "convolutional" || section == "conv") {
    return {"filters",  "size",   "stride",          "pad",       "padding",
            "dilation", "groups", "batch_normalize", "activation"};
  }
  if (section == "maxpool" || section == "max") return {"size", "stride", "padding"};
  if (section == "upsample") return {"stride"};
  if (section == "route") return {"layers", "groups", "group_id"};
  if (section == "shortcut") return {"from", "activation"};
  if (section == "yolo") return {"mask", "anchors", "classes", "num", "scale_x_y", "new_coords"};
  if (section == "softmax") return {"groups", "temperature"};
  return {};
}

/// An option given twice is an error where it means something, else a warning.
inline void check_repeated_options(const std::string& path, SectionReader& reader,
                                   std::vector<std::string>& warnings) {
  const auto& options = reader.section().options;
  for (std::size_t i = 0; i < options.size(); ++i) {
    const auto earlier = std::find_if(options.begin(), options.begin() + static_cast<std::ptrdiff_t>(i),
                                      [&](const CfgOption& option) { return option.key == options[i].key; });
    if (earlier == options.begin() + static_cast<std::ptrdiff_t>(i)) continue;
    const std::string what = "option " + in_quotes(options[i].key) + " given twice in one section";
    if (std::ranges::find(ignored_cfg_keys, options[i].key) == ignored_cfg_keys.end()) {
      throw cfg_error(path, options[i].line, what, "one value",
                      "another on line " + std::to_string(earlier->line));
    }
    if (warnings.size() < 100) warnings.push_back(path + ":" + std::to_string(options[i].line) + ": " + what);
  }
}

/// Looks at the options that nobody asked for: those that would change the result are errors, those that
/// are not known at all become warnings with the nearest known key.
inline void check_leftover_options(const std::string& path, SectionReader& reader,
                                   std::vector<std::string>& warnings) {
  for (const CfgOption& option : reader.section().options) {
    if (option.asked_for || std::ranges::find(ignored_cfg_keys, option.key) != ignored_cfg_keys.end())
      continue;
    const auto unsupported = std::ranges::find_if(
        unsupported_cfg_keys, [&](const auto& key_and_value) { return key_and_value[0] == option.key; });
    if (unsupported != unsupported_cfg_keys.end()) {
      if ((*unsupported)[1] == option.value) continue;
      throw reader.error(option, "unsupported option " + in_quotes(option.key), "none, or its neutral value",
                         in_quotes(option.value));
    }
    std::string_view nearest;
    std::size_t distance = 4;  // anything farther is no misspelling
    for (const std::string_view key : understood_keys(reader.name())) {
      const std::size_t d = edit_distance(key, option.key);
      if (d < distance) {
        distance = d;
        nearest = key;
      }
    }
    std::string warning = path + ":" + std::to_string(option.line) + ": unknown option " +
                          in_quotes(option.key) + " of [" + std::string(reader.name()) + "] ignored";
    if (!nearest.empty()) warning += "; did you mean " + in_quotes(nearest) + "?";
    if (warnings.size() < 100) warnings.push_back(warning);
  }
}

}  // namespace tapestry::detect::detail
