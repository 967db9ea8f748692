// The detector in OpenCV's dnn module, forward only.
#include "../../support/opencv_network.hpp"
#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
struct OpenCvDetector : OpenCvNetwork {
  OpenCvDetector(const Problem& problem, const WorkerOptions& options)
      : OpenCvNetwork(cv::dnn::readNetFromDarknet(options.cfg, options.weights), options,
                      {problem.picture.data(), problem.picture.data() + problem.picture.size()}) {
    for (const std::size_t head : problem.heads) output_names_.push_back("conv_" + std::to_string(head - 1));
  }
  [[nodiscard]] Answer answer() const { return {values()}; }
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::OpenCvDetector>(argc, argv, "has one");
}
