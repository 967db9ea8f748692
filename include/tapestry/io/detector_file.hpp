#pragma once
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
/// Reads from JSON how a detector takes pictures and what its outputs mean, for example
///
///  {"input": {"order": "bgr", "scale": 1, "mean": [103.53, 116.28, 123.675],
///             "std": [57.375, 57.12, 58.395], "fit": "stretch"},
///   "head": "nanodet", "strides": [8, 16, 32]}
///
///
/// order is rgb or bgr; scale, mean and std are those of detect::InputEncoding; fit is a name of
/// image::FitKind, and fill, 0 to 255, the value around a letterboxed picture; head is a name of
/// detect::HeadKind; strides are pixels between cells. Heads with anchors require "anchors", one list for
/// each stride, with widths and heights in turn, as YOLOv5 writes them: "anchors": [[10, 13, 16, 30, 33, 23],
/// ...]; yolov5 may leave out strides and anchors. boxes_and_scores and end_to_end have "outputs" instead.
/// The first word of each choice is the default, see detect::DecodedOutputs:
///
///   {"head": "boxes_and_scores", "outputs": {"boxes": NAME, "scores": NAME, "channels": last or first,
///    "form": centre, corners or corners_yx, "unit": pixels, share or [width, height] of the picture whose
///    pixels they are, "objectness": no or yes, "score": probability, logit or softmax, "background": none,
///    first or last, "boxes_of": candidate or class, "candidates": 1000}}
///
/// end_to_end is for one output of left, top, right, bottom, score and class of each candidate, or, with
/// "boxes", "scores" and "labels" instead of "detections", for three. It has no default for the number of
/// classes:
///
///   {"head": "end_to_end", "outputs": {"detections": NAME, "classes": K, "channels": last or first,
///    "form": corners, corners_yx or centre, "unit": as above, "score": probability or logit,
///    "candidates": 1000}}
///
/// Other missing keys have the default of detect::DetectorDescription; a missing fill has the default of its
/// fit. Compiled in tapestry/implementation.hpp.
///
/// \param text  the whole text
/// \param path      the file's name, for messages
/// \param warnings  receives what is assumed of the input where no 'input' describes it, unless null; of
///                  yolov5 everything is known
/// \throws FileError  malformed, with the key and the byte, for unknown keys and for values of another type
///                  or out of range; as read_json()
[[nodiscard]] detect::DetectorDescription parse_detector_description(
    std::string_view text, const std::string& path, std::vector<std::string>* warnings = nullptr);

/// Reads such a JSON file of at most 64 KiB; errors as parse_detector_description() and read_text_file().
/// Takes memory of at most 48 times the file and 1 MiB.
[[nodiscard]] inline detect::DetectorDescription read_detector_description(
    const std::string& path, std::vector<std::string>* warnings = nullptr) {
  return parse_detector_description(read_text_file(path, std::uint64_t(1) << 16U), path, warnings);
}

/// Metadata of an ONNX model that was made of a Darknet detector. Together with the constants of
/// detect::network_description() they are the cfg and the weights again.
struct DetectorMetadata {
  std::string cfg;                   ///< text of the Darknet cfg file, whole and unchanged
  std::uint64_t images_seen = 0;     ///< in training
  bool is_folded = false;            ///< batch normalisation is part of the weights
  double batch_norm_epsilon = 1e-5;  ///< inside the root; for a folded detector, the one used in folding
  detect::DecodeFamily decode = detect::DecodeFamily::darknet;  ///< stored only here
};

/// The metadata as fields of a model. Numbers are the shortest decimals that read back the same.
[[nodiscard]] std::map<std::string, std::string> fields_of(const DetectorMetadata& metadata);

/// The reverse of fields_of(); other fields are ignored.
/// \throws FileError  mismatch for a field that is missing or has an unsupported value, malformed for an
///                  invalid field or a cfg that does not match its hash
[[nodiscard]] DetectorMetadata parse_detector_metadata(const std::map<std::string, std::string>& fields,
                                                       const std::string& path);

/// Whether an ONNX model was made of a Darknet detector, by write_detector_file().
[[nodiscard]] bool is_of_darknet(const nn::NetworkDescription& network);

/// The given cfg with the epsilon and the decode family of the metadata, and without batch normalisation if
/// that has been folded.
/// \throws FileError (mismatch) if the decode family contradicts the cfg, see detect::with_decode()
[[nodiscard]] detect::NetworkConfig adapted(detect::NetworkConfig config, const DetectorMetadata& metadata);

/// Writes a Darknet detector as an ONNX model, or leaves the old file as it was. Its nodes compute the raw
/// logits of the heads from "picture", RGB in [0, 1]; its metadata are fields_of(). The same arguments give
/// the same bytes.
///
/// \param model  of the cfg, or with folded batch normalisation, see detect::fold_batch_norm()
/// \param cfg    text of the cfg
/// \returns      the number of nodes
/// \throws FileError  for the cfg as parse_network_config() does, and malformed unless it is UTF-8; write
/// \throws ShapeError unless the model has as many parameters as the cfg needs
std::size_t write_detector_file(const std::string& path, const detect::DarknetModel<float>& model,
                                const std::string& cfg);
}  // namespace tapestry::io
