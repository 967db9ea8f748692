#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour.hpp>
#include <utility>
#include <vector>

#include "contact_sheet.hpp"
#include "finite_logits.hpp"
#include "inputs.hpp"
#include "progress.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {

/// The views of a store that show the car, with a warning for each that does not.
/// \throws Stopped when a signal arrives meanwhile
inline std::vector<std::size_t> usable_views(camouflage::ViewStore<float>& store,
                                             std::vector<std::string>& warnings) {
  std::vector<std::size_t> usable;
  store.for_each([&](std::size_t i, const camouflage::View<float>& view) {
    StopSignal::throw_if_arrived();
    if (view.visible_pixels > 0)
      usable.push_back(i);
    else
      warnings.push_back("frame " + view.name + " does not show the car and is left out");
  });
  return usable;
}

/// How a set of views fares with one texture.
struct Measurement {
  std::string name;
  std::vector<bool> found;  ///< one entry a view: the car found at IoU ≥ ½
  evaluate::DetectionRate rate;
  std::vector<evaluate::DetectionRate> sweep;  ///< the rate at each further threshold of the meter
};

/// The detections in the picture of a view, and whether the car is among them.
struct ViewResult {
  std::vector<detect::Detection> detections;
  bool found = false;
  std::vector<bool> found_in_sweep;  ///< at each further threshold of the meter
};

/// Measures pictures of views with one detector, at its confidence threshold and at those of a sweep.
///
/// The network runs once a picture. So does suppression: as it goes down in confidence, what it keeps above a
/// threshold does not depend on what lies below.
class Meter {
 public:
  Meter(const detect::Network<float>& network, std::size_t class_index, const DetectorSettings& settings,
        std::vector<double> sweep = {})
      : network_(network), class_index_(class_index), settings_(settings), sweep_(std::move(sweep)) {}

  /// \param picture  [H, W, 3], at the size of the network's input
  [[nodiscard]] ViewResult examine(const Array<float, 3>& picture, const camouflage::View<float>& view) {
    const std::size_t height = network_.input_height();
    const std::size_t width = network_.input_width();
    network_.forward(image::batch_of(picture), pass_);
    require_finite_logits(pass_.logits, view.name);
    double least = settings_.confidence;
    for (const double threshold : sweep_) least = std::min(least, threshold);
    const auto kept = detect::suppress(
        detect::decode(network_.heads(), pass_.logits, 0, least, height, width), settings_.nms);
    ViewResult result;
    result.detections = above(settings_.confidence, kept);
    result.found = shows_car(result.detections, view);
    for (const double threshold : sweep_)
      result.found_in_sweep.push_back(shows_car(above(threshold, kept), view));
    return result;
  }

  /// From now on says how far it is, with `pictures` to come.
  void announce(std::size_t pictures) { progress_.emplace(pictures); }

  /// Counts a picture of a texture as examined.
  void count(const std::string& texture) {
    if (progress_) progress_->count(texture);
  }

  /// Whether the car of the view is among the detections.
  [[nodiscard]] bool shows_car(const std::vector<detect::Detection>& detections,
                               const camouflage::View<float>& view) const {
    return evaluate::is_found(detections, {class_index_, view.target});
  }

  [[nodiscard]] const std::vector<double>& sweep() const { return sweep_; }

 private:
  /// Of detections in order of confidence, those above a threshold.
  static std::vector<detect::Detection> above(double threshold,
                                              const std::vector<detect::Detection>& detections) {
    const auto is_above = [=](const detect::Detection& detection) {
      return detection.confidence > threshold;
    };
    return {detections.begin(), std::partition_point(detections.begin(), detections.end(), is_above)};
  }

  const detect::Network<float>& network_;
  std::size_t class_index_;
  DetectorSettings settings_;
  std::vector<double> sweep_;
  detect::Pass<float> pass_;
  std::optional<MeasuringProgress> progress_;
};

/// A picture with its detections drawn: green the car where it should be, orange everything else.
inline Bitmap annotated(const Array<float, 3>& picture, const ViewResult& result,
                        const camouflage::View<float>& view, const Meter& meter) {
  Bitmap bitmap = image::to_bytes(picture);
  for (const auto& detection : result.detections) {
    const bool counts = meter.shows_car({detection}, view);
    draw_box(bitmap, detection.box,
             counts ? std::array<std::uint8_t, 3>{40, 220, 60} : std::array<std::uint8_t, 3>{255, 150, 0});
  }
  return bitmap;
}

/// Measures one texture, or the untouched frames when `colours` is null, in every usable view.
/// With `sheet`, the annotated pictures are added to it.
/// \throws Stopped when a signal arrives meanwhile
inline Measurement measure(const std::string& name, Meter& meter, camouflage::ViewStore<float>& store,
                           const std::vector<std::size_t>& usable, const Array<float, 2>* colours,
                           std::vector<Bitmap>* sheet = nullptr) {
  Measurement measurement;
  measurement.name = name;
  std::vector<std::vector<bool>> found_in_sweep(meter.sweep().size());
  for (const std::size_t index : usable) {
    StopSignal::throw_if_arrived();
    const auto view = store.view(index);
    const Array<float, 3> picture =
        colours != nullptr ? camouflage::picture_of(*view, *colours) : view->background;
    const ViewResult result = meter.examine(picture, *view);
    measurement.found.push_back(result.found);
    for (std::size_t i = 0; i < found_in_sweep.size(); ++i)
      found_in_sweep[i].push_back(result.found_in_sweep[i]);
    if (sheet != nullptr) sheet->push_back(annotated(picture, result, *view, meter));
    meter.count(name);
  }
  measurement.rate = evaluate::detection_rate(measurement.found);
  for (const auto& found : found_in_sweep) measurement.sweep.push_back(evaluate::detection_rate(found));
  return measurement;
}

inline nlohmann::ordered_json json_of(const Measurement& measurement) {
  return {{"views", measurement.rate.views},
          {"detected", measurement.rate.detected},
          {"p_at_50", measurement.rate.p_at_50},
          {"interval", measurement.rate.interval}};
}

/// A control: a texture that was not optimised.
struct Control {
  std::string name;
  Array<float, 2> colours;
};

/// Random noise and five solid colours.
inline std::vector<Control> make_controls(std::size_t texel_count, std::uint64_t seed) {
  Random random = Random(seed).fork(0x636F6E74726F6CULL);
  std::vector<Control> controls;
  controls.push_back({"random", camouflage::random_colours<float>(texel_count, random)});
  const std::vector<std::pair<const char*, std::array<double, 3>>> solids{{"white", {0.95, 0.95, 0.95}},
                                                                          {"black", {0.05, 0.05, 0.05}},
                                                                          {"red", {0.75, 0.08, 0.08}},
                                                                          {"green", {0.1, 0.5, 0.15}},
                                                                          {"blue", {0.1, 0.2, 0.7}}};
  for (const auto& [name, colour] : solids)
    controls.push_back({name, camouflage::solid_colours<float>(texel_count, colour)});
  return controls;
}

}  // namespace tapestry::shell
