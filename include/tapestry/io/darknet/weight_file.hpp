#pragma once
#include <concepts>
#include <cstdint>
#include <string>
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/io/file_source.hpp>
#include <vector>

namespace tapestry::io {

/// Content of a Darknet `.weights` file, little-endian: int32 major, minor, revision; the number of images
/// seen, 64 bits wide from version 0.2 on and 32 before; float32 parameters in the order of
/// detect::ParameterLayout.
struct WeightFile {
  std::uint64_t images_seen = 0;
  Array<float, 1> parameters{};         ///< in the order of detect::ParameterLayout
  std::vector<std::string> warnings{};  ///< suspicious values, one message each
};

/// What a reader of weights lets pass.
struct WeightFileOptions {
  bool allow_trailing = false;   ///< accept more parameters than the cfg needs (cut backbone files)
  bool allow_nonfinite = false;  ///< accept NaN, infinity and negative variances, to debug them
};

namespace detail {

[[nodiscard]] std::string describe(const detect::NetworkConfig& config, const detect::ParameterBlock& block);

/// Bytes of the header, decided by the version and, where that does not fit, by the exact size. A file of 4
/// bytes less than its version asks for may also be cut; then the upper half of the count stands where
/// the first parameter should, and is zero.
[[nodiscard]] std::uint64_t header_size(const RegularFile& file, const detect::NetworkConfig& config,
                                        const detect::ParameterLayout& layout, std::uint64_t by_version,
                                        bool upper_half_is_zero, bool allow_trailing);

}  // namespace detail

/// Reads a weight file that must have exactly the parameters of `config`; its size is checked first.
/// Takes memory of at most 2 times the file and 1 MiB.
/// \throws FileError  malformed if it is damaged, cut, not a weight file or holds impossible values, with
///                    layer, array and byte offset; mismatch if it is longer; limit above 4 GiB
[[nodiscard]] WeightFile read_weight_file(const std::string& path, const detect::NetworkConfig& config,
                                          const detect::ParameterLayout& layout,
                                          const WeightFileOptions& options = {});

/// Writes a weight file of version 0.2.5, or leaves the old file as it was.
/// \throws FileError (write)
void write_weight_file(const std::string& path, std::uint64_t images_seen, const Array<float, 1>& parameters);

/// Writes a model's parameters, rounded to float, and its count of images; errors as above.
template <std::floating_point T>
void write_weight_file(const std::string& path, const detect::DarknetModel<T>& model) {
  write_weight_file(path, model.images_seen(), cast<float>(model.parameters()));
}

}  // namespace tapestry::io
