#include "view_list.hpp"

#include "csv.hpp"
#include "report.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
double car_share_of(const camouflage::View<float>& view) {
  double covered = 0;
  for (const float coverage : view.paint_to_picture->coverage) covered += static_cast<double>(coverage);
  return 3 * covered / static_cast<double>(view.background.size());
}

ViewFacts facts_of(const camouflage::View<float>& view) {
  constexpr double deg_per_rad = 180 / std::numbers::pi;
  const auto& [azimuth_rad, elevation_rad, distance] = view.orbit;
  const double azimuth_deg = azimuth_rad * deg_per_rad;
  return {view.name,
          azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg,
          elevation_rad * deg_per_rad,
          distance,
          view.hidden_share,
          car_share_of(view),
          view.registration,
          view.keeps_photograph,
          view.keeps_photograph && view.visible_pixels > 0
              ? 1 - static_cast<double>(view.paint_to_picture->pixels.size()) /
                        static_cast<double>(view.visible_pixels)
              : 0,
          view.shows_car};
}

std::vector<std::string> words_on_photographs(const ViewList& list) {
  constexpr double no_confidence = 0.01;
  const auto row = std::ranges::find(list.measurements, std::string("photo"), &NamedMeasurement::first);
  const std::size_t draws = list.measurements.empty() ? 1 : list.measurements.front().second->draws;
  double kept_share = 0;
  const ViewFacts* least = nullptr;
  std::vector<const ViewFacts*> kept, without, doubtful;
  const auto such_as = [](const std::vector<const ViewFacts*>& views) {
    return "in " + std::to_string(views.size()) + " view(s), such as " + views.front()->name + ", ";
  };
  for (std::size_t i = 0; i < list.views.size(); i += draws) {
    const ViewFacts& view = list.views[i];
    if (view.registration && (least == nullptr || *view.registration < *least->registration)) least = &view;
    if (!view.shows_car.value_or(true)) without.push_back(&view);
    if (!view.keeps_photograph) continue;
    kept.push_back(&view);
    kept_share += view.kept_share;
    if (row != list.measurements.end() && row->second->best_confidence[i] < no_confidence)
      doubtful.push_back(&view);
  }
  if (kept.empty() && without.empty() && least == nullptr) return {};
  std::vector<std::string> words{"faces without paint show the photograph in " + std::to_string(kept.size()) +
                                 " of " + std::to_string(list.views.size() / draws) + " views"};
  if (!kept.empty())
    words.back() += " (" + percent_text(kept_share / static_cast<double>(kept.size())) +
                    " of the car's pixels are the photograph's)";
  if (least != nullptr && *least->registration < camouflage::least_registration)
    words.back() += "; in the others their materials, since the mask is not the car's silhouette, as in " +
                    least->name + " (IoU " + decimal_text(*least->registration) + ", needed " +
                    decimal_text(camouflage::least_registration) + ")";
  if (!without.empty())
    words.push_back(such_as(without) +
                    "there is no mask and the detector finds no car where the mesh is: their photographs "
                    "give no light and no pixels");
  if (!doubtful.empty())
    words.push_back(such_as(doubtful) +
                    "the untouched photograph, whose pixels the car shows, has less than .01 of confidence "
                    "in a car there: does it hold the car?");
  return words;
}

std::string views_csv(const ViewList& list) {
  std::string text =
      "view,azimuth_deg,elevation_deg,distance,hidden_share,car_share,registration,picture,photograph,found,"
      "best_confidence\n";
  for (const auto& [name, measurement] : list.measurements)
    for (std::size_t i = 0; i < list.views.size(); ++i) {
      const ViewFacts& view = list.views[i];
      text += csv_line(csv_field(view.name), view.azimuth_deg, view.elevation_deg, view.distance,
                       view.hidden_share, view.car_share,
                       view.registration ? formatted("%.9g", *view.registration) : std::string(),
                       csv_field(name), i % measurement->draws + 1, measurement->found[i] ? 1 : 0,
                       measurement->best_confidence[i]) +
              "\n";
    }
  return text;
}

Json list_json(const ViewList& list) {
  Json json = {{"textures", Json::array()}, {"views", Json::array()}, {"sorted", list.sorted_by}};
  for (const auto& [name, measurement] : list.measurements) json["textures"].push_back(name);
  const std::size_t draws = list.measurements.empty() ? 1 : list.measurements.front().second->draws;
  const auto rounded = [](double value, double steps) { return std::round(value * steps) / steps; };
  for (std::size_t i = 0; i < list.views.size() / draws; ++i) {
    const ViewFacts& facts = list.views[i * draws];
    Json view = {{"index", i},
                 {"name", facts.name},
                 {"place",
                  {rounded(facts.azimuth_deg, 10), rounded(facts.elevation_deg, 10),
                   rounded(facts.distance, 100), rounded(100 * facts.hidden_share, 1)}},
                 {"picture", -1},
                 {"scores", Json::array()}};
    for (const auto& [name, measurement] : list.measurements) {
      double best = 0, found = 0;
      for (std::size_t k = i * draws; k < (i + 1) * draws; ++k) {
        best += measurement->best_confidence[k] / static_cast<double>(draws);
        found += measurement->found[k] ? 1 / static_cast<double>(draws) : 0;
      }
      view["scores"].push_back({rounded(best, 1e4), rounded(found, 1e4)});
    }
    json["views"].push_back(view);
  }
  return json;
}

std::string list_html(const ViewList& list, const std::string& remarks) {
  constexpr std::size_t most_on_paper = 200;
  if (list.views.empty()) return {};
  return "<h2>Views</h2>\n<p>Best confidence of each view; a heading sorts" + remarks +
         ". Azimuth of the camera: 0 in front of the car, 90 at its left. Distance: from the middle of the "
         "car, in halves of its length. Hidden: of the car's silhouette, by what stands before it.</p>\n<p "
         "class=\"hands\"><label>name <input id=\"search\" type=\"search\"></label> <label>show <select "
         "id=\"only\"><option value=\"\">all</option></select></label> <span id=\"count\"></span></p>\n<div "
         "class=\"wide list" +
         std::string(list.views.size() > most_on_paper ? " hands" : "") +
         "\" tabindex=\"0\"><table id=\"views\"></table></div>\n";
}
}  // namespace tapestry::shell
