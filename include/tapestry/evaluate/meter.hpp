#pragma once
#include <tapestry/detect/detector.hpp>
#include <tapestry/evaluate/average_precision.hpp>
#include <tapestry/evaluate/detail/fate.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/views.hpp>

namespace tapestry::evaluate {
/// Thresholds of a detection.
struct MeterSettings {
  double confidence = 0.25;     ///< a detection's must be above it
  double nms = 0.45;            ///< IoU above which a weaker detection is suppressed
  std::vector<double> sweep{};  ///< further thresholds of confidence
};

/// The detections in the picture of a view, whether the car is among them, and the detector's confidence in
/// it.
struct ViewResult {
  std::vector<detect::Detection> detections{};  ///< above the confidence, most confident first
  bool found = false;
  ViewOutcome outcome{};              ///< found, renamed, lost, …, of those detections
  double found_confidence = 0;        ///< the car is found at each threshold below it, down to
                                      ///< ranked_confidence; 0 if at none of them
  double best_confidence = 0;         ///< of the car, whatever the thresholds; see best_confidence()
  std::vector<BoxOnTarget> ranked{};  ///< boxes for average precision, see ranked_confidence
};

/// Boxes of the car's class above this confidence, at most `most_ranked` of a picture and the surest, count
/// for average precision.
inline constexpr double ranked_confidence = 0.001;
inline constexpr std::size_t most_ranked = 16;  ///< see ranked_confidence

/// The result of a picture, from the detections of any detector.
///
/// \param kept             after suppression, most confident first; those above the least threshold suffice
/// \param best_confidence  see ViewResult
/// \param target           the car
/// \param related          classes that count as similar to its own, see related_classes()
[[nodiscard]] ViewResult view_result(const std::vector<detect::Detection>& kept, double best_confidence,
                                     const loss::Target& target, const std::vector<std::size_t>& related,
                                     const MeterSettings& settings);

/// Measures pictures of views with one detector, at its confidence threshold and at a sweep's thresholds.
///
/// The network runs once a picture, and so does suppression: going down in confidence, the kept detections
/// above a threshold do not depend on those below. Several threads may examine pictures at once; each then
/// holds a pass of the network.
class Meter {
 public:
  /// \param detector     must outlive the meter
  /// \param class_index  of the car
  /// \throws DomainError if the detector has no such class
  Meter(const detect::Detector<float>& detector, std::size_t class_index, MeterSettings settings = {})
      : detector_(detector),
        class_index_(class_index),
        related_(related_classes(detector.names(), class_index)),
        settings_(std::move(settings)) {
    detect::require_class("Meter", detector.heads(), class_index);
  }

  /// \param picture  [H, W, 3], at the size of the network's input
  /// \throws ShapeError for another size, NumericError for logits that are not finite
  [[nodiscard]] ViewResult examine(const Array<float, 3>& picture, const camouflage::View<float>& view) {
    return examine(picture, view.name, view.target);
  }

  /// \param name    of the picture, for errors
  /// \param target  the car's box in it
  [[nodiscard]] ViewResult examine(const Array<float, 3>& picture, const std::string& name,
                                   const detect::Box& target);

  /// Whether a car of this box is among the detections, see is_found().
  [[nodiscard]] bool shows_car(const std::vector<detect::Detection>& detections,
                               const detect::Box& target) const {
    return is_found(detections, {class_index_, target});
  }

  [[nodiscard]] const MeterSettings& settings() const { return settings_; }
  [[nodiscard]] const detect::Detector<float>& detector() const { return detector_; }

 private:
  const detect::Detector<float>& detector_;
  std::size_t class_index_;
  std::vector<std::size_t> related_;  ///< classes
  MeterSettings settings_;
  detect::PassPool<float> passes_;
};

// The photographs of FCA's table 2: a painted toy car from eight directions, at three distances, in three
// surroundings. The paper prints its camouflages, glues them on and takes 144 photographs, two of each of
// these 72 settings; it states neither distances nor heights. Source: Wang et al., FCA (AAAI 2022), "Physical
// Adversarial Attack".

/// Surroundings × distances × directions, each photographed several times and also seen unchanged.
struct PhysicalGrid {
  std::size_t surroundings = 3;
  std::vector<double> distances{3, 4.5, 6};  ///< as ProtocolFrame's
  std::size_t azimuth_step_deg = 45;
  double elevation_deg = 20;
  std::size_t photographs = 2;  ///< of each view

  /// A first look: half of the directions, one photograph each.
  [[nodiscard]] static PhysicalGrid quick() { return {3, PhysicalGrid{}.distances, 90, 20, 1}; }

  /// Frames of each view: its photographs, then itself.
  [[nodiscard]] std::size_t frames_a_view() const { return photographs + 1; }
};

/// Content of one frame of physical_frames().
struct PhysicalFrame {
  std::size_t view = 0;                     ///< its number in the grid
  std::size_t surroundings = 0;             ///< where the car stands
  std::optional<std::size_t> photograph{};  ///< number of the view's photograph; none: the view itself
};

/// Surroundings × distances: first the photographed views, then the same views unchanged.
[[nodiscard]] ProtocolTable physical_table(const PhysicalGrid& grid);

/// The frames of a grid, by surroundings, then distance, then direction; for each view its photographs, then
/// the view itself.
/// \throws DomainError unless the azimuths divide a full turn and there is a photograph
[[nodiscard]] std::vector<ProtocolFrame> physical_frames(const PhysicalGrid& grid);

/// The content of frame number `frame` of physical_frames().
[[nodiscard]] PhysicalFrame physical_frame(const PhysicalGrid& grid, std::size_t frame);
}  // namespace tapestry::evaluate
