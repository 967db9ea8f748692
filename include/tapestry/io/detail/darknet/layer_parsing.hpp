#pragma once
#include <tapestry/io/detail/darknet/section.hpp>

namespace tapestry::io::detail {
inline constexpr std::int64_t any_count = std::int64_t(1) << 31U;

[[nodiscard]] inline nn::Activation parse_activation(SectionReader& reader, nn::Activation fallback) {
  const CfgOption* option = reader.find("activation");
  if (option == nullptr) return fallback;
  for (const auto activation : nn::activations) {
    if (nn::name_of(activation) == option->value) return activation;
  }
  if (option->value == "silu") return nn::Activation::swish;  // two names of x·σ(x)
  throw reader.error(*option, "unsupported activation", std::string(nn::activation_names),
                     in_quotes(option->value));
}

/// Turns the entries of "layers" or "from" into indices of earlier layers: negative ones count back from
/// the layer itself.
[[nodiscard]] inline std::vector<std::size_t> parse_sources(SectionReader& reader, std::string_view key,
                                                            std::size_t index) {
  const auto entries = reader.list<std::int64_t>(key);
  const CfgOption& option = *reader.find(key);
  if (entries.size() > 64) throw reader.error(option, "too many layers in one list", "at most 64");
  std::vector<std::size_t> sources;
  const auto own = static_cast<std::int64_t>(index);
  for (const std::int64_t entry : entries) {
    const bool representable = entry >= -any_count && entry <= any_count;
    const std::int64_t source = !representable ? -1 : entry < 0 ? own + entry : entry;
    if (source < 0 || source >= own)
      throw reader.error(
          option, "layer " + std::to_string(index) + " reads from a layer that is not before it",
          own == 0 ? "no [" + std::string(reader.name()) + "] first"
                   : "0 to " + std::to_string(own - 1) + ", or " + std::to_string(-own) + " to -1",
          std::to_string(entry), ErrorKind::mismatch);
    sources.push_back(static_cast<std::size_t>(source));
  }
  return sources;
}

inline void parse_convolutional(SectionReader& reader, detect::LayerConfig& layer) {
  layer.filters = reader.count("filters", 1, 1, 1 << 20);
  layer.size = reader.count("size", 1, 1, 63, ErrorKind::malformed);
  if (layer.size % 2 == 0)
    throw reader.error(*reader.find("size"), "even filter size", "an odd number", std::to_string(layer.size));
  layer.stride = reader.count("stride", 1, 1, 16384, ErrorKind::malformed);
  layer.dilation = reader.count("dilation", 1, 1, 1024, ErrorKind::malformed);
  layer.groups = reader.count("groups", 1, 1, 1 << 20);
  layer.padding = reader.count("padding", 0, 0, 63, ErrorKind::malformed);
  if (reader.integer("pad", 0, 0, 63, ErrorKind::malformed) != 0) layer.padding = layer.size / 2;
  layer.padding *= layer.dilation;
  layer.batch_normalize = reader.integer("batch_normalize", 0, 0, 1, ErrorKind::malformed) != 0;
  layer.activation = parse_activation(reader, nn::Activation::logistic);  // Darknet's default
}

inline void parse_maxpool(SectionReader& reader, detect::LayerConfig& layer) {
  layer.stride = reader.count("stride", 1, 1, 16384, ErrorKind::malformed);
  layer.size = reader.count("size", layer.stride, 1, 255, ErrorKind::malformed);
  layer.padding = reader.count("padding", layer.size - 1, 0, 255, ErrorKind::malformed);
  if (layer.padding - layer.padding / 2 >= layer.size)
    throw reader.error(*reader.find("padding"), "padding of more than the window on a side");
}

inline void parse_route(SectionReader& reader, std::size_t index, detect::LayerConfig& layer) {
  layer.sources = parse_sources(reader, "layers", index);
  layer.groups = reader.count("groups", 1, 1, 1 << 20);
  layer.group = reader.count("group_id", 0, 0, any_count);
  if (layer.group >= layer.groups)
    throw reader.error(*reader.find("group_id"), "no such group", "0 to " + std::to_string(layer.groups - 1),
                       std::to_string(layer.group), ErrorKind::mismatch);
}

/// All anchors of a [yolo] section, before its mask picks some, or of a [region].
[[nodiscard]] inline std::vector<std::array<double, 2>> parse_anchors(SectionReader& reader,
                                                                      std::size_t count) {
  const auto numbers = reader.list<double>("anchors");
  const CfgOption& option = *reader.find("anchors");
  if (numbers.size() != 2 * count)
    throw reader.error(option, "anchors do not match num=" + std::to_string(count),
                       std::to_string(2 * count) + " numbers", std::to_string(numbers.size()));
  std::vector<std::array<double, 2>> anchors;
  for (std::size_t i = 0; i < count; ++i) anchors.push_back({numbers[2 * i], numbers[2 * i + 1]});
  for (const double number : numbers) {
    if (!(number > 0) || number > 1e6)
      throw reader.error(option, "anchor out of range", "above 0 and at most 1e6");
  }
  return anchors;
}

inline void parse_yolo(SectionReader& reader, detect::LayerConfig& layer) {
  layer.classes = reader.count("classes", 20, 1, 1 << 20);
  layer.scale_x_y = reader.real("scale_x_y", 1);
  if (!(layer.scale_x_y >= 1) || layer.scale_x_y > 4)
    throw reader.error(*reader.find("scale_x_y"), "scale_x_y out of range", "1 to 4");
  if (reader.integer("new_coords", 0, 0, 1, ErrorKind::malformed) != 0)
    layer.decode = detect::DecodeFamily::scaled;
  if (reader.text("nms_kind", "") == "diounms") {
    layer.beta_nms = reader.real("beta_nms", 0.6);  // Darknet's default
    if (!(*layer.beta_nms > 0)) throw reader.error(*reader.find("beta_nms"), "beta_nms not above 0");
  }
  const auto anchors = parse_anchors(reader, reader.count("num", 1, 1, 256));
  if (reader.find("mask") == nullptr) {
    layer.anchors = anchors;
    return;
  }
  const auto mask = reader.list<std::int64_t>("mask");
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] < 0 || mask[i] >= static_cast<std::int64_t>(anchors.size()) ||
        (i > 0 && mask[i] <= mask[i - 1])) {
      throw reader.error(*reader.find("mask"), "mask entry " + std::to_string(mask[i]),
                         "ascending indices from 0 to " + std::to_string(anchors.size() - 1), "",
                         ErrorKind::mismatch);
    }
    layer.anchors.push_back(anchors[static_cast<std::size_t>(mask[i])]);
  }
}

