#pragma once
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <utility>
#include <vector>

#include "contact_sheet.hpp"
#include "finite_logits.hpp"
#include "inputs.hpp"
#include "stop_signal.hpp"

namespace tapestry::examples {

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
};

/// The picture of a view, its detections and whether the car is among them.
struct ViewResult {
  std::vector<detect::Detection> detections;
  bool found = false;
};

/// Measures pictures of views with one detector and one set of thresholds.
class Meter {
 public:
  Meter(const detect::Network<float>& network, std::size_t class_index, const DetectorSettings& settings)
      : network_(network), class_index_(class_index), settings_(settings) {}

  /// \param picture  [3, H, W], at the size of the network's input
  [[nodiscard]] ViewResult examine(const float* picture, const camouflage::View<float>& view) {
    const std::size_t height = network_.input_height();
    const std::size_t width = network_.input_width();
    Array<float, 4> batch(Extents<4>{1, 3, height, width});
    std::copy_n(picture, batch.size(), batch.data());
    network_.forward(batch, pass_);
    require_finite_logits(pass_.logits, view.name);
    auto candidates = detect::decode(network_.heads(), pass_.logits, 0, settings_.confidence, height, width);
    ViewResult result;
    result.detections = detect::suppress(std::move(candidates), settings_.nms);
    result.found = evaluate::is_found(result.detections, {class_index_, view.target});
    return result;
  }

  [[nodiscard]] std::size_t class_index() const { return class_index_; }
  [[nodiscard]] const detect::Network<float>& network() const { return network_; }

 private:
  const detect::Network<float>& network_;
  std::size_t class_index_;
  DetectorSettings settings_;
  detect::Pass<float> pass_;
};

/// A picture with its detections drawn: green the car where it should be, orange everything else.
inline Bitmap annotated(const float* picture, const ViewResult& result, const camouflage::View<float>& view,
                        std::size_t class_index) {
  Bitmap bitmap = bitmap_of(picture, view.mask.shape(0), view.mask.shape(1));
  for (const auto& detection : result.detections) {
    const bool counts = evaluate::is_found({detection}, {class_index, view.target});
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
  for (const std::size_t index : usable) {
    StopSignal::throw_if_arrived();
    const auto view = store.view(index);
    const camouflage::View<float>* views[] = {view.get()};
    const Array<float, 4> composed =
        colours != nullptr ? camouflage::Objective<float>::pictures_of(*colours, views) : Array<float, 4>();
    const float* picture = colours != nullptr ? composed.data() : view->background.data();
    const ViewResult result = meter.examine(picture, *view);
    measurement.found.push_back(result.found);
    if (sheet != nullptr) sheet->push_back(annotated(picture, result, *view, meter.class_index()));
  }
  measurement.rate = evaluate::detection_rate(measurement.found);
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

}  // namespace tapestry::examples
