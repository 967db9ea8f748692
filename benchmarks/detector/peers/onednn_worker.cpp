// The detector as a chain of oneDNN's primitives; "best" takes the faster of direct and Winograd convolution
// for each layer, which is more than oneDNN does by itself.

#include "../worker_program.hpp"
#include "onednn_network.hpp"

namespace tapestry::benchmarks {
namespace {
class OneDnnDetector {
 public:
  OneDnnDetector(const Problem& problem, const WorkerOptions& options)
      : wants_gradient_(options.wants_gradient), network_(made(problem, options)) {}

  [[nodiscard]] std::string name() const {
    const dnnl_version_t* version = dnnl_version();
    return "oneDNN " + std::to_string(version->major) + "." + std::to_string(version->minor) + "." +
           std::to_string(version->patch) + " (" + network_.kernels() + ")";
  }

  void run() { network_.run(); }

  [[nodiscard]] Answer answer() const {
    if (!wants_gradient_) return {network_.logits()};
    const auto& gradient = network_.gradient();
    return {{gradient.data(), gradient.data() + gradient.size()}, network_.decisions()};
  }

 private:
  static OneDnnNetwork made(const Problem& problem, const WorkerOptions& options) {
    if (options.engine != "best" && options.engine != "direct")
      throw Error(ErrorKind::usage, "--engine is '" + options.engine + "', expected best or direct");
    limit_threads(options.threads);
    return {problem, options.weights, options.wants_gradient, options.engine == "best"};
  }

  bool wants_gradient_;
  OneDnnNetwork network_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::OneDnnDetector>(argc, argv, "best or direct");
}
