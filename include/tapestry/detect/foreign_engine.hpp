#pragma once
#include <functional>
#include <tapestry/nn/network/tensor.hpp>
#include <vector>

namespace tapestry::detect {

/// An output of a foreign engine, values in row-major order.
struct ForeignOutput {
  nn::Shape shape{};
  std::vector<float> values{};
};

/// Another library, such as OpenCV, ONNX Runtime or TensorRT, that runs a model which our readers do not
/// read: everything that measures by forward passes takes it as a Detector. Runs the model on one picture,
/// [3, H, W] of the input's extents, encoded as the description says, and returns the output with boxes and,
/// unless it is the same, the one with scores. It is never called by two threads at once.
using ForeignEngine = std::function<std::vector<ForeignOutput>(const std::vector<float>& picture)>;

}  // namespace tapestry::detect
