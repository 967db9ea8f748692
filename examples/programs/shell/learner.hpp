#pragma once
#include <tapestry/loss/yolox_training.hpp>
#include <tapestry/optim/adam.hpp>
#include "learning_detector.hpp"
#include "settings.hpp"

namespace tapestry::shell {
/// A number of a step, with its name in history.csv.
template <class Step>
struct StepNumber {
  const char* name;
  double Step::*value;
};

struct LossTerms {
  double box = 0, objectness = 0, classification = 0, total = 0;
  static const std::array<StepNumber<LossTerms>, 4> all;
};
inline constexpr std::array<StepNumber<LossTerms>, 4> LossTerms::all{
    {{"box", &LossTerms::box},
     {"objectness", &LossTerms::objectness},
     {"classification", &LossTerms::classification},
     {"total", &LossTerms::total}}};

/// Steps of a detector's weights by Adam, down loss::yolo_training() or, for heads without anchors,
/// loss::yolox_training().
class Learner {
 public:
  /// \param detector  must outlive this
  /// \param program   named in messages
  Learner(LearningDetector& detector, const char* program)
      : detector_(detector), program_(program), adam_(detector.weights().size()) {}

  [[nodiscard]] const optim::AdamState<float>& state() const { return adam_.state(); }
  void restore(const optim::AdamState<float>& state) { adam_.restore(state); }

  /// \param number  of the step, from 1, for messages
  /// \throws NumericError if the loss or a gradient is not finite
  LossTerms step(const Array<float, 4>& pictures, const loss::Truths& truths, double rate,
                 std::uint64_t number) {
    const std::string in_step = " in step " + std::to_string(number);
    tape_.clear();
    const auto scope = tape_.activate();
    const ArrayVariable<float, 4> images = pictures;
    auto values = detector_.weights();
    const auto weights = tape_.input(values);
    const auto terms = terms_of(detector_.forward(images, weights), truths, in_step);
    if (!std::isfinite(terms.total.value()))
      throw NumericError(program_ + ": the detector's loss" + in_step + " is not finite");
    tape_.reverse(terms.total);
    adam_.set_learning_rate(rate);
    const auto gradient = weights.adjoint();
    if (!are_finite({gradient.data(), gradient.size()}))
      throw NumericError(program_ + ": the gradient of the weights" + in_step + " is not finite");
    adam_.step(values, gradient);
    detector_.take_step(values);
    const auto number_of = [](const Variable<float>& term) { return static_cast<double>(term.value()); };
    return {number_of(terms.box), number_of(terms.objectness), number_of(terms.classification),
            number_of(terms.total)};
  }

 private:
  /// \throws NumericError naming the step, for logits that are not finite
  [[nodiscard]] loss::YoloTrainingVariables<float> terms_of(
      const std::vector<ArrayVariable<float, 4>>& logits, const loss::Truths& truths,
      const std::string& in_step) const try {
    const auto& detector = detector_.detector();
    if (detect::has_anchors(detector.heads().front().decode))
      return loss::yolo_training(detector, logits, truths);
    return loss::yolox_training(detector, logits, truths);
  } catch (const NumericError& error) {
    throw NumericError(program_ + ": the detector's loss" + in_step + ": " + error.what());
  }

  LearningDetector& detector_;
  std::string program_;
  optim::Adam<float> adam_;
  Tape<float> tape_;
};

inline void require_trainable_heads(const char* program, const detect::Detector<float>& detector,
                                    const std::string& path) {
  loss::require_raw_logits(program, detector.heads());
  for (const auto& head : detector.heads())
    if (head.decode == detect::DecodeFamily::decoded)
      throw file_mismatch({path, "", "a head that cannot be trained",
                           "heads of raw outputs, as darknet, ultralytics, yolov5, yolox, nanodet or yolov8",
                           "boxes and scores that the network has decoded"});
}

/// A second copy of the detector that these settings name, to train.
inline std::unique_ptr<LearningDetector> learning_detector(const detect::Detector<float>& detector,
                                                           const DetectorSettings& settings) {
  if (io::is_onnx(settings.weights) && !io::is_of_darknet(io::read_onnx(settings.weights)))
    return std::make_unique<LearningGraph>(settings.weights, io::read_text_file(settings.weights), detector,
                                           settings.size);
  std::optional<detect::DecodeFamily> decode;
  if (!settings.decode.empty()) decode = detect::decode_family_by_name(settings.decode);
  return std::make_unique<LearningModel>(
      io::read_darknet_model<float>(settings.cfg, settings.weights, settings.size, settings.size, decode)
          .model,
      trainable_cfg(settings.cfg, settings.weights), detector.names(), detector.fit());
}
}  // namespace tapestry::shell
