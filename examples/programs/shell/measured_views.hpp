#pragma once
#include <array>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <utility>
#include <vector>

#include "csv.hpp"

namespace tapestry::shell {

/// What is known about a view beside how it fares.
struct ViewFacts {
  std::string name;
  double azimuth_deg;    ///< of the camera; 0 in front of the car, 90 at its left
  double elevation_deg;  ///< of the camera above the middle of the car
  double distance;       ///< from there, in halves of the car's length
  double hidden_share;   ///< of the car's silhouette, by the frame's mask
  std::size_t car_pixels;
};

inline ViewFacts facts_of(const camouflage::View<float>& view) {
  constexpr double deg_per_rad = 180 / std::numbers::pi;
  const auto& [azimuth_rad, elevation_rad, distance] = view.orbit;
  const double azimuth_deg = azimuth_rad * deg_per_rad;
  return {view.name,
          azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg,
          elevation_rad * deg_per_rad,
          distance,
          view.hidden_share,
          view.visible_pixels};
}

/// A measurement of the same views as others, under the name that tells it from those.
using NamedMeasurement = std::pair<std::string, const evaluate::Measurement*>;

/// How each picture of each view fared, for other programs: a line for each of them in each measurement.
/// \param views  one entry a picture of a measurement
inline std::string views_csv(const std::vector<ViewFacts>& views,
                             const std::vector<NamedMeasurement>& measurements) {
  std::string text =
      "view,azimuth_deg,elevation_deg,distance,hidden_share,car_pixels,picture,photograph,found,"
      "best_confidence\n";
  std::array<char, 200> numbers{};
  for (const auto& [name, measurement] : measurements)
    for (std::size_t i = 0; i < views.size(); ++i) {
      const ViewFacts& view = views[i];
      text += csv_field(view.name);
      std::snprintf(numbers.data(), numbers.size(), ",%.9g,%.9g,%.9g,%.9g,%zu,", view.azimuth_deg,
                    view.elevation_deg, view.distance, view.hidden_share, view.car_pixels);
      text += numbers.data() + csv_field(name);
      std::snprintf(numbers.data(), numbers.size(), ",%zu,%d,%.9g\n", i % measurement->draws + 1,
                    measurement->found[i] ? 1 : 0, measurement->best_confidence[i]);
      text += numbers.data();
    }
  return text;
}

}  // namespace tapestry::shell
