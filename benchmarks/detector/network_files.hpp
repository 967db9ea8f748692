#pragma once
#include <sstream>
#include <tapestry/io/atomic_file.hpp>
#include "problem.hpp"

namespace tapestry::benchmarks {
/// A cfg for one picture of the given size: Darknet would otherwise take memory for a whole batch, and the
/// peers read the size from the file.
[[nodiscard]] inline std::string cfg_of_size(const std::string& text, std::size_t size) {
  std::istringstream lines(text);
  std::string changed;
  int section = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind('[', 0) == 0) ++section;
    const std::string key = line.substr(0, line.find_first_of(" =\t"));
    const bool is_replaced = key == "width" || key == "height" || key == "batch" || key == "subdivisions";
    if (section == 1 && is_replaced) continue;
    changed += line + "\n";
    if (section == 1 && line.rfind('[', 0) == 0) {
      const std::string extent = std::to_string(size);
      changed += "batch=1\nsubdivisions=1\nwidth=" + extent + "\nheight=" + extent + "\n";
    }
  }
  return changed;
}

/// Parameters under which values keep their magnitude from layer to layer: normal weights of variance 2 /
/// (inputs of a filter), those of convolutions that a shortcut adds smaller, so that long chains of shortcuts
/// do not grow.
[[nodiscard]] inline Array<float, 1> random_parameters(const Problem& problem) {
  Random random(2);
  Array<float, 1> parameters(Extents<1>{problem.layout.count});
  for (const detect::ParameterBlock& block : problem.layout.blocks) {
    const auto& layers = problem.config.layers;
    const bool is_added =
        block.layer + 1 < layers.size() && layers[block.layer + 1].kind == detect::LayerKind::shortcut;
    const double inputs = static_cast<double>(block.count) / static_cast<double>(layers[block.layer].filters);
    for (std::size_t i = 0; i < block.count; ++i) {
      const auto draw = [&]() -> double {
        switch (block.role) {
          case detect::ParameterRole::weight:
            return std::sqrt(2 / inputs) * random.normal();
          case detect::ParameterRole::scale:
            return (is_added ? 0.3 : 1) * random.uniform(0.7, 1.3);
          case detect::ParameterRole::variance:
            return random.uniform(0.7, 1.3);
          default:
            return 0.1 * random.normal();
        }
      };
      parameters[block.offset + i] = static_cast<float>(draw());
    }
  }
  return parameters;
}

/// Gives every batch normalisation the variance 10⁴ without changing what it computes. Darknet, OpenCV and
/// this library add different ε to the variance or its root; with a large variance that is below 10⁻⁸ of the
/// result.
inline void enlarge_variances(const Problem& problem, Array<float, 1>& parameters) {
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i) {
    const detect::LayerConfig& layer = problem.config.layers[i];
    if (!layer.batch_normalize) continue;
    const detect::ConvolutionParameters& own = problem.layout.layers[i];
    for (std::size_t f = 0; f < layer.filters; ++f) {
      float& variance = parameters[own.variance + f];
      float& scale = parameters[own.scale + f];
      const double root = std::sqrt(static_cast<double>(variance) + problem.config.batch_norm_epsilon);
      scale = static_cast<float>(static_cast<double>(scale) * 100 / root);
      variance = 1e4F;
    }
  }
}

/// The files that every engine of a case reads.
struct NetworkFiles {
  std::string cfg, weights;
};

/// \param weights  of the network, or empty for random ones
[[nodiscard]] inline NetworkFiles write_network_files(const std::string& cfg, const std::string& weights,
                                                      std::size_t size, const std::string& stem) {
  const NetworkFiles files{stem + ".cfg", stem + ".weights"};
  io::write_file_atomically(files.cfg, std::string_view(cfg_of_size(io::read_text_file(cfg), size)));
  const Problem problem = make_problem(files.cfg, size);
  Array<float, 1> parameters = weights.empty()
                                   ? random_parameters(problem)
                                   : io::read_weight_file(weights, problem.config, problem.layout).parameters;
  enlarge_variances(problem, parameters);
  io::write_weight_file(files.weights, 0, parameters);
  return files;
}
}  // namespace tapestry::benchmarks
