#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/huge_pages.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/safetensors_file.hpp>
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

/// The tensors of a detector in the order of its layout, named as PyTorch names them. For layer i of the cfg,
/// counted from 0 without [net]:
///
///   layers.i.weight           [filters, channels / groups, size, size]
///   layers.i.bias             [filters], of a layer without batch normalisation
///   layers.i.bn.bias          [filters], β; then bn.weight, γ, bn.running_mean and bn.running_var
[[nodiscard]] std::vector<NamedShape> detector_tensors(const detect::NetworkConfig& config,
                                                       const detect::ParameterLayout& layout);

namespace detail {
/// \param input_height  in pixels; 0 takes the cfg's own
/// \param input_width   likewise
[[nodiscard]] detect::ParameterLayout layout_of(const detect::NetworkConfig& config,
                                                std::size_t input_height = 0, std::size_t input_width = 0);
}  // namespace detail

/// A detector in one .safetensors file: its cfg and its parameters, as convert_weights writes them.
class DetectorFile {
 public:
  /// \throws FileError  as SafetensorsFile and parse_detector_metadata() do; for the cfg within as
  ///                    parse_network_config() does, under the name `<path>:cfg`
  explicit DetectorFile(const std::string& path)
      : file_(path),
        metadata_(parse_detector_metadata(file_.metadata(), path)),
        config_(adapted(parse_network_config(metadata_.cfg, path + ":cfg"))) {}

  [[nodiscard]] const DetectorMetadata& metadata() const { return metadata_; }
  [[nodiscard]] const detect::NetworkConfig& config() const { return config_; }

  /// The given cfg with this file's epsilon and decode family, and without batch normalisation if that has
  /// been folded.
  /// \throws FileError (mismatch) if the decode family contradicts the cfg, see detect::with_decode()
  [[nodiscard]] detect::NetworkConfig adapted(detect::NetworkConfig config) const;

  /// Warnings about unusual content of the file, one message each.
  [[nodiscard]] std::vector<std::string> warnings() const;

  /// All parameters in the order of `layout`, whatever their order in the file. They are read in pieces, and
  /// each piece is checked while it is in the cache, so that memory is written once.
  ///
  /// \param config config(), or another cfg after adapted()
  /// \param layout  of config
  /// \throws FileError  mismatch for a tensor that is missing, not in the layout, of another shape, or not of
  ///                  floating-point type; malformed for a value that no trained network can hold, and for a
  ///                  file that changes its size while it is read; with the tensor's name
  template <std::floating_point T>
  [[nodiscard]] Array<T, 1> parameters(const detect::NetworkConfig& config,
                                       const detect::ParameterLayout& layout) const {
    const auto tensors = matching(detector_tensors(config, layout), config.name);
    Array<T, 1> parameters(Extents<1>{layout.count});
    T* next = parameters.data();
    prefer_huge_pages(parameters.data(), layout.count * sizeof(T));
    std::vector<float> piece(piece_size);
    for (std::size_t i = 0; i < tensors.size(); ++i) {
      for (std::size_t first = 0; first < tensors[i].size(); first += piece_size) {
        const auto values = std::span(piece).first(std::min(piece_size, tensors[i].size() - first));
        file_.read(tensors[i], values, first);
        check_values(tensors[i], layout.blocks[i].role, values, first);
        next = std::copy(values.begin(), values.end(), next);
      }
    }
    return parameters;
  }

 private:
  static constexpr std::size_t piece_size = std::size_t(1) << 15U;  ///< floats, 128 KiB

  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw FileError(ErrorKind::mismatch, {file_.path(), "", what, expected, found});
  }

  /// The file's tensors in the expected order.
  [[nodiscard]] std::vector<Tensor> matching(const std::vector<NamedShape>& expected,
                                             const std::string& cfg_name) const;

  void require_fit(const Tensor& tensor, const NamedShape& wanted, const std::string& cfg_name) const;

  /// \param first element of the tensor that values[0] holds
  void check_values(const Tensor& tensor, detect::ParameterRole role, std::span<const float> values,
                    std::size_t first) const;

  SafetensorsFile file_;
  DetectorMetadata metadata_;
  detect::NetworkConfig config_;
};

/// Writes a detector, or leaves the old file as it was. The same arguments give the same bytes. Without
/// folding, the bytes behind the header are those of the Darknet weights behind their header.
///
/// \param metadata its cfg describes the network; is_folded folds the batch normalisation
/// \param parameters  in the order of the layout of that cfg, not folded
/// \param cfg_name    the cfg's file name, for messages
/// \returns           the number of tensors written
/// \throws FileError  for the cfg as parse_network_config() does, and malformed unless it is UTF-8; mismatch
///                    for a decode family that contradicts it; write
/// \throws ShapeError unless there are as many parameters as the cfg needs, NumericError as fold_batch_norm()
std::size_t write_detector_file(const std::string& path, const DetectorMetadata& metadata,
                                const Array<float, 1>& parameters, const std::string& cfg_name);

}  // namespace tapestry::io
