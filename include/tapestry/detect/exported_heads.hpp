#pragma once
#include <tapestry/detect/detector_description.hpp>

namespace tapestry::detect {
/// Names the convolutions behind an exported detector's outputs, before rearranging and before the logistic
/// function. Losses need them: where that function rounds to 1 no slope is left. Found by going back from the
/// outputs through operators that only rearrange values; in the order of joining there.
[[nodiscard]] std::vector<std::string> raw_outputs(const nn::NetworkDescription& description);

/// The last value that all these values depend on. For raw outputs it is the last single layer that all heads
/// depend on. Empty if there is none.
[[nodiscard]] std::string common_layer(const nn::NetworkDescription& description,
                                       const std::vector<std::string>& outputs);

/// The last layer that all heads of a detector depend on: of raw outputs, or of the last convolutions before
/// decoded ones. Empty if there is none.
[[nodiscard]] std::string common_layer(const nn::NetworkDescription& network,
                                       const DetectorDescription& kind);

/// Compares a description with what a network computes: the filters of its last convolutions, the channels
/// that it takes the logistic function of, anchors that it multiplies by, and whether scores are logits.
/// \throws FileError (mismatch) naming what heads of this kind need, and what was found
void require_layers_of(const nn::NetworkDescription& network, const DetectorDescription& kind);

/// The description of a known detector, recognised by the filters of its raw outputs:
///
///   yolox    three convolutions on each of three grids, of 4, 1 and K filters
///   nanodet  on each of three grids either one convolution of K + 32 filters, with K classes and 32 bins in
///            outputs of their own, or two of K and 32
///
/// Exports of other detectors may look alike; a description by hand takes precedence.
[[nodiscard]] std::optional<DetectorDescription> recognised_detector(const nn::NetworkDescription& network);

/// Families of exports whose description follows from a network's nodes, see named_export().
inline constexpr std::array<std::string_view, 9> export_names{
    "yolox", "nanodet", "picodet", "yolov5", "yolov8", "end_to_end", "torchvision", "detr", "rt_detr"};

[[nodiscard]] bool is_export_name(std::string_view name);

/// Extents of a network's only input, a picture, by its name: [1, 3, H, W] or [3, H, W].
/// \param size  side of a square input, pixels; 0: the network's own
/// \throws FileError (mismatch) for other inputs, or an open size
[[nodiscard]] std::map<std::string, nn::Shape> picture_extents(const nn::NetworkDescription& network,
                                                               std::size_t size);

/// The description of an export by the name of its family:
///
///   yolox, nanodet, picodet  known_description()
///   yolov5          likewise of its three convolutions, with the anchors that the network multiplies by
///                   where it decodes them; where these convolutions cannot be found, of its output,
///                   [1, N, 5 + K]
///   yolov8          YOLOv8, 9, 11, 12: of the convolutions; where the network decodes them, of its output,
///                   [1, 4 + K, N], with the logits before its logistic function if they are there
///   end_to_end      YOLOv10 and others of one output, [1, N, 6]: left, top, right, bottom, score, class
///   torchvision     Faster and Mask R-CNN, SSD: logits and boxes of all candidates before suppression; the
///                   classes are torchvision's without the background, which is their label 0. RetinaNet,
///                   FCOS: candidates above their threshold, with a class each, numbered as the labels are
///   detr            DETR, YOLOS: logits of a softmax whose last entry is the background, and boxes as shares
///                   of the picture, of the outputs that exporters call logits or pred_logits, and
///                   pred_boxes; else of the only outputs of a linear layer and of a logistic function
///   rt_detr         RT-DETR, D-FINE: likewise, with a logistic function for each class; they refine boxes
///                   from reference points
///
/// \param classes  K, for those whose network does not tell; 0: unknown
/// \param size     of the input, as of picture_extents()
/// \throws Error (usage) if K is needed and unknown; FileError (mismatch) if the nodes are not the family's;
///         DomainError for other names
[[nodiscard]] DetectorDescription named_export(const nn::NetworkDescription& network, std::string_view name,
                                               std::size_t classes, std::size_t size);

/// The names of families whose outputs and last layers a network has; see require_layers_of().
[[nodiscard]] std::vector<std::string_view> fitting_exports(const nn::NetworkDescription& network,
                                                            std::size_t size);

/// The name of the family that an export is certainly of, by its nodes: torchvision, or yolov8 where the
/// metadata are those of ultralytics, too. Empty otherwise.
[[nodiscard]] std::string_view recognised_export(const nn::NetworkDescription& network);

/// An output of a network that is a run of channels of a head's logits.
struct HeadPiece {
  std::size_t output = 0;  ///< of the network, [1, C, H, W]
  std::size_t head = 0;
  std::size_t first_channel = 0;  ///< within the head's logits
  std::size_t size = 0;           ///< values
};

/// The heads that a network's raw outputs form.
struct ExportedHeads {
  std::vector<Head> heads{};
  std::vector<HeadPiece> pieces{};
};

/// Puts together the heads of a network's raw outputs: outputs of one grid form one head, one after another.
///
/// \param path    of the network, for messages
/// \param shapes  of the outputs, each [1, C, H, W]
/// \param labels  of the nodes that make them, for messages
/// \throws FileError (mismatch) if they do not fit detectors of this kind
[[nodiscard]] ExportedHeads exported_heads(const std::string& path, const DetectorDescription& kind,
                                           const std::vector<nn::Shape>& shapes,
                                           const std::vector<std::string>& labels, std::size_t input_height,
                                           std::size_t input_width);
}  // namespace tapestry::detect
