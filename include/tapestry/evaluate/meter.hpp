#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/pass_pool.hpp>
#include <tapestry/evaluate/best_confidence.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/loss/prediction.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

/// When a detector says that something is there.
struct MeterSettings {
  double confidence = 0.25;     ///< a detection's must be above it
  double nms = 0.45;            ///< IoU above which a weaker detection is suppressed
  std::vector<double> sweep{};  ///< further thresholds of confidence
};

/// The detections in the picture of a view, whether the car is among them, and how sure the detector is of
/// it.
struct ViewResult {
  std::vector<detect::Detection> detections{};  ///< above the confidence, most confident first
  bool found = false;
  std::vector<bool> found_in_sweep{};  ///< at each threshold of the sweep
  double found_confidence = 0;  ///< the car is found at every threshold below it, down to the least of the
                                ///< sweep's and the meter's own; 0 if at none of them
  double best_confidence = 0;   ///< of the car, whatever the thresholds; see best_confidence()
};

/// Measures pictures of views with one detector, at its confidence threshold and at those of a sweep.
///
/// The network runs once a picture. So does suppression: as it goes down in confidence, what it keeps above a
/// threshold does not depend on what lies below. Several threads may examine pictures at once, and each that
/// does holds a pass of the network.
template <std::floating_point T>
class Meter {
 public:
  /// \param detector     must outlive the meter
  /// \param class_index  of the car
  /// \throws DomainError if the detector has no such class
  Meter(const detect::Detector<T>& detector, std::size_t class_index, MeterSettings settings = {})
      : detector_(detector), class_index_(class_index), settings_(std::move(settings)) {
    detect::require_class("Meter", detector.heads(), class_index);
  }

  /// \param picture  [H, W, 3], at the size of the network's input
  /// \throws ShapeError for another size, NumericError for logits that are not finite
  [[nodiscard]] ViewResult examine(const Array<T, 3>& picture, const camouflage::View<T>& view) {
    return examine(picture, view.name, view.target);
  }

  /// \param name    of the picture, for errors
  /// \param target  the car's box in it
  [[nodiscard]] ViewResult examine(const Array<T, 3>& picture, const std::string& name,
                                   const detect::Box& target);

  /// Whether a car of this box is among the detections, see is_found().
  [[nodiscard]] bool shows_car(const std::vector<detect::Detection>& detections,
                               const detect::Box& target) const {
    return is_found(detections, {class_index_, target});
  }

  [[nodiscard]] const MeterSettings& settings() const { return settings_; }

 private:
  /// Of detections in order of confidence, those above a threshold.
  static std::vector<detect::Detection> above(double threshold,
                                              const std::vector<detect::Detection>& detections);

  const detect::Detector<T>& detector_;
  std::size_t class_index_;
  MeterSettings settings_;
  detect::PassPool<T> passes_;
};

extern template class Meter<float>;
extern template class Meter<double>;

}  // namespace tapestry::evaluate
