#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network.hpp>
#include <vector>

namespace tapestry::io {

/// A network with its parameters, and remarks on what is suspicious about its files.
template <std::floating_point T>
struct LoadedNetwork {
  detect::Network<T> network;
  std::vector<std::string> warnings{};
};

/// Whether a file is a safetensors file, by its first bytes, or at least is named like one.
/// \throws FileError as RegularFile
[[nodiscard]] bool is_safetensors(const std::string& path);

/// Reads a network whose parameters are Darknet weights, or a detector that convert_weights wrote; the
/// file itself says which.
///
/// \param cfg      path of the Darknet cfg file; may be empty with a converted detector, which holds its own
/// \param weights  path
/// \param input_height  of the pictures, in pixels; 0 takes the cfg's own
/// \param input_width   likewise
/// \param decode   how logits become boxes; left out, what a converted detector says and of Darknet weights
///                 what the cfg says: scaled for new_coords=1, else darknet
/// \throws Error (usage) for Darknet weights without a cfg; Error (mismatch) if a converted detector is of
///         another decode family than `decode`; FileError as detect::with_decode(),
///         read_network_config(), read_weight_file(), DetectorFile and Network's constructor
template <std::floating_point T>
[[nodiscard]] LoadedNetwork<T> read_network(const std::string& cfg, const std::string& weights,
                                            std::size_t input_height = 0, std::size_t input_width = 0,
                                            std::optional<detect::DecodeFamily> decode = {});

/// Reads a classifier, or another network without heads, with Darknet weights.
///
/// \param cfg, weights  paths
/// \param input_height, input_width  as in read_network()
/// \throws FileError as read_classifier_config(), read_weight_file() and Network's constructor
template <std::floating_point T>
[[nodiscard]] LoadedNetwork<T> read_classifier(const std::string& cfg, const std::string& weights,
                                               std::size_t input_height = 0, std::size_t input_width = 0);

}  // namespace tapestry::io
