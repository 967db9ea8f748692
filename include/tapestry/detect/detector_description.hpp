#pragma once
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/image/letterbox.hpp>

namespace tapestry::detect {
/// Colour of a network's first input channel.
enum class ColourOrder { rgb, bgr };

/// Encoding of a picture's colours for a network. With a picture in [0, 1] and d_c the deviation,
///
///   input channel c = (255 · scale · (colour that order puts at c) − mean_c) / d_c
///
/// so that scale 1/255 is for networks that were trained on [0, 1] and scale 1 for those on 0 to 255.
struct InputEncoding {
  ColourOrder order = ColourOrder::rgb;
  double scale = 1.0 / 255;
  std::array<double, 3> mean{0, 0, 0};       ///< by input channel
  std::array<double, 3> deviation{1, 1, 1};  ///< by input channel, above 0

  /// The channel of an RGB picture that belongs to input channel c.
  [[nodiscard]] std::size_t picture_channel(std::size_t c) const {
    return order == ColourOrder::rgb ? c : 2 - c;
  }
  bool operator==(const InputEncoding&) const = default;
};

/// RGB in [0, 1], normalised by mean and deviation of ImageNet's colours, as torchvision states them.
inline constexpr InputEncoding imagenet_encoding{
    ColourOrder::rgb, 1.0 / 255, {0.485, 0.456, 0.406}, {0.229, 0.224, 0.225}};

/// Encodes pixels for a network.
/// \param pictures  [pixel, 3], RGB in [0, 1]
/// \param input     takes as many
template <std::floating_point T>
void encode(const T* pictures, std::size_t pixel_count, const InputEncoding& encoding, T* input);

/// Adds the pullback of encode() to pictures_adjoint, [pixel, 3].
template <std::floating_point T>
void encode_adjoint(const T* input_adjoint, std::size_t pixel_count, const InputEncoding& encoding,
                    T* pictures_adjoint);

/// Encodes pictures for a network.
/// \param pictures  [N, H, W, 3], RGB in [0, 1]
/// \returns         [N, H, W, 3]
/// \throws ShapeError unless the pictures have three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 4> encoded(const Array<T, 4>& pictures, const InputEncoding& encoding);

/// Adds the pullback of encoded() to pictures_adjoint; both are [N, H, W, 3].
/// \throws ShapeError unless they are of one shape with three channels
template <std::floating_point T>
void encoded_adjoint(const Array<T, 4>& input_adjoint, const InputEncoding& encoding,
                     Array<T, 4>& pictures_adjoint);

/// encoded() of pictures on the tape; its pullback is encoded_adjoint(). Errors as there.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures, const InputEncoding& encoding);

/// The heads of known detectors: a decode family, and the other members of Head that all of them share.
///
///   yolox    the decode family yolox
///   nanodet  the decode family distance, 8 bins, classes first: NanoDet-m
///   yolov8   the decode family distance, 16 bins, box first: YOLOv8 and its successors
///   yolov5   the decode family ultralytics, with YOLOv5's anchors for COCO unless there are others
///   boxes_and_scores  the decode family decoded, for an export that contains the decoding
///   end_to_end        likewise, of candidates [left, top, right, bottom, score, class]: YOLOv10 and other
///                     exports that choose the class themselves
///
/// darknet and ultralytics are their decode families, with the anchors of a cfg or a description.
enum class HeadKind { darknet, ultralytics, yolox, nanodet, yolov8, yolov5, boxes_and_scores, end_to_end };

inline constexpr std::array<HeadKind, 8> head_kinds{
    HeadKind::darknet, HeadKind::ultralytics,      HeadKind::yolox,     HeadKind::nanodet, HeadKind::yolov8,
    HeadKind::yolov5,  HeadKind::boxes_and_scores, HeadKind::end_to_end};
/// The kinds by name, for messages.
inline constexpr std::string_view head_kind_names =
    "darknet, ultralytics, yolox, nanodet, yolov8, yolov5, boxes_and_scores or end_to_end";

[[nodiscard]] constexpr std::string_view name_of(HeadKind kind) {
  constexpr std::array<std::string_view, 8> names{
      "darknet", "ultralytics", "yolox", "nanodet", "yolov8", "yolov5", "boxes_and_scores", "end_to_end"};
  return names[static_cast<std::size_t>(kind)];
}

/// \throws DomainError, naming all of them, for a name that no kind has
[[nodiscard]] HeadKind head_kind_by_name(std::string_view name);

[[nodiscard]] constexpr DecodeFamily decode_family_of(HeadKind kind) {
  if (kind == HeadKind::darknet) return DecodeFamily::darknet;
  if (kind == HeadKind::ultralytics || kind == HeadKind::yolov5) return DecodeFamily::ultralytics;
  if (kind == HeadKind::boxes_and_scores || kind == HeadKind::end_to_end) return DecodeFamily::decoded;
  return kind == HeadKind::yolox ? DecodeFamily::yolox : DecodeFamily::distance;
}

/// The facts that a network's file leaves open: how a picture goes in, and how its outputs become boxes.
struct DetectorDescription {
  InputEncoding encoding{};
  image::Fit fit{};
  HeadKind head = HeadKind::darknet;
  std::vector<std::size_t> strides{};  ///< pixels between cells, of each head in the order of the outputs
  /// Anchors of each head that has some, as Head::anchors.
  std::vector<std::vector<std::array<double, 2>>> anchors{};
  DecodedOutputs decoded{};  ///< only for the decode family decoded

  bool operator==(const DetectorDescription&) const = default;
};

/// The description of a detector that is known by name. yolox: as Megvii's YOLOX takes its pictures since
/// version 0.1.1; nanodet: NanoDet-m; picodet: PP-PicoDet with its four grids, in nanodet's form; yolov5: the
/// models n to x of three grids. Sources: Ge et al., "YOLOX" (2021) and its program; Yu et al., "PP-PicoDet"
/// (2021); the configurations of NanoDet-m, PicoDet and of YOLOv5, version 6, from which the anchors are.
/// \throws DomainError for any other name
[[nodiscard]] DetectorDescription known_description(std::string_view name);

/// The heads of a description, for an input of the given extents: for each stride s one with ⌈height / s⌉ ×
/// ⌈width / s⌉ cells. None for the decode family decoded, which has no strides.
///
/// \param classes  K
/// \throws DomainError for a stride of 0, for heads with anchors unless each stride has some, and for anchors
///         of heads that take none
[[nodiscard]] std::vector<Head> heads_of(const DetectorDescription& description, std::size_t classes,
                                         std::size_t input_height, std::size_t input_width);

/// K, computed from the number of channels of the first head.
/// \throws ShapeError if the channels leave no class, or not as many for each anchor; DomainError as
/// heads_of()
[[nodiscard]] std::size_t class_count_of(const DetectorDescription& description, std::size_t channels);
}  // namespace tapestry::detect
