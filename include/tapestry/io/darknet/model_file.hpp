#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/darknet_model.hpp>
#include <vector>

namespace tapestry::io {

/// A model, and remarks on what is suspicious about its files.
template <std::floating_point T>
struct LoadedModel {
  detect::DarknetModel<T> model;
  std::vector<std::string> warnings{};
};

/// Whether a file is a safetensors file, by its first bytes, or at least is named like one.
/// \throws FileError as RegularFile
[[nodiscard]] bool is_safetensors(const std::string& path);

/// Reads a model whose parameters are Darknet weights, or a detector that convert_weights wrote; the file
/// itself shows which.
///
/// \param cfg      path of the Darknet cfg file; may be empty with a converted detector, which holds its own
/// \param weights  path
/// \param input_height  of the pictures, in pixels; 0 takes the cfg's own
/// \param input_width   likewise
/// \param decode   how logits become boxes; left out, what a converted detector says and of Darknet weights
///                 what the cfg says: scaled for new_coords=1, else darknet
/// \throws Error (usage) for Darknet weights without a cfg; Error (mismatch) if a converted detector is of
///         another decode family than `decode`; FileError as detect::with_decode(),
///         read_network_config(), read_weight_file(), DetectorFile and DarknetModel's constructor
template <std::floating_point T>
[[nodiscard]] LoadedModel<T> read_darknet_model(const std::string& cfg, const std::string& weights,
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
