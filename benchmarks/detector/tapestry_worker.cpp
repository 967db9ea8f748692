// The detector as this library computes it.
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/batch.hpp>

#include "worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
const nn::Engine engines[] = {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                              nn::Engine::winograd_f4, nn::Engine::bfloat16};

/// The engine of a name; `tape` is the automatic one, called by way of the tape.
[[nodiscard]] nn::Engine engine_of(const std::string& name) {
  if (name == "tape") return nn::Engine::automatic;
  for (const nn::Engine engine : engines)
    if (name_of(engine) == name) return engine;
  throw Error(
      ErrorKind::usage,
      "--engine is '" + name + "', expected automatic, direct, winograd_f2, winograd_f4, bfloat16 or tape");
}

class TapestryDetector {
 public:
  TapestryDetector(const Problem& problem, const WorkerOptions& options)
      : problem_(problem),
        options_(options),
        detector_(model().detector()),
        picture_(image::pictures_of_planes(problem.picture)),
        is_taped_(options.engine == "tape") {
    detector_.set_engine(engine_of(options.engine));
    limit_threads(options.threads);
    if (options.wants_gradient) gradient_ = zeros<float, 4>(picture_.shape());
  }

  [[nodiscard]] std::string name() const { return "Tapestry " TAPESTRY_VERSION_TEXT; }

  void run() {
    if (gradient_.size() == 0) {
      detector_.forward(picture_, *pass_);
      return;
    }
    if (is_taped_) return run_on_tape();
    detector_.forward(picture_, *pass_, detect::Mode::input_gradient);
    gradient_.fill(0);
    detector_.input_adjoint(*pass_, problem_.weighting, gradient_);
  }

  [[nodiscard]] Answer answer() const {
    if (gradient_.size() > 0) {
      const auto planes = image::planes_of(gradient_);  // as all engines of this benchmark have pictures
      return {{planes.data(), planes.data() + planes.size()},
              decisions_of(problem_, model(), engine_of(options_.engine), picture_)};
    }
    Answer answer;
    for (const auto& logits : pass_->logits) append(answer.values, logits.data(), logits.size());
    return answer;
  }

 private:
  [[nodiscard]] detect::DarknetModel<float> model() const {
    return io::read_darknet_model<float>(problem_.config.name, options_.weights, options_.size, options_.size)
        .model;
  }

  void run_on_tape() {
    Tape<float> tape;
    const auto scope = tape.activate();
    const auto picture = tape.input(picture_);
    const auto logits = detect::forward(detector_, picture, pass_);
    Variable<float> loss = 0;
    for (std::size_t h = 0; h < logits.size(); ++h) loss += sum(problem_.weighting[h] * logits[h]);
    tape.reverse(loss);
    gradient_ = picture.adjoint();
  }

  const Problem& problem_;
  WorkerOptions options_;
  detect::Detector<float> detector_;
  Array<float, 4> picture_;  ///< [1, size, size, 3]
  bool is_taped_;
  std::shared_ptr<detect::Pass<float>> pass_ = std::make_shared<detect::Pass<float>>();
  Array<float, 4> gradient_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::TapestryDetector>(
      argc, argv, "automatic, direct, winograd_f2, winograd_f4, bfloat16 or tape");
}
