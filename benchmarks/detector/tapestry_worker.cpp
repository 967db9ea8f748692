// The detector as this library computes it.
#include <cstddef>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/version.hpp>

#include "worker_program.hpp"

namespace tapestry::benchmarks {
namespace {

const nn::Engine engines[] = {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                              nn::Engine::winograd_f4};

[[nodiscard]] nn::Engine engine_of(const std::string& name) {
  for (const nn::Engine engine : engines)
    if (name_of(engine) == name) return engine;
  throw Error(ErrorKind::usage,
              "--engine is '" + name + "', expected automatic, direct, winograd_f2 or winograd_f4");
}

class TapestryDetector {
 public:
  TapestryDetector(const Problem& problem, const WorkerOptions& options)
      : problem_(problem), network_(problem.config, options.size, options.size) {
    network_.set_engine(engine_of(options.engine));
    limit_threads(options.threads);
    network_.read_weights(options.weights);
    if (options.wants_gradient) gradient_ = zeros<float, 4>(problem.picture.shape());
  }

  [[nodiscard]] std::string name() const { return "Tapestry " TAPESTRY_VERSION_TEXT; }

  void run() {
    if (gradient_.size() == 0) {
      network_.forward(problem_.picture, pass_);
      return;
    }
    network_.forward(problem_.picture, pass_, detect::Mode::input_gradient);
    gradient_.fill(0);
    network_.input_adjoint(pass_, problem_.weighting, gradient_);
  }

  [[nodiscard]] Answer answer() const {
    if (gradient_.size() > 0)
      return {{gradient_.data(), gradient_.data() + gradient_.size()}, decisions_of(problem_, pass_)};
    Answer answer;
    for (const auto& logits : pass_.logits) append(answer.values, logits.data(), logits.size());
    return answer;
  }

 private:
  const Problem& problem_;
  detect::Network<float> network_;
  detect::Pass<float> pass_;
  Array<float, 4> gradient_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::TapestryDetector>(
      argc, argv, "automatic, direct, winograd_f2 or winograd_f4");
}
