// An ONNX network in OpenCV's dnn module, forward only.
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../problem.hpp"

namespace tapestry::benchmarks {
namespace {

class OpenCvNetwork {
 public:
  explicit OpenCvNetwork(const NetworkOptions& options)
      : network_(cv::dnn::readNetFromONNX(options.model)), values_(read_numbers<float>(options.input)) {
    if (options.wants_gradient) throw Error(ErrorKind::usage, "OpenCV has no gradient");
    cv::setNumThreads(options.threads);
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    const auto size = static_cast<int>(options.size);
    const int shape[] = {1, 3, size, size};
    picture_ = cv::Mat(4, shape, CV_32F, values_.data());
    for (const std::string& output : io::read_onnx(options.model).outputs) output_names_.push_back(output);
  }

  [[nodiscard]] std::string name() const { return "OpenCV " CV_VERSION; }

  void run() {
    network_.setInput(picture_);
    network_.forward(outputs_, output_names_);
  }

  void save(const std::string& path) {
    std::vector<float> values;
    for (const cv::Mat& output : outputs_)
      values.insert(values.end(), output.ptr<float>(), output.ptr<float>() + output.total());
    write_numbers(path, values);
  }

 private:
  cv::dnn::Net network_;
  std::vector<float> values_;
  cv::Mat picture_;
  std::vector<cv::String> output_names_;
  std::vector<cv::Mat> outputs_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_network_worker<tapestry::benchmarks::OpenCvNetwork>(argc, argv);
}
