// An ONNX network as this library computes it.

#include "graph_run.hpp"

namespace tapestry::benchmarks {
namespace {
class TapestryNetwork {
 public:
  explicit TapestryNetwork(const NetworkOptions& options)
      : run_(options), wants_gradient_(options.wants_gradient) {
    limit_threads(options.threads);
  }
  [[nodiscard]] std::string name() const { return "Tapestry " TAPESTRY_VERSION_TEXT; }
  void run() {
    run_.forward(wants_gradient_ ? nn::Mode::input_gradient : nn::Mode::inference);
    if (wants_gradient_) run_.adjoint();
  }
  [[nodiscard]] std::vector<float> answer() const {
    return wants_gradient_ ? run_.gradient() : run_.outputs();
  }

 private:
  GraphRun<float> run_;
  bool wants_gradient_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_network_worker<tapestry::benchmarks::TapestryNetwork>(argc, argv);
}
