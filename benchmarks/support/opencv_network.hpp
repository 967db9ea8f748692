#pragma once
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::benchmarks {
/// A network in OpenCV's dnn module, forward only.
class OpenCvNetwork {
 public:
  /// \param options  of the worker
  /// \param picture  its values, [1, 3, size, size]
  template <class Options>
  OpenCvNetwork(cv::dnn::Net network, const Options& options, std::vector<float> picture)
      : network_(std::move(network)), picture_values_(std::move(picture)) {
    if (options.wants_gradient) throw Error(ErrorKind::usage, "OpenCV has no gradient");
    cv::setNumThreads(options.threads);
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    const auto size = static_cast<int>(options.size);
    const int shape[] = {1, 3, size, size};
    picture_ = cv::Mat(4, shape, CV_32F, picture_values_.data());
  }

  [[nodiscard]] std::string name() const { return "OpenCV " CV_VERSION; }

  void run() {
    network_.setInput(picture_);
    network_.forward(outputs_, output_names_);
  }

 protected:
  /// Outputs of the last pass, one after the other.
  [[nodiscard]] std::vector<float> values() const {
    std::vector<float> values;
    for (const cv::Mat& output : outputs_)
      values.insert(values.end(), output.ptr<float>(), output.ptr<float>() + output.total());
    return values;
  }

  std::vector<cv::String> output_names_{};

 private:
  cv::dnn::Net network_;
  std::vector<float> picture_values_;
  cv::Mat picture_;
  std::vector<cv::Mat> outputs_{};
};
}  // namespace tapestry::benchmarks
