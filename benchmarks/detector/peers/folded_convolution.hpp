#pragma once
#include "../problem.hpp"

namespace tapestry::benchmarks {
/// A convolution that its batch normalisation has been multiplied into.
struct FoldedConvolution {
  std::vector<float> weights{};  ///< [filters, channels / groups, row, column]
  std::vector<float> biases{};   ///< [filters]
};

/// Reads one layer at a time, so that a peer needs no second copy of all parameters.
class FoldedConvolutions {
 public:
  FoldedConvolutions(const Problem& problem, const std::string& weights_path)
      : problem_(problem), file_(weights_path) {
    if (file_.size() != header + 4 * problem.layout.count)
      throw FileError(ErrorKind::mismatch, {weights_path, "", "not the weights of " + problem.config.name});
  }

  [[nodiscard]] FoldedConvolution read(std::size_t index) const {
    const detect::LayerConfig& layer = problem_.config.layers[index];
    const detect::ConvolutionParameters& own = problem_.layout.layers[index];
    const std::size_t inputs = input_channels(problem_, index) / layer.groups * layer.size * layer.size;
    FoldedConvolution folded{read(own.weight, layer.filters * inputs), read(own.bias, layer.filters)};
    if (!layer.batch_normalize) return folded;
    const auto scale = read(own.scale, layer.filters);
    const auto mean = read(own.mean, layer.filters);
    const auto variance = read(own.variance, layer.filters);
    for (std::size_t f = 0; f < layer.filters; ++f) {
      const double factor = static_cast<double>(scale[f]) /
                            std::sqrt(static_cast<double>(variance[f]) + problem_.config.batch_norm_epsilon);
      for (float& weight : std::span(folded.weights).subspan(f * inputs, inputs))
        weight = static_cast<float>(static_cast<double>(weight) * factor);
      folded.biases[f] =
          static_cast<float>(static_cast<double>(folded.biases[f]) - static_cast<double>(mean[f]) * factor);
    }
    return folded;
  }

 private:
  static constexpr std::size_t header = 20;  // bytes, of version 0.2 and later

  [[nodiscard]] std::vector<float> read(std::size_t offset, std::size_t count) const {
    std::vector<float> values(count);
    file_.read_at(header + 4 * offset, std::as_writable_bytes(std::span(values)));
    return values;
  }

  const Problem& problem_;
  io::RegularFile file_;
};

/// The complaint of a peer's program about a layer that it has no use for in these benchmarks.
[[nodiscard]] inline Error not_supported(const Problem& problem, std::size_t layer) {
  return Error(ErrorKind::mismatch, "layer " + std::to_string(layer) + " (" +
                                        std::string(detect::name_of(problem.config.layers[layer].kind)) +
                                        ") is not supported");
}

/// Slope below 0 of an activation with a kink.
/// \throws Error  if it is neither that nor linear
[[nodiscard]] inline float slope_of(const Problem& problem, std::size_t layer) {
  switch (problem.config.layers[layer].activation) {
    case nn::Activation::linear:
      return 1;
    case nn::Activation::leaky:
      return 0.1F;
    case nn::Activation::relu:
      return 0;
    default:
      throw not_supported(problem, layer);
  }
}
}  // namespace tapestry::benchmarks
