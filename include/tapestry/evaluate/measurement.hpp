#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/image/transform/conditions.hpp>
#include <vector>

namespace tapestry::evaluate {

/// Photographs that stand for views as they are: some of each view, each under conditions of its own.
struct Photography {
  image::Conditions conditions{};
  std::size_t draws = 1;  ///< photographs of each view
  std::uint64_t seed = 1;
};

/// How a set of views fares with one texture.
struct Measurement {
  std::string name;
  std::size_t draws = 1;                  ///< pictures of each view, one behind the other
  std::vector<bool> found{};              ///< one entry a picture: the car found at IoU ≥ ½
  std::vector<double> best_confidence{};  ///< one entry a picture, see best_confidence()
  DetectionRate rate{};
  double mean_best_confidence = 0;     ///< over the pictures, 0 without any: a rate hides what a mean shows
  std::vector<DetectionRate> sweep{};  ///< the rate at each threshold of the meter's sweep
};

/// A picture as it was measured.
template <class T>
struct MeasuredPicture {
  const std::string& texture;  ///< the measurement's name
  const Array<T, 3>& picture;  ///< [H, W, 3]
  const camouflage::View<T>& view;
  const detect::Box& target;  ///< where the car is in the picture
  const ViewResult& result;
};

/// A picture of a view, and where the car is in it.
template <class T>
struct Photograph {
  Array<T, 3> picture;  ///< [H, W, 3]
  detect::Box target;
};

/// The picture of a view in a paint, or the untouched frame when `paint` is null, photographed if asked for:
/// the same conditions for every paint, the same print of a paint in every view.
///
/// \param view_index, draw  which view and which photograph of it: another one is under other conditions
template <class T>
[[nodiscard]] Photograph<T> photograph_of(const camouflage::View<T>& view, std::size_t view_index,
                                          const camouflage::Paint<T>* paint, const Photography& photography,
                                          std::size_t draw);

namespace detail {
/// Rates and means of what was found.
inline void summarise(Measurement& measurement, const std::vector<std::vector<bool>>& found_in_sweep,
                      std::size_t draws) {
  measurement.rate = detection_rate(measurement.found, draws);
  const auto& confidences = measurement.best_confidence;
  if (!confidences.empty())
    measurement.mean_best_confidence = std::accumulate(confidences.begin(), confidences.end(), 0.0) /
                                       static_cast<double>(confidences.size());
  for (const auto& found : found_in_sweep) measurement.sweep.push_back(detection_rate(found, draws));
}
}  // namespace detail

/// Measures one paint, or the untouched frames when `paint` is null, in some views: several pictures at once,
/// each on a thread of its own.
///
/// \param views        indices in the store
/// \param visit        called with each MeasuredPicture in order, to show or keep it; may give up by an
///                     exception
/// \param photography  what the views are photographed under; if left out, they are as they are
/// \throws DomainError if of each view none is drawn
template <class T, std::invocable<const MeasuredPicture<T>&> Visit>
[[nodiscard]] Measurement measure(const std::string& name, Meter<T>& meter, camouflage::ViewStore<T>& store,
                                  const std::vector<std::size_t>& views, const camouflage::Paint<T>* paint,
                                  Visit&& visit, const Photography& photography = {}) {
  if (photography.draws == 0) throw DomainError("measure: no photographs of a view");
  Measurement measurement{name, photography.draws};
  std::vector<std::vector<bool>> found_in_sweep(meter.settings().sweep.size());
  const std::size_t draws = photography.draws;
  using ViewPointer = typename camouflage::ViewStore<T>::ViewPointer;
  std::vector<ViewPointer> shown(views.size());  // those whose pictures are being made
  const auto making = std::make_unique<std::mutex[]>(views.size());
  const auto view_of = [&](std::size_t place) {
    const std::lock_guard lock(making[place]);
    if (!shown[place]) shown[place] = store.view(views[place]);
    return shown[place];
  };
  struct Examined {
    ViewPointer view;
    Photograph<T> photograph;
    ViewResult result;
  };
  const auto examine = [&](std::size_t i) {
    const std::size_t place = i / draws;
    Examined examined{view_of(place), {}, {}};
    examined.photograph = photograph_of(*examined.view, views[place], paint, photography, i % draws);
    examined.result =
        meter.examine(examined.photograph.picture, examined.view->name, examined.photograph.target);
    return examined;
  };
  for_each_in_order(views.size() * draws, examine, [&](std::size_t i, const Examined& examined) {
    const auto& [view, photograph, result] = examined;
    measurement.found.push_back(result.found);
    measurement.best_confidence.push_back(result.best_confidence);
    for (std::size_t k = 0; k < found_in_sweep.size(); ++k)
      found_in_sweep[k].push_back(result.found_in_sweep[k]);
    visit(MeasuredPicture<T>{name, photograph.picture, *view, photograph.target, result});
    if ((i + 1) % draws == 0) shown[i / draws].reset();
  });
  detail::summarise(measurement, found_in_sweep, photography.draws);
  return measurement;
}

}  // namespace tapestry::evaluate
