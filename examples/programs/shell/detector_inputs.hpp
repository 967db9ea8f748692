#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/detect/detector.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

#include "settings.hpp"

namespace tapestry::shell {

/// A network with its weights and the names of its classes.
struct Detector {
  std::unique_ptr<detect::Detector<float>> network;
  image::Fit fit;                  ///< of pictures in the network's input
  std::vector<std::string> names;  ///< may be empty: classes are then known by number only
  std::vector<std::string> warnings;
};

/// Whether weights are an ONNX model, by the file's name.
inline bool is_onnx(const std::string& path) { return path.ends_with(".onnx"); }

/// \param layers  whose values and adjoints the detector tells: names of values of an .onnx model, numbers of
///                a Darknet network's; an empty one stands for the last that all heads see
/// \throws Error (usage) for a name in the place of a number
Detector load_detector(const DetectorSettings& settings, const std::vector<std::string>& layers = {});

/// The class that is the car, by name or, without names, by number.
std::size_t class_index_of(const DetectorSettings& settings, const Detector& detector);

}  // namespace tapestry::shell
