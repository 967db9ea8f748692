#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/image/colour_space.hpp>
#include <utility>
#include <vector>

#include "contact_sheet.hpp"
#include "picture_detections.hpp"
#include "progress.hpp"
#include "stop_signal.hpp"
#include "view_list.hpp"

namespace tapestry::shell {

/// The views of a store that show the car; every other view adds a warning.
/// \throws Stopped when a signal arrives
inline std::vector<std::size_t> views_with_car(camouflage::ViewStore<float>& store,
                                               std::vector<std::string>& warnings) {
  auto usable =
      camouflage::usable_views(store, [](const camouflage::View<float>&) { StopSignal::throw_if_arrived(); });
  warnings.insert(warnings.end(), usable.warnings.begin(), usable.warnings.end());
  return std::move(usable.indices);
}

/// A picture with its detections, each with its class and score: in found_colour the car where it should be,
/// others in the colours of their classes.
inline MarkedPicture annotated(const evaluate::MeasuredPicture& measured, const evaluate::Meter& meter) {
  MarkedPicture marked{image::to_bytes(measured.picture)};
  const auto& names = meter.detector().names();
  for (const auto& detection : measured.result.detections)
    marked.boxes.push_back(
        {detection.box, label_of(class_name(detection.class_index, names), detection.confidence),
         meter.shows_car({detection}, measured.target) ? found_colour : class_colour(detection.class_index)});
  return marked;
}

/// Follows a survey: prints its progress, keeps the annotated pictures of some textures, and throws Stopped
/// when a signal has arrived.
class SurveyWatch {
 public:
  /// \param pictures  number of pictures to come
  /// \param side      longer side of the pictures
  SurveyWatch(const evaluate::Meter& meter, std::size_t pictures, std::size_t side)
      : meter_(meter), progress_(pictures), side_(side) {}

  /// From now on adds the pictures of a texture, of which there will be `pictures`, to a sheet, which must
  /// outlive the watch; of more than `most`, or than a sheet holds, those that are evenly spread.
  void collect(const std::string& texture, std::vector<MarkedPicture>& sheet, std::size_t pictures,
               std::size_t most = std::numeric_limits<std::size_t>::max()) {
    sheets_.insert({texture, {&sheet, pictures, std::min({pictures, most, most_on_a_sheet(side_)}), 0}});
  }

  /// Facts of the views so far, in the order of the survey; one entry a picture.
  [[nodiscard]] const std::vector<ViewFacts>& views() const { return views_; }

  void operator()(const evaluate::MeasuredPicture& measured) {
    StopSignal::throw_if_arrived();
    if (measured.texture == "clean") views_.push_back(facts_of(measured.view));
    const auto [begin, end] = sheets_.equal_range(measured.texture);
    for (auto sheet = begin; sheet != end; ++sheet)
      if (sheet->second.takes_next()) sheet->second.sheet->push_back(annotated(measured, meter_));
    progress_.count(measured.texture);
  }

 private:
  struct Collected {
    std::vector<MarkedPicture>* sheet;
    std::size_t pictures;  ///< of the texture
    std::size_t most;      ///< of them on the sheet
    std::size_t seen;

    bool takes_next() { return is_shown(seen++, most, pictures); }
  };

  const evaluate::Meter& meter_;
  std::vector<ViewFacts> views_;
  MeasuringProgress progress_;
  std::size_t side_;
  std::multimap<std::string, Collected> sheets_;
};

}  // namespace tapestry::shell
