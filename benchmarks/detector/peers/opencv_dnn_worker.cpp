// The detector in OpenCV's dnn module, forward only.
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {

class OpenCvDetector {
 public:
  OpenCvDetector(const Problem& problem, const WorkerOptions& options)
      : network_(cv::dnn::readNetFromDarknet(options.cfg, options.weights)) {
    if (options.wants_gradient) throw Error(ErrorKind::usage, "OpenCV has no gradient");
    cv::setNumThreads(options.threads);
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    const auto size = static_cast<int>(options.size);
    const int shape[] = {1, 3, size, size};
    picture_ = cv::Mat(4, shape, CV_32F, const_cast<float*>(problem.picture.data()));
    for (const std::size_t head : problem.heads) logit_names_.push_back("conv_" + std::to_string(head - 1));
  }

  [[nodiscard]] std::string name() const { return "OpenCV " CV_VERSION; }

  void run() {
    network_.setInput(picture_);
    network_.forward(logits_, logit_names_);
  }

  [[nodiscard]] Answer answer() const {
    Answer answer;
    for (const cv::Mat& logits : logits_) append(answer.values, logits.ptr<float>(), logits.total());
    return answer;
  }

 private:
  cv::dnn::Net network_;
  cv::Mat picture_;
  std::vector<cv::String> logit_names_;
  std::vector<cv::Mat> logits_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::OpenCvDetector>(argc, argv, "has one");
}
