// The detector in Darknet as Debian packages it: forward only, on one thread.

#include "../worker_program.hpp"

extern "C" {
#include <darknet.h>
}

namespace tapestry::benchmarks {
namespace {
class DarknetDetector {
 public:
  DarknetDetector(const Problem& problem, const WorkerOptions& options) : problem_(problem) {
    if (options.wants_gradient || options.threads != 1)
      throw Error(ErrorKind::usage, "Darknet has no gradient to the picture and one thread");
    std::string cfg = options.cfg;
    std::string weights = options.weights;
    network_ = load_network(cfg.data(), weights.data(), 0);
    set_batch_network(network_, 1);
    const auto size = static_cast<int>(options.size);
    if (network_->w != size || network_->h != size) resize_network(network_, size, size);
    picture_ = problem.picture;
  }
  DarknetDetector(const DarknetDetector&) = delete;
  DarknetDetector& operator=(const DarknetDetector&) = delete;
  ~DarknetDetector() { free_network(network_); }

  [[nodiscard]] std::string name() const { return "Darknet of 2018"; }

  void run() { network_predict(network_, picture_.data()); }

  [[nodiscard]] Answer answer() const {
    Answer answer;
    for (const std::size_t head : problem_.heads) {
      const ::layer& before = network_->layers[head - 1];  // a linear convolution: its output are the logits
      append(answer.values, before.output, static_cast<std::size_t>(before.outputs));
    }
    return answer;
  }

 private:
  const Problem& problem_;
  ::network* network_ = nullptr;
  Array<float, 4> picture_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::DarknetDetector>(argc, argv, "has one");
}
