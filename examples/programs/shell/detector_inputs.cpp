#include "detector_inputs.hpp"

#include <tapestry/io/darknet/model_file.hpp>
#include <utility>

namespace tapestry::shell {

detect::Detector<float> load_detector(const DetectorSettings& settings, std::vector<std::string>& warnings,
                                      const std::vector<std::string>& layers) {
  const bool is_onnx = io::is_onnx(settings.weights);
  for (const auto& [option, value] :
       {std::pair("--cfg", settings.cfg), std::pair("--decode", settings.decode)})
    if (is_onnx && !value.empty())
      throw Error(ErrorKind::usage, std::string(option) + " is for Darknet weights; " + settings.weights +
                                        " is described by --detector, or recognised");
  if (!is_onnx && !settings.detector.empty())
    throw Error(ErrorKind::usage, "--detector describes .onnx weights; those of " + settings.weights +
                                      " are described by a cfg");
  if (!is_onnx && settings.cfg.empty() && !io::is_safetensors(settings.weights))
    throw Error(ErrorKind::usage, "--cfg is missing, which " + settings.weights +
                                      " needs; only weights that convert_weights made hold their own");
  return io::read_detector<float>({.weights = settings.weights,
                                   .config = settings.cfg,
                                   .names = settings.names,
                                   .description = settings.detector,
                                   .decode = settings.decode,
                                   .size = settings.size,
                                   .precision = settings.precision,
                                   .fit = settings.fit,
                                   .layers = layers},
                                  &warnings);
}

}  // namespace tapestry::shell
