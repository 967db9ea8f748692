#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

namespace tapestry::shell {
// Functions shared by programs that train a Darknet detector.

/// The text of the cfg for the weights to train: the file `cfg` or, if none is named, the one
/// within a converted detector.
inline std::string trainable_cfg(const std::string& cfg, const std::string& weights) {
  if (!cfg.empty()) return io::read_text_file(cfg);
  return io::parse_detector_metadata(io::read_onnx(weights).metadata, weights).cfg;
}

/// Writes the model in the format of the file's ending: an ONNX model with its cfg, or Darknet weights.
inline void save_model(const detect::DarknetModel<float>& model, const std::string& cfg,
                       const std::string& path) {
  if (io::is_onnx(path)) {
    (void)io::write_detector_file(path, model, cfg);
  } else {
    io::write_weight_file(path, model);
  }
}

/// The learning rate of a step, counted from 0. It rises linearly over the first `warm_up` steps and falls as
/// half a cosine over all steps, to a hundredth of `highest`.
inline double warm_cosine_rate(double highest, std::size_t step, std::size_t steps, double warm_up) {
  constexpr double floor = 0.01;
  const double at = static_cast<double>(step + 1);
  const double turned = std::numbers::pi * at / static_cast<double>(steps);
  return highest * std::min(1.0, at / warm_up) * (floor + (1 - floor) * (1 + std::cos(turned)) / 2);
}
}  // namespace tapestry::shell
