#pragma once
#include <concepts>
#include <cstddef>
#include <numeric>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <vector>

namespace tapestry::evaluate {

/// How a set of views fares with one texture.
struct Measurement {
  std::string name;
  std::vector<bool> found{};              ///< one entry a view: the car found at IoU ≥ ½
  std::vector<double> best_confidence{};  ///< one entry a view, see best_confidence()
  DetectionRate rate{};
  double mean_best_confidence = 0;     ///< over the views, 0 without any: a rate hides what a mean shows
  std::vector<DetectionRate> sweep{};  ///< the rate at each threshold of the meter's sweep
};

/// A picture as it was measured.
template <class T>
struct MeasuredPicture {
  const std::string& texture;  ///< the measurement's name
  const Array<T, 3>& picture;  ///< [H, W, 3]
  const camouflage::View<T>& view;
  const ViewResult& result;
};

/// Measures one texture, or the untouched frames when `colours` is null, in some views.
///
/// \param views    indices in the store
/// \param colours  [texel, 3] in [0, 1]
/// \param visit    called with each MeasuredPicture in order, to show or keep it; may give up by an exception
template <class T, std::invocable<const MeasuredPicture<T>&> Visit>
[[nodiscard]] Measurement measure(const std::string& name, Meter<T>& meter, camouflage::ViewStore<T>& store,
                                  const std::vector<std::size_t>& views, const Array<T, 2>* colours,
                                  Visit&& visit) {
  Measurement measurement{name};
  std::vector<std::vector<bool>> found_in_sweep(meter.settings().sweep.size());
  for (const std::size_t index : views) {
    const auto view = store.view(index);
    const Array<T, 3> picture =
        colours != nullptr ? camouflage::picture_of(*view, *colours) : view->background;
    const ViewResult result = meter.examine(picture, *view);
    measurement.found.push_back(result.found);
    measurement.best_confidence.push_back(result.best_confidence);
    for (std::size_t i = 0; i < found_in_sweep.size(); ++i)
      found_in_sweep[i].push_back(result.found_in_sweep[i]);
    visit(MeasuredPicture<T>{name, picture, *view, result});
  }
  measurement.rate = detection_rate(measurement.found);
  const auto& confidences = measurement.best_confidence;
  if (!confidences.empty())
    measurement.mean_best_confidence = std::accumulate(confidences.begin(), confidences.end(), 0.0) /
                                       static_cast<double>(confidences.size());
  for (const auto& found : found_in_sweep) measurement.sweep.push_back(detection_rate(found));
  return measurement;
}

}  // namespace tapestry::evaluate
