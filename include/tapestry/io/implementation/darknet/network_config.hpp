#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/darknet/layer_parsing.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {
namespace detail {
/// Options of any section for Darknet's training of its layer, with spaces between.
inline constexpr std::string_view layer_training_keys =
    "stopbackward onlyforward train_only_bn learning_rate learning_rate_scale";

/// Options of one section that concern Darknet's training or drawing and do not change what the network
/// computes. The same key may have another meaning in another section: `scale` of [net] scales the learning
/// rate, that of [upsample] the values.
[[nodiscard]] inline std::string_view training_keys(std::string_view section) {
  if (section == "net" || section == "network")
    return "batch subdivisions momentum decay angle aspect saturation exposure hue "
           "learning_rate learning_rate_min burn_in burnin_power max_batches policy steps "
           "scales scale step num_steps gamma power time_steps notruth random adam B1 B2 "
           "eps max_crop min_crop max_ratio min_ratio center flip blur mixup cutmix mosaic "
           "mosaic_bound gaussian_noise label_smooth_eps dynamic_minibatch optimized_memory "
           "workspace_size_limit_MB track augment_speed sgdr_cycle sgdr_mult loss_scale "
           "cudnn_half ema_alpha weights_reject_freq equidistant_point";
  if (section == "yolo")
    return "random jitter resize ignore_thresh truth_thresh iou_thresh iou_normalizer "
           "cls_normalizer obj_normalizer delta_normalizer iou_loss iou_thresh_kind "
           "nms_kind beta_nms max max_delta map counters_per_class focal_loss "
           "objectness_smooth label_smooth_eps";
  if (section == "region")
    return "jitter random max log sqrt rescore thresh classfix absolute bias_match "
           "coord_scale object_scale noobject_scale mask_scale class_scale";
  if (section == "dropout") return "probability dropblock dropblock_size_rel dropblock_size_abs";
  return {};
}

[[nodiscard]] inline bool is_training_key(std::string_view section, std::string_view key) {
  return is_word_of(layer_training_keys, key) || is_word_of(training_keys(section), key);
}

/// Options that change the result and that Tapestry does not implement, after their harmless value.
inline constexpr std::array<std::array<std::string_view, 2>, 3> unsupported_cfg_keys{
    {{"0",
      "binary xnor bin_output flipped dot antialiasing assisted_excitation stretch stretch_sway rotate "
      "deform sway maxpool_depth avgpool cbn spatial reverse flatten extra background grad_centr"},
     {"none", "weights_type weights_normalization"},
     {"", "share_index embedding_layer tree map stride_x stride_y"}}};

/// The keys that `section` may hold and that Tapestry uses.
[[nodiscard]] inline std::vector<std::string_view> understood_keys(std::string_view section) {
  if (section == "net" || section == "network") return {"width", "height", "channels", "letter_box"};
  if (section == "convolutional" || section == "conv")
    return {"filters",  "size",   "stride",          "pad",       "padding",
            "dilation", "groups", "batch_normalize", "activation"};
  if (section == "maxpool" || section == "max") return {"size", "stride", "padding"};
  if (section == "upsample") return {"stride", "scale"};
  if (section == "route") return {"layers", "groups", "group_id"};
  if (section == "shortcut") return {"from", "activation"};
  if (section == "yolo") return {"mask", "anchors", "classes", "num", "scale_x_y", "new_coords"};
  if (section == "region") return {"anchors", "classes", "num", "coords", "softmax"};
  if (section == "reorg" || section == "reorg3d") return {"stride"};
  if (section == "scale_channels") return {"from", "scale_wh", "activation"};
  if (section == "sam") return {"from", "activation"};
  if (section == "softmax") return {"groups", "temperature"};
  return {};
}

/// Adds a warning, unless there are 100 already.
inline void add_cfg_warning(std::vector<std::string>& warnings, const std::string& path, std::size_t line,
                            const std::string& what) {
  if (warnings.size() < 100) warnings.push_back(path + ":" + std::to_string(line) + ": " + what);
}

/// Checks for options given twice: an error if Tapestry uses the option, else a warning.
inline void check_repeated_options(const std::string& path, SectionReader& reader,
                                   std::vector<std::string>& warnings) {
  std::map<std::string_view, std::size_t> lines;  // of the first option of each key
  for (const CfgOption& option : reader.section().options) {
    const auto [first, is_new] = lines.try_emplace(option.key, option.line);
    if (is_new) continue;
    const std::string what = "option " + in_quotes(option.key) + " given twice in one section";
    if (!is_training_key(reader.name(), option.key))
      throw cfg_error(path, option.line, what, "one value",
                      "another on line " + std::to_string(first->second));
    add_cfg_warning(warnings, path, option.line, what);
  }
}

/// The warning about an unknown option; it names the nearest known key.
[[nodiscard]] inline std::string unknown_option(std::string_view section, std::string_view unknown) {
  const std::string nearest = nearest_word(unknown, understood_keys(section));
  std::string text = "unknown option " + in_quotes(unknown) + " of [" + std::string(section) + "] ignored";
  if (!nearest.empty()) text += "; did you mean " + in_quotes(nearest) + "?";
  return text;
}

/// Checks the options that were never read. Keys that would change the result are errors; unknown keys bring
/// warnings.
inline void check_leftover_options(const std::string& path, SectionReader& reader,
                                   std::vector<std::string>& warnings) {
  for (const CfgOption& option : reader.section().options) {
    if (option.key == "nms_kind" && option.value != "greedynms" && option.value != "default" &&
        option.value != "diounms")
      add_cfg_warning(warnings, path, option.line,
                      "nms_kind=" + std::string(option.value.substr(0, 40)) +
                          " is not obeyed; boxes are suppressed by their IoU (greedynms)");
    if (option.asked_for) continue;
    if (is_training_key(reader.name(), option.key)) continue;
    const auto unsupported = std::ranges::find_if(unsupported_cfg_keys, [&](const auto& value_and_keys) {
      return is_word_of(value_and_keys[1], option.key);
    });
    if (unsupported == unsupported_cfg_keys.end()) {
      if (warnings.size() < 100)
        add_cfg_warning(warnings, path, option.line, unknown_option(reader.name(), option.key));
      continue;
    }
    if ((*unsupported)[0] == option.value) continue;
    throw reader.error(option, "unsupported option " + in_quotes(option.key), "none, or its neutral value",
                       in_quotes(option.value));
  }
}

inline void parse_net(SectionReader& reader, detect::NetworkConfig& config) {
  config.line = reader.line();
  config.width = reader.count("width", config.width, 1, 16384);
  config.height = reader.count("height", config.height, 1, 16384);
  config.channels = reader.count("channels", config.channels, 1, 1 << 20);
  if (config.channels != 3)
    throw reader.error(*reader.find("channels"), "the network is fed with colour pictures", "channels=3",
                       std::to_string(config.channels), ErrorKind::mismatch);
  if (reader.find("letter_box") != nullptr)
    config.letter_box = reader.integer("letter_box", 0, 0, 1, ErrorKind::malformed) != 0;
}

detect::NetworkConfig parse_cfg(std::string_view text, const std::string& name) {
  auto sections = cfg_sections(text, name);
  if (sections.empty()) throw detect::cfg_error(name, 1, "no [net] section", "a Darknet cfg file");
  detect::NetworkConfig config;
  config.name = name;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const bool is_net = sections[i].name == "net" || sections[i].name == "network";
    if (is_net != (i == 0))
      throw detect::cfg_error(name, sections[i].line, i == 0 ? "no [net] section" : "a second [net] section",
                              i == 0 ? "[net] first" : "one",
                              "[" + std::string(sections[i].name.substr(0, 40)) + "]");
    SectionReader reader(name, sections[i]);
    check_repeated_options(name, reader, config.warnings);
    if (is_net) {
      parse_net(reader, config);
    } else {
      config.layers.push_back(parse_layer(name, reader, i - 1));
    }
    check_leftover_options(name, reader, config.warnings);
  }
  return config;
}
}  // namespace detail

detect::NetworkConfig parse_network_config(std::string_view text, const std::string& name) {
  auto config = detail::parse_cfg(text, name);
  detect::check_network(config);
  return config;
}

detect::NetworkConfig parse_classifier_config(std::string_view text, const std::string& name) {
  auto config = detail::parse_cfg(text, name);
  detect::check_classifier(config);
  return config;
}
}  // namespace tapestry::io