/// A layer that adds the values of others to its input, or multiplies it by those of one.
inline void parse_combination(SectionReader& reader, std::size_t index, detect::LayerConfig& layer) {
  layer.sources = parse_sources(reader, "from", index);
  if (layer.kind != detect::LayerKind::shortcut && layer.sources.size() != 1)
    throw reader.error(*reader.find("from"), "too many layers to multiply", "one",
                       std::to_string(layer.sources.size()));
  if (layer.kind == detect::LayerKind::scale_channels)
    layer.scale_wh = reader.integer("scale_wh", 0, 0, 1, ErrorKind::malformed) != 0;
  layer.activation = parse_activation(reader, nn::Activation::linear);
}

/// YOLOv2's head, with boxes only: keys for a background class, a tree of classes or masks are refused.
inline void parse_region(SectionReader& reader, detect::LayerConfig& layer) {
  layer.classes = reader.count("classes", 20, 1, 1 << 20);
  if (const auto coords = reader.integer("coords", 4, 0, any_count); coords != 4)
    throw reader.error(*reader.find("coords"), "unsupported coords", "4: a box", std::to_string(coords));
  layer.exclusive_classes = reader.integer("softmax", 0, 0, 1, ErrorKind::malformed) != 0;
  layer.anchors = parse_anchors(reader, reader.count("num", 1, 1, 256));
}

inline void parse_upsample(SectionReader& reader, detect::LayerConfig& layer) {
  layer.stride = reader.count("stride", 2, 1, 64, ErrorKind::malformed);
  layer.scale = reader.real("scale", 1);
  if (std::abs(layer.scale) > 1e6)
    throw reader.error(*reader.find("scale"), "scale out of range", "-1e6 to 1e6");
}

inline void parse_softmax(SectionReader& reader, detect::LayerConfig& layer) {
  layer.groups = reader.count("groups", 1, 1, 1 << 20);
  layer.temperature = reader.real("temperature", 1);
  if (!(layer.temperature > 0)) throw reader.error(*reader.find("temperature"), "temperature not above 0");
}

[[nodiscard]] inline FileError unsupported_section(const std::string& path, const SectionReader& reader) {
  return cfg_error(
      path, reader.line(), "unsupported section",
      "net, convolutional, maxpool, upsample, route, shortcut, scale_channels, sam, reorg, reorg3d, "
      "yolo, region, avgpool, softmax or dropout",
      "[" + std::string(reader.name().substr(0, 40)) + "]");
}

/// One layer from its section; `index` counts layers from 0.
[[nodiscard]] inline detect::LayerConfig parse_layer(const std::string& path, SectionReader& reader,
                                                     std::size_t index) {
  detect::LayerConfig layer;
  layer.line = reader.line();
  bool is_known = false;
  const auto is = [&](std::string_view name, detect::LayerKind kind) {
    if (name != reader.name()) return false;
    layer.kind = kind;
    return is_known = true;
  };
  using enum detect::LayerKind;
  if (is("convolutional", convolutional) || is("conv", convolutional)) parse_convolutional(reader, layer);
  if (is("maxpool", maxpool) || is("max", maxpool)) parse_maxpool(reader, layer);
  if (is("upsample", upsample)) parse_upsample(reader, layer);
  if (is("route", route)) parse_route(reader, index, layer);
  if (is("shortcut", shortcut) || is("scale_channels", scale_channels) || is("sam", sam))
    parse_combination(reader, index, layer);
  if (is("yolo", yolo)) parse_yolo(reader, layer);
  if (is("region", region)) parse_region(reader, layer);
  if (is("reorg", reorg) || is("reorg3d", reorg3d))
    layer.stride = reader.count("stride", 1, 1, 64, ErrorKind::malformed);
  if (is("softmax", softmax)) parse_softmax(reader, layer);
  static_cast<void>(is("avgpool", avgpool) || is("avg", avgpool) || is("dropout", dropout));
  if (!is_known) throw unsupported_section(path, reader);
  return layer;
}
}  // namespace tapestry::io::detail
