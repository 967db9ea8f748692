#pragma once
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/number_formats.hpp>

namespace tapestry::io {
namespace detail {
detect::ParameterLayout layout_of(const detect::NetworkConfig& config, std::size_t input_height,
                                  std::size_t input_width) {
  return detect::parameter_layout(
      config, detect::infer_shapes(config, input_height == 0 ? config.height : input_height,
                                   input_width == 0 ? config.width : input_width));
}

std::string describe(const detect::NetworkConfig& config, const detect::ParameterBlock& block) {
  return std::string(name_of(block.role)) + " of layer " + std::to_string(block.layer) + " (convolutional, " +
         config.name + ":" + std::to_string(config.layers[block.layer].line) + ")";
}

/// Refuses files that are clearly not Darknet weights, and returns the size of the header for its version.
[[nodiscard]] inline std::uint64_t check_header(const RegularFile& file,
                                                std::span<const std::byte> beginning) {
  const auto fail = [&](const std::string& what, const std::string& expected, const std::string& found) {
    throw malformed_file({file.path(), "@0", what, expected, found});
  };
  const std::string_view recognised = recognised_format(beginning);
  if (!recognised.empty()) fail("not Darknet weights", "a .weights file", std::string(recognised));
  if (beginning.size() < 16)
    fail("file too short", "a header of 20 bytes", std::to_string(file.size()) + " bytes");
  const auto major = little_endian_word<std::uint32_t>(beginning.data());
  const auto minor = little_endian_word<std::uint32_t>(&beginning[4]);
  if (major <= 1000 && minor <= 1000) return major * 10 + minor >= 2 ? 20 : 16;
  const bool swapped = __builtin_bswap32(major) <= 1000 && __builtin_bswap32(minor) <= 1000;
  fail(swapped
           ? "implausible version, as of a big-endian file"
           : "implausible version; above 1000 it would mean the transposed layout, which is not supported",
       "major and minor up to 1000", std::to_string(major) + "." + std::to_string(minor));
  return 0;
}

[[nodiscard]] inline FileError cut_weights(const RegularFile& file, const detect::NetworkConfig& config,
                                           const detect::ParameterLayout& layout, std::uint64_t header) {
  const std::uint64_t floats = file.size() > header ? (file.size() - header) / 4 : 0;
  for (const detect::ParameterBlock& block : layout.blocks) {
    if (block.offset + block.count <= floats) continue;
    const std::uint64_t begin = header + 4 * std::uint64_t(block.offset);
    const std::uint64_t left = file.size() > begin ? file.size() - begin : 0;
    return malformed_file(
        {file.path(), "@" + std::to_string(begin),
         "file ends in the " + describe(config, block) + "; cut short, or weights of another cfg",
         std::to_string(4 * std::uint64_t(block.count)) + " bytes there and " + std::to_string(layout.count) +
             " floats in all",
         std::to_string(left) + " bytes there and " + std::to_string(floats) + " floats in all"});
  }
  return malformed_file({file.path(), "", "file ends early"});
}

std::uint64_t header_size(const RegularFile& file, const detect::NetworkConfig& config,
                          const detect::ParameterLayout& layout, std::uint64_t by_version,
                          bool upper_half_is_zero, bool allow_trailing) {
  const std::uint64_t body = 4 * std::uint64_t(layout.count);
  if (file.size() == by_version + body) return by_version;
  const std::uint64_t other = 36 - by_version;  // 16 or 20
  if (file.size() == other + body && upper_half_is_zero == (other == 20)) return other;
  if (file.size() % 4 != 0)
    throw malformed_file(
        {file.path(), "", "size without its header is not a multiple of 4, so the file is damaged",
         std::to_string(by_version + body) + " bytes", std::to_string(file.size()) + " bytes"});
  if (file.size() < by_version + body) throw cut_weights(file, config, layout, by_version);
  if (allow_trailing) return by_version;
  const std::uint64_t unused = (file.size() - by_version - body) / 4;
  throw file_mismatch({file.path(), "@" + std::to_string(by_version + body),
                       std::to_string(unused) + " floats unused; the weights belong to another cfg than " +
                           config.name + ", or were cut with a partial-layer tool",
                       std::to_string(layout.count) + " floats",
                       std::to_string((file.size() - by_version) / 4) + " floats"});
}

void check_block(const std::string& path, const detect::NetworkConfig& config,
                 const detect::ParameterBlock& block, std::span<const float> values,
                 std::optional<std::uint64_t> begin) {
  if (block.role != detect::ParameterRole::variance && are_finite(values)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool negative_variance = block.role == detect::ParameterRole::variance && values[i] < 0;
    if (is_finite(values[i]) && !negative_variance) continue;
    throw malformed_file(
        {path, begin ? "@" + std::to_string(*begin + 4 * std::uint64_t(block.offset + i)) : "",
         "element " + std::to_string(i) + " of the " + describe(config, block),
         negative_variance ? "a variance of at least 0" : "a finite number", std::to_string(values[i])});
  }
}

struct Magnitudes {
  float largest = 0;
  double square_sum = 0;
  std::size_t denormal_count = 0;
};

[[nodiscard]] inline Magnitudes magnitudes_of(std::span<const float> values) {
  Magnitudes all;
  double sums[4] = {};  // additions that need not wait for each other
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float magnitude = std::abs(values[i]);
    all.largest = magnitude > all.largest ? magnitude : all.largest;
    sums[i % 4] += static_cast<double>(magnitude) * static_cast<double>(magnitude);
    all.denormal_count += magnitude > 0 && magnitude < std::numeric_limits<float>::min() ? 1 : 0;
  }
  all.square_sum = sums[0] + sums[1] + (sums[2] + sums[3]);
  return all;
}

/// Adds warnings for values that are possible but look like the weights of another cfg.
inline void remark_on_block(const detect::NetworkConfig& config, const detect::ParameterBlock& block,
                            const Magnitudes& magnitudes, std::vector<std::string>& warnings) {
  const auto largest = static_cast<double>(magnitudes.largest);
  const std::size_t denormal_count = magnitudes.denormal_count;
  const double rms = std::sqrt(magnitudes.square_sum / static_cast<double>(block.count));
  std::string remark;
  if (denormal_count > 0) remark = std::to_string(denormal_count) + " denormal values";
  if (block.role == detect::ParameterRole::mean && largest > 1e3) remark = "magnitude above 1000";
  if (block.role == detect::ParameterRole::weight && !(rms <= 10)) remark = "root mean square above 10";
  if (block.role == detect::ParameterRole::weight && rms < 1e-6) remark = "root mean square below 1e-6";
  if (block.role == detect::ParameterRole::weight && largest == 0) remark = "all zero";
  if (!remark.empty() && warnings.size() < 100)
    warnings.push_back(describe(config, block) + ": " + remark + "; are these the weights of another cfg?");
}
}  // namespace detail

