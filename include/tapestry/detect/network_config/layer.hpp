#pragma once
#include <tapestry/core/compiled.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/nn/activation.hpp>

namespace tapestry::detect {
enum class LayerKind {
  convolutional,
  maxpool,
  upsample,
  route,
  shortcut,
  yolo,
  avgpool,
  softmax,
  dropout,
  reorg,
  reorg3d,
  region,
  scale_channels,
  sam
};

/// The section name of a layer.
[[nodiscard]] constexpr std::string_view name_of(LayerKind kind) {
  constexpr std::array<std::string_view, 14> names = {
      "convolutional", "maxpool", "upsample", "route",   "shortcut", "yolo",           "avgpool",
      "softmax",       "dropout", "reorg",    "reorg3d", "region",   "scale_channels", "sam"};
  return names[static_cast<std::size_t>(kind)];
}

/// Whether a layer is a head, which turns its input into candidates: [yolo], or YOLOv2's [region].
[[nodiscard]] constexpr bool is_head(LayerKind kind) {
  return kind == LayerKind::yolo || kind == LayerKind::region;
}

/// One layer of a cfg file. Members that a kind does not use keep their defaults.
struct LayerConfig {
  LayerKind kind = LayerKind::convolutional;
  std::size_t line = 0;  ///< of its section header, from 1

  /// Layers whose output it reads, as indices from 0; empty: the layer before it (or the image).
  std::vector<std::size_t> sources{};

  std::size_t filters = 1;  ///< convolutional
  std::size_t size = 1;     ///< convolutional, maxpool: window edge
  std::size_t stride = 1;   ///< convolutional, maxpool, reorg, reorg3d; upsample: the factor
  std::size_t padding = 0;  ///< convolutional: rows of zeros on each side; maxpool: both sides together
  std::size_t dilation = 1;
  std::size_t groups = 1;  ///< convolutional, softmax; route: parts that each source's channels are cut into
  std::size_t group = 0;   ///< route: the part that is taken
  bool scale_wh = false;   ///< scale_channels: a factor for each pixel instead of each channel
  bool batch_normalize = false;
  nn::Activation activation = nn::Activation::linear;
  double temperature = 1;  ///< softmax
  double scale = 1;        ///< upsample: factor of the values

  std::size_t classes = 0;  ///< yolo, region
  std::vector<std::array<double, 2>>
      anchors{};  ///< width and height of this head's; yolo: in pixels of the input, region: in cells
  bool exclusive_classes = false;               ///< region: softmax over the classes
  double scale_x_y = 1;                         ///< yolo
  std::optional<double> beta_nms{};             ///< yolo: of nms_kind=diounms, see SuppressionMeasure
  DecodeFamily decode = DecodeFamily::darknet;  ///< yolo
};

/// A parsed cfg file: the input's size and the layers in order. Every index in it has been checked.
struct NetworkConfig {
  std::string name;          ///< path of the file, for messages
  std::size_t line = 0;      ///< of [net]
  std::size_t height = 416;  ///< of the input
  std::size_t width = 416;
  std::size_t channels = 3;
  std::optional<bool> letter_box{};  ///< AlexeyAB's option, where the cfg has it; see fit_of()
  std::vector<LayerConfig> layers{};

  /// Added to variances inside the root. It is not part of a cfg file but of the program that runs it: 1e-5
  /// in AlexeyAB's Darknet and in Darknet on GPUs, 1e-6 in OpenCV; Darknet on a CPU adds 1e-6 to the root.
  double batch_norm_epsilon = 1e-5;
  std::vector<std::string> warnings{};  ///< options that were not understood, one message each
};

/// Inputs of the layer at `index`: its sources, or the layer before; empty means the image.
[[nodiscard]] std::vector<std::size_t> inputs_of(const NetworkConfig& config, std::size_t index);

inline constexpr std::size_t picture_value = static_cast<std::size_t>(-1);

/// For each layer the one that computes its value: itself or, for a layer that only passes something on
/// (dropout, a head, a route of one whole layer), the one it passes on; picture_value for the picture.
[[nodiscard]] std::vector<std::size_t> makers_of_values(const NetworkConfig& config);

/// An error in a description, on a line of the file that it was read from.
[[nodiscard]] inline FileError cfg_error(const std::string& path, std::size_t line, const std::string& what,
                                         const std::string& expected = "", const std::string& found = "",
                                         ErrorKind kind = ErrorKind::malformed) {
  return FileError(kind, {path, std::to_string(line), what, expected, found});
}
}  // namespace tapestry::detect
