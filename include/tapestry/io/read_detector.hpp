#pragma once
#include <tapestry/io/darknet/model_file.hpp>

namespace tapestry::io {
/// The files of a detector, and how to read them. All but the weights are optional.
struct DetectorFiles {
  std::string weights{};      ///< an ONNX model or Darknet weights
  std::string config{};       ///< cfg, which Darknet weights need, and a model made of them may have
  std::string names{};        ///< names of the classes, one a line; left out, those of an ONNX model's
                              ///< metadata, see parse_exported_names()
  std::string description{};  ///< of an ONNX model, see read_detector_description(), or the name of a family
                              ///< of exports, see detect::named_export(); left out, the model's own,
                              ///< description_beside() or what the layers show
  std::string decode{};       ///< decode family of a Darknet network, where its files leave it open
  std::size_t size = 0;       ///< side of the square input, pixels; 0: the files' own
  std::string precision = "float";  ///< of products in convolutions: float or bfloat16
  std::string fit{};                ///< fit of photographs, see image::fit_by_name(); empty: the files' own
  /// Values within an ONNX model, or numbers of a Darknet network's layers, that Detector::layer_values()
  /// returns; an empty one stands for the last layer that all heads depend on.
  std::vector<std::string> layers{};
};

/// The description file beside an ONNX model: the model's name with the ending .json. Empty if there is none.
[[nodiscard]] std::string description_beside(const std::string& weights);

/// Key of the metadata of an ONNX model for the text of its description. No other description of such a model
/// is taken.
inline constexpr const char* description_key = "tapestry.detector";

/// Reads a detector from any kind of file:
///
///   const auto detector = io::read_detector<float>({.weights = "yolox_nano.onnx", .names = "coco.names"});
///   const auto detector = io::read_detector<float>({.weights = "yolov3.weights", .config = "yolov3.cfg"});
///
/// \param warnings unless null, takes warnings about the files, facts taken from an ONNX model's metadata,
///                 and contradictions to them and to its stated extents
/// \param input_source  unless null, receives the origin of the pictures' encoding and fit; a fit in the
///                      files replaces it
/// \throws Error (usage) for files that do not go together, or an ONNX model that nothing describes;
///         FileError as read_darknet_model(), read_onnx(), read_detector_description(), read_class_names()
///         and Detector, and (mismatch) for a network without heads, for a description that contradicts the
///         one within the model, and for metadata that name another number of classes than its heads have;
///         where layers do not fit, with the families that do; DomainError for a precision, fit or decode
///         family of no such name
template <std::floating_point T>
[[nodiscard]] detect::Detector<T> read_detector(const DetectorFiles& files,
                                                std::vector<std::string>* warnings = nullptr,
                                                std::string* input_source = nullptr);

/// Reads the picture of a file, see read_picture(), as a batch of one for a detector.
/// \throws FileError as read_picture()
template <std::floating_point T>
[[nodiscard]] Array<T, 4> read_input(const detect::Detector<T>& detector, const std::string& path);
}  // namespace tapestry::io
