#pragma once
#include <tapestry/evaluate/controls.hpp>

#include "picture_sheet.hpp"
#include "survey_watch.hpp"

namespace tapestry::shell {

/// A few views, evenly spread, each in a row with the photograph, the clean car, the camouflage and the noise
/// matched to it, as far as they are measured.
class SideBySide {
 public:
  /// \param watch     of the survey; collects into this, which must stay where it is
  /// \param pictures  of each texture
  SideBySide(SurveyWatch& watch, std::size_t pictures) {
    for (auto& [texture, collected] : columns_) watch.collect(texture, collected, pictures, most_views);
    for (std::size_t i = 0; i < pictures; ++i)
      if (is_shown(i, std::min(most_views, pictures), pictures)) places_.push_back(i);
  }
  SideBySide(const SideBySide&) = delete;
  SideBySide& operator=(const SideBySide&) = delete;

  /// \param views  facts of each picture
  [[nodiscard]] Bitmap sheet(const std::vector<ViewFacts>& views) const {
    std::vector<const Column*> measured;
    for (const Column& column : columns_)
      if (column.second.size() == places_.size()) measured.push_back(&column);
    PictureSheet sheet(measured.size() * places_.size(), measured.size());
    for (std::size_t row = 0; row < places_.size(); ++row)
      for (const Column* column : measured)
        sheet.add(views.at(places_[row]).name + ": " + column->first,
                  fitted_within(column->second[row], most_pixels));
    return sheet.bitmap();
  }

 private:
  using Column = std::pair<std::string, std::vector<MarkedPicture>>;

  static constexpr std::size_t most_views = 3;
  static constexpr std::size_t most_pixels = 416;  // of a picture's longer side
  std::array<Column, 4> columns_{
      {{"photo", {}}, {"clean", {}}, {"adversarial", {}}, {evaluate::matched_noise_name, {}}}};
  std::vector<std::size_t> places_;
};

}  // namespace tapestry::shell
