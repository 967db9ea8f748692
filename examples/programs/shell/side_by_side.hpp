#pragma once

#include "picture_sheet.hpp"
#include "report_page.hpp"
#include "survey_watch.hpp"

namespace tapestry::shell {

/// Some views, evenly spread, each with the photograph, the clean car, the noise matched to the camouflage,
/// and this, as far as they are measured.
class SideBySide {
 public:
  /// \param watch     of the survey; collects into this, which must stay where it is
  /// \param pictures  of each texture
  SideBySide(SurveyWatch& watch, std::size_t pictures) {
    for (Way& way : ways_)
      places_ = shown_places(watch.collect(way.texture, way.pictures, pictures, most_large_views), pictures);
  }
  SideBySide(const SideBySide&) = delete;
  SideBySide& operator=(const SideBySide&) = delete;

  /// A few of them in rows.
  /// \param views  facts of each picture
  [[nodiscard]] Bitmap sheet(const std::vector<ViewFacts>& views) const {
    constexpr std::size_t most_rows = 3, most_pixels = 416;  // of a picture's longer side
    const auto rows = shown_places(most_rows, places_.size());
    const auto columns = static_cast<std::size_t>(std::ranges::count_if(ways_, &SideBySide::is_measured));
    PictureSheet sheet(rows.size() * columns, columns);
    for (const std::size_t row : rows)
      for (const Way& way : ways_)
        if (is_measured(way))
          sheet.add(views.at(places_[row]).name + ": " + way.texture,
                    fitted_within(way.pictures[row], most_pixels));
    return sheet.bitmap();
  }

  /// All of them, for a page.
  [[nodiscard]] ViewPictures pictures() const {
    ViewPictures all{places_};
    for (const Way& way : ways_)
      if (is_measured(way)) all.ways.emplace_back(way.words, way.pictures);
    return all;
  }

 private:
  struct Way {
    std::string texture, words;
    std::vector<MarkedPicture> pictures{};
  };
  static bool is_measured(const Way& way) { return !way.pictures.empty(); }

  std::array<Way, 4> ways_{{{"photo", "the photograph"},
                            {"clean", "plain: the car in its own colours"},
                            {evaluate::matched_noise_name, "noise of the paint's colours"},
                            {"adversarial", "the paint"}}};
  std::vector<std::size_t> places_;
};

}  // namespace tapestry::shell
