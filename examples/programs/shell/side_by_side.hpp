#pragma once
#include "moving_picture.hpp"
#include "picture_sheet.hpp"
#include "report_page.hpp"
#include "survey_watch.hpp"

namespace tapestry::shell {
/// Textures whose pictures a page shows side by side, each with its words.
inline const std::array<std::pair<std::string, std::string>, 4>& shown_textures() {
  static const std::array<std::pair<std::string, std::string>, 4> textures{
      {{"photo", "the photograph"},
       {"clean", "plain: the car in its own colours"},
       {evaluate::matched_noise_name, "noise of the paint's colours"},
       {"adversarial", "the paint"}}};
  return textures;
}

/// Some views, evenly spread, each with the photograph, the clean car, the noise matched to the camouflage,
/// and this, as far as they are measured.
class SideBySide {
 public:
  /// \param watch     of the survey; collects into this, which must stay where it is
  /// \param pictures  of each texture
  SideBySide(SurveyWatch& watch, std::size_t pictures) {
    for (std::size_t i = 0; i < ways_.size(); ++i)
      places_ = shown_places(watch.collect(texture(i), ways_[i], pictures, most_large_views), pictures);
  }
  SideBySide(const SideBySide&) = delete;
  SideBySide& operator=(const SideBySide&) = delete;

  /// \param views  facts of each picture
  [[nodiscard]] Bitmap sheet(const std::vector<ViewFacts>& views) const {
    constexpr std::size_t most_rows = 3;
    const auto rows = shown_places(most_rows, places_.size());
    const auto columns =
        static_cast<std::size_t>(std::ranges::count_if(ways_, [](const auto& way) { return !way.empty(); }));
    PictureSheet sheet(rows.size() * columns, columns);
    for (const std::size_t row : rows)
      for (std::size_t i = 0; i < ways_.size(); ++i)
        if (!ways_[i].empty())
          sheet.add(views.at(places_[row]).name + ": " + texture(i),
                    fitted_within(ways_[i][row], most_pixels_));
    return sheet.bitmap();
  }

  /// Writes plain car, noise and paint, as far as they are measured, side by side, one view after the other.
  /// \param seconds  that a view shows
  void write_film(const std::string& path, double seconds) const {
    std::vector<Bitmap> frames;
    std::size_t height = 0, width = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      PictureSheet row(ways_.size(), ways_.size());
      for (std::size_t way = 1; way < ways_.size(); ++way)  // without the photograph
        if (!ways_[way].empty())
          row.add(shown_textures()[way].second, fitted_within(ways_[way][i], most_pixels_));
      frames.push_back(row.bitmap());
      height = std::max(height, frames.back().shape(0));
      width = std::max(width, frames.back().shape(1));
    }
    for (Bitmap& frame : frames) {
      auto canvas = filled<std::uint8_t, 3>({height, width, 3}, std::uint8_t(255));
      for (std::size_t y = 0; y < frame.shape(0); ++y)
        std::copy_n(&frame(y, 0, 0), 3 * frame.shape(1), &canvas(y, 0, 0));
      frame = std::move(canvas);
    }
    io::write_file_atomically(path, moving_png(path, frames, seconds));
  }

  [[nodiscard]] ViewPictures pictures() const {
    ViewPictures all{places_};
    for (std::size_t i = 0; i < ways_.size(); ++i)
      if (!ways_[i].empty()) all.ways.emplace_back(shown_textures()[i].second, ways_[i]);
    return all;
  }

 private:
  [[nodiscard]] static const std::string& texture(std::size_t i) { return shown_textures()[i].first; }
  static constexpr std::size_t most_pixels_ = 416;  // of a picture's longer side

  std::array<std::vector<MarkedPicture>, 4> ways_;  ///< of shown_textures(); empty where not measured
  std::vector<std::size_t> places_;
};
}  // namespace tapestry::shell
