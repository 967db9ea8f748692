#pragma once
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
namespace detail {
/// Layers of a cfg, each checked alone.
[[nodiscard]] detect::NetworkConfig parse_cfg(std::string_view text, const std::string& name);

inline constexpr std::uint64_t largest_cfg_size = std::uint64_t(4) << 20U;

/// \param input_height  in pixels; 0 takes the cfg's own
/// \param input_width   likewise
[[nodiscard]] detect::ParameterLayout layout_of(const detect::NetworkConfig& config,
                                                std::size_t input_height = 0, std::size_t input_width = 0);

[[nodiscard]] std::string describe(const detect::NetworkConfig& config, const detect::ParameterBlock& block);

/// Throws for the first value that no trained network can hold.
/// \param begin  of the parameters, bytes into the file, if they lie there one after another
void check_block(const std::string& path, const detect::NetworkConfig& config,
                 const detect::ParameterBlock& block, std::span<const float> values,
                 std::optional<std::uint64_t> begin);

/// Size of the header in bytes. The version decides it and, if that does not fit, the exact size of the file.
/// A file 4 bytes shorter than its version requires may also be cut; then the upper half of the count is in
/// the place of the first parameter, and is zero.
[[nodiscard]] std::uint64_t header_size(const RegularFile& file, const detect::NetworkConfig& config,
                                        const detect::ParameterLayout& layout, std::uint64_t by_version,
                                        bool upper_half_is_zero, bool allow_trailing);
}  // namespace detail

/// Parses a Darknet cfg file of a detector. Its layers are checked against each other at the input size that
/// the cfg states; detect::infer_shapes() checks other sizes. Options for Darknet's training are skipped;
/// unknown options become `warnings`.
///
/// \param text  the file's content
/// \param name  the file's name, for messages
/// \throws FileError  malformed for syntax and impossible values, mismatch for parts that do not fit,
///                    limit for absurd sizes; with line, and column where an option's value is at fault
[[nodiscard]] detect::NetworkConfig parse_network_config(std::string_view text, const std::string& name);

/// The same for a network without heads, such as a classifier; see detect::check_classifier().
[[nodiscard]] detect::NetworkConfig parse_classifier_config(std::string_view text, const std::string& name);

/// Reads a Darknet cfg file of at most 4 MiB; errors as parse_network_config() and read_text_file().
/// Takes memory of at most 24 times the file and 1 MiB.
[[nodiscard]] inline detect::NetworkConfig read_network_config(const std::string& path) {
  return parse_network_config(read_text_file(path, detail::largest_cfg_size), path);
}

/// The same by parse_classifier_config().
[[nodiscard]] inline detect::NetworkConfig read_classifier_config(const std::string& path) {
  return parse_classifier_config(read_text_file(path, detail::largest_cfg_size), path);
}

/// Content of a Darknet `.weights` file, little-endian: int32 major, minor, revision; the number of images
/// seen, 64 bits wide from version 0.2 on and 32 before; float32 parameters in the order of
/// detect::ParameterLayout.
struct WeightFile {
  std::uint64_t images_seen = 0;
  Array<float, 1> parameters{};         ///< in the order of detect::ParameterLayout
  std::vector<std::string> warnings{};  ///< suspicious values, one message each
};

/// Deviations that read_weight_file() accepts.
struct WeightFileOptions {
  bool allow_trailing = false;   ///< accept more parameters than the cfg needs (cut backbone files)
  bool allow_nonfinite = false;  ///< accept NaN, infinity and negative variances, to debug them
};

/// Reads a weight file that must have exactly the parameters of `config`; the file's size is checked first.
/// Takes memory of at most 2 times the file and 1 MiB.
/// \throws FileError  malformed if it is damaged, cut, not a weight file or holds impossible values, with
///                    layer, array and byte offset; mismatch if it is longer; limit above 4 GiB
[[nodiscard]] WeightFile read_weight_file(const std::string& path, const detect::NetworkConfig& config,
                                          const detect::ParameterLayout& layout,
                                          const WeightFileOptions& options = {});

/// Writes a weight file of version 0.2.5, or leaves the old file as it was.
/// \throws FileError (write)
void write_weight_file(const std::string& path, std::uint64_t images_seen, const Array<float, 1>& parameters);

/// Writes a model's parameters, rounded to float, and its count of pictures seen; errors as above.
template <std::floating_point T>
void write_weight_file(const std::string& path, const detect::DarknetModel<T>& model) {
  write_weight_file(path, model.images_seen(), cast<float>(model.parameters()));
}

/// A model, and warnings about its files.
template <std::floating_point T>
struct LoadedModel {
  detect::DarknetModel<T> model;
  std::vector<std::string> warnings{};
};

/// Whether weights are an ONNX model, by the file's name.
[[nodiscard]] inline bool is_onnx(const std::string& path) { return path.ends_with(".onnx"); }

/// Reads a model from Darknet weights, or from an ONNX model that was made of a Darknet detector.
///
/// \param cfg      path of the Darknet cfg file; may be empty with a converted detector, which holds its own
/// \param weights  path
/// \param input_height  of the pictures, in pixels; 0 takes the cfg's own
/// \param input_width   likewise
/// \param decode   how logits become boxes. Left out, it is the family stored in a converted detector; for
///               Darknet weights it is scaled if the cfg has new_coords=1, else darknet
/// \throws Error (usage) for Darknet weights without a cfg; Error (mismatch) if a converted detector is of
///         another decode family than `decode`; FileError as detect::with_decode(),
///         read_network_config(), read_weight_file(), read_onnx(), parse_detector_metadata() and
///         DarknetModel's constructor; mismatch also for an ONNX model whose constants
///         do not fit the cfg
template <std::floating_point T>
[[nodiscard]] LoadedModel<T> read_darknet_model(const std::string& cfg, const std::string& weights,
                                                std::size_t input_height = 0, std::size_t input_width = 0,
                                                std::optional<detect::DecodeFamily> decode = {});

/// The same for an ONNX model that was read, see is_of_darknet().
template <std::floating_point T>
[[nodiscard]] LoadedModel<T> darknet_model(const nn::NetworkDescription& network, const std::string& cfg = "",
                                           std::size_t input_height = 0, std::size_t input_width = 0,
                                           std::optional<detect::DecodeFamily> decode = {});

/// Reads a classifier, or another network without heads, with Darknet weights.
///
/// \param cfg, weights  paths
/// \param input_height, input_width  as in read_darknet_model()
/// \throws FileError as read_classifier_config(), read_weight_file() and DarknetModel's constructor
template <std::floating_point T>
[[nodiscard]] LoadedModel<T> read_classifier(const std::string& cfg, const std::string& weights,
                                             std::size_t input_height = 0, std::size_t input_width = 0);
}  // namespace tapestry::io
