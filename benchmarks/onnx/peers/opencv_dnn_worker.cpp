// An ONNX network in OpenCV's dnn module, forward only.
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/opencv_network.hpp"
#include "../problem.hpp"

namespace tapestry::benchmarks {
namespace {
struct OpenCvOnnx : OpenCvNetwork {
  explicit OpenCvOnnx(const NetworkOptions& options)
      : OpenCvNetwork(cv::dnn::readNetFromONNX(options.model), options, read_numbers<float>(options.input)) {
    for (const std::string& output : io::read_onnx(options.model).outputs) output_names_.push_back(output);
  }
  [[nodiscard]] std::vector<float> answer() const { return values(); }
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_network_worker<tapestry::benchmarks::OpenCvOnnx>(argc, argv);
}