WeightFile read_weight_file(const std::string& path, const detect::NetworkConfig& config,
                            const detect::ParameterLayout& layout, const WeightFileOptions& options) {
  const RegularFile file(path);
  std::vector<std::byte> beginning(file.size() < 64 ? static_cast<std::size_t>(file.size()) : 64);
  file.read_at(0, beginning);
  const std::uint64_t by_version = detail::check_header(file, beginning);
  const bool upper_half_is_zero =
      beginning.size() >= 20 && little_endian_word<std::uint32_t>(&beginning[16]) == 0;
  const std::uint64_t header =
      detail::header_size(file, config, layout, by_version, upper_half_is_zero, options.allow_trailing);
  WeightFile weights;
  weights.images_seen = header == 20 ? little_endian_word<std::uint64_t>(&beginning[12])
                                     : little_endian_word<std::uint32_t>(&beginning[12]);
  weights.parameters.resize(Extents<1>{layout.count});
  file.read_at(header, std::as_writable_bytes(std::span(weights.parameters.data(), layout.count)));
  file.require_unchanged();
  if constexpr (std::endian::native == std::endian::big) {
    for (float& value : weights.parameters) {
      value = std::bit_cast<float>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
    }
  }
  const auto values_of = [&](const detect::ParameterBlock& block) {
    return std::span<const float>(weights.parameters.data() + block.offset, block.count);
  };
  std::vector<detail::Magnitudes> magnitudes(layout.blocks.size());
  parallel_for(magnitudes.size(),
               [&](std::size_t i) { magnitudes[i] = detail::magnitudes_of(values_of(layout.blocks[i])); });
  for (std::size_t i = 0; i < magnitudes.size(); ++i) {
    const detect::ParameterBlock& block = layout.blocks[i];
    if (!options.allow_nonfinite) detail::check_block(path, config, block, values_of(block), header);
    detail::remark_on_block(config, block, magnitudes[i], weights.warnings);
  }
  return weights;
}

void write_weight_file(const std::string& path, std::uint64_t images_seen,
                       const Array<float, 1>& parameters) {
  std::array<std::byte, 20> header{};
  header[4] = std::byte(2);
  header[8] = std::byte(5);
  for (std::size_t i = 0; i < 8; ++i) header[12 + i] = static_cast<std::byte>(images_seen >> (8 * i));
  if constexpr (std::endian::native == std::endian::big) {
    std::vector<std::uint32_t> words;
    words.reserve(parameters.size());
    for (const float value : parameters)
      words.push_back(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
    write_file_atomically(path, {header, std::as_bytes(std::span<const std::uint32_t>(words))});
  } else {
    write_file_atomically(path, {header, std::as_bytes(std::span(parameters.data(), parameters.size()))});
  }
}
}  // namespace tapestry::io
