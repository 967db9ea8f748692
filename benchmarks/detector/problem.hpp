#pragma once
#include <tapestry/io/darknet/model_file.hpp>

namespace tapestry::benchmarks {
/// The task of every engine: the logits of one picture, or beside them the gradient to the picture of Σ
/// weighting · logits.
struct Problem {
  detect::NetworkConfig config;
  std::vector<detect::FeatureShape> shapes{};  ///< of each layer's output
  detect::ParameterLayout layout{};
  std::vector<std::size_t> heads{};          ///< the yolo layers; their shapes are those of the logits
  Array<float, 4> picture{};                 ///< [1, 3, size, size], uniform in [0, 1)
  std::vector<Array<float, 4>> weighting{};  ///< for each head [1, A·(5+K), H, W], normal
};

[[nodiscard]] inline Problem make_problem(const std::string& cfg, std::size_t size) {
  Problem problem{io::read_network_config(cfg)};
  problem.shapes = detect::infer_shapes(problem.config, size, size);
  problem.layout = detect::parameter_layout(problem.config, problem.shapes);
  Random random(1);
  problem.picture = zeros<float, 4>({1, problem.config.channels, size, size});
  for (float& value : problem.picture.storage()) value = static_cast<float>(random.uniform());
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i) {
    if (problem.config.layers[i].kind != detect::LayerKind::yolo) continue;
    const detect::FeatureShape& shape = problem.shapes[i];
    problem.heads.push_back(i);
    problem.weighting.push_back(zeros<float, 4>({1, shape.channels, shape.height, shape.width}));
    for (float& value : problem.weighting.back().storage()) value = static_cast<float>(random.normal());
  }
  return problem;
}

/// Channels of the value that a layer reads first.
[[nodiscard]] inline std::size_t input_channels(const Problem& problem, std::size_t layer) {
  return layer == 0 ? problem.config.channels : problem.shapes[layer - 1].channels;
}

/// Multiplications and additions of all convolutions of a forward pass, done directly, in units of 10⁹. The
/// gradient to the picture takes as many again.
[[nodiscard]] inline double direct_gflop(const Problem& problem) {
  double flop = 0;
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i) {
    const detect::LayerConfig& layer = problem.config.layers[i];
    if (layer.kind != detect::LayerKind::convolutional) continue;
    const auto inputs = input_channels(problem, i) / layer.groups * layer.size * layer.size;
    flop += 2.0 * static_cast<double>(problem.shapes[i].size()) * static_cast<double>(inputs);
  }
  return flop * 1e-9;
}
}  // namespace tapestry::benchmarks
