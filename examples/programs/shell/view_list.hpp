#pragma once
#include <tapestry/evaluate/measurement.hpp>
#include "run_folder.hpp"

namespace tapestry::shell {
struct ViewFacts {
  std::string name;
  double azimuth_deg;                    ///< of the camera; 0 in front of the car, 90 at its left
  double elevation_deg;                  ///< of the camera above the middle of the car
  double distance;                       ///< of the camera from that middle, in halves of the car's length
  double hidden_share;                   ///< of the car's silhouette, by the frame's mask
  double car_share;                      ///< of the picture that the car covers
  std::optional<double> registration{};  ///< see camouflage::View
  bool keeps_photograph = false;         ///< see camouflage::View
  double kept_share = 0;                 ///< of the car's pixels, those that show the photograph alone
  std::optional<bool> shows_car{};       ///< see camouflage::View
};

double car_share_of(const camouflage::View<float>& view);

ViewFacts facts_of(const camouflage::View<float>& view);

using NamedMeasurement = std::pair<std::string, const evaluate::Measurement*>;

/// Measured views, each possibly several times.
struct ViewList {
  std::vector<ViewFacts> views{};                ///< one entry a picture of a measurement
  std::vector<NamedMeasurement> measurements{};  ///< of these views; must outlive the list
  std::string sorted_by{};                       ///< the measurement that a page sorts by at first
};

/// Sentences on the photographs of views: number of views, and share of the car, where faces without paint
/// show the photograph; the mask that fits worst; photographs where the detector finds no car. None if no
/// photograph was to be kept.
std::vector<std::string> words_on_photographs(const ViewList& list);

/// Results of each picture of each view, for other programs: a line for each of them and each measurement.
std::string views_csv(const ViewList& list);

/// Data of a list for the script of a page. Each view has its name, its place and, for each measurement, its
/// mean best confidence and the share of its pictures with a found car.
Json list_json(const ViewList& list);

/// The heading and the empty table, which the script of a page fills. \param remarks HTML
std::string list_html(const ViewList& list, const std::string& remarks);
}  // namespace tapestry::shell
