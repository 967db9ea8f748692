#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {

/// Reads how a detector takes pictures and what its outputs mean, from JSON such as
///
///   {"input": {"order": "bgr", "scale": 1, "mean": [103.53, 116.28, 123.675], "std":
///   [57.375, 57.12, 58.395],
///              "fit": "stretch"},
///    "head": "nanodet", "strides": [8, 16, 32]}
///
/// order is rgb or bgr; scale, mean and std are those of detect::InputEncoding; fit is a name of
/// image::FitKind, beside which fill, 0 to 255, may say what is around a letterboxed picture; head is a name
/// of detect::HeadKind; strides are pixels between cells. Heads with anchors need them, too, a list for each
/// stride of widths and heights in turn, as YOLOv5 writes them: "anchors": [[10, 13, 16, 30, 33, 23], ...];
/// yolov5 may leave out both. boxes_and_scores has outputs instead, with the first of each list where nothing
/// is said, see detect::DecodedOutputs:
///
///   {"head": "boxes_and_scores", "outputs": {"boxes": NAME, "scores": NAME, "channels": last or first,
///    "form": centre, corners or corners_yx, "unit": pixels or share, "objectness": no or yes,
///    "score": probability, logit or softmax, "background": none, first or last}}
///
/// What else is left out has the default of detect::DetectorDescription, and fill
/// the usual one of its fit. Compiled in tapestry/implementation.hpp.
///
/// \param text  the whole text
/// \param path  the file's name, for messages
/// \throws FileError  malformed, with the key and the byte, for keys that are not known, and for values of
///                    another type or out of range; as read_json()
[[nodiscard]] detect::DetectorDescription parse_detector_description(std::string_view text,
                                                                     const std::string& path);

/// Reads such a file of at most 64 KiB; errors as parse_detector_description() and read_text_file().
/// Takes memory of at most 48 times the file and 1 MiB.
[[nodiscard]] inline detect::DetectorDescription read_detector_description(const std::string& path) {
  return parse_detector_description(read_text_file(path, std::uint64_t(1) << 16U), path);
}

}  // namespace tapestry::io
