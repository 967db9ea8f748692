#pragma once
#include "../../scenes/labelled_scene.hpp"
#include "dataset_evaluation.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {
/// A part of a picture, or a picture with room around it; pixels of the picture.
struct PictureCut {
  long left = 0, top = 0;
  std::size_t width = 0, height = 0;
};

/// Draws half to one and a half times the extents of a picture, of a form that differs by at most a fifth,
/// at a random place; a fifth of all cuts are the picture itself.
inline PictureCut draw_cut(Random& random, std::size_t width, std::size_t height) {
  if (random.chance(0.2)) return {0, 0, width, height};
  const double scale = std::exp(random.uniform(std::log(0.5), std::log(1.5)));
  const double form = std::sqrt(std::exp(random.uniform(-std::log(1.2), std::log(1.2))));
  const auto extent = [](std::size_t whole, double share) {
    return std::max(1L, std::lround(static_cast<double>(whole) * share));
  };
  const auto place = [&](std::size_t whole, long part) {  // within the picture, or the picture within it
    return std::lround(random.uniform() * static_cast<double>(static_cast<long>(whole) - part));
  };
  const long across = extent(width, scale * form), down = extent(height, scale / form);
  const long left = place(width, across), top = place(height, down);
  return {left, top, static_cast<std::size_t>(across), static_cast<std::size_t>(down)};
}

/// The pixels of a cut, in [0, 1], varied.
/// \param fill  value beside the picture
inline Array<float, 3> cut_out(const Array<std::uint8_t, 3>& picture, const PictureCut& cut,
                               const scenes::Variation& variation, float fill) {
  const auto width = static_cast<long>(picture.shape(1)), height = static_cast<long>(picture.shape(0));
  auto out = filled<float, 3>({cut.height, cut.width, 3}, fill);
  for (std::size_t row = 0; row < cut.height; ++row)
    for (std::size_t column = 0; column < cut.width; ++column) {
      const long y = cut.top + static_cast<long>(row);
      const long x = cut.left + static_cast<long>(variation.mirrored ? cut.width - 1 - column : column);
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const std::uint8_t* const from = &picture(static_cast<std::size_t>(y), static_cast<std::size_t>(x), 0);
      for (std::size_t c = 0; c < 3; ++c)
        out(row, column, c) = std::min(1.0F, static_cast<float>(from[c]) / 255 * variation.gain[c]);
    }
  return out;
}

/// The objects of a picture in a cut that is fitted onto the network's input. Leaves out truths that a cut
/// shows less than three tenths of, and truths of less than two pixels a side.
inline std::vector<loss::Target> truths_in(const std::vector<loss::Target>& truths, const PictureCut& cut,
                                           bool mirrored, std::size_t input_height, std::size_t input_width,
                                           image::FitKind fit) {
  const auto width = static_cast<double>(cut.width), height = static_cast<double>(cut.height);
  const auto frame = detect::box_from_corners(0, 0, width, height);
  const auto from_input = image::picture_from_canvas(cut.height, cut.width, input_height, input_width, fit);
  std::vector<loss::Target> inside;
  for (auto [class_index, box] : truths) {
    box.cx -= static_cast<double>(cut.left);
    box.cy -= static_cast<double>(cut.top);
    const auto seen = detect::clipped(box, frame);
    if (!(seen.area() >= 0.3 * box.area())) continue;
    const detect::Box placed{(mirrored ? width - seen.cx : seen.cx) / from_input.x_scale + from_input.left,
                             seen.cy / from_input.y_scale + from_input.top, seen.w / from_input.x_scale,
                             seen.h / from_input.y_scale};
    if (placed.w >= 2 && placed.h >= 2) inside.push_back({class_index, placed});
  }
  return inside;
}

/// Labelled pictures to learn from, cut, mirrored and tinted anew each time.
class DatasetPictures {
 public:
  /// Reads every picture once, so that a bad one is found before the first step.
  /// \param keep_bytes  of pixels to keep; pictures beyond are read anew
  /// \throws FileError as io::read_image() and evaluate::objects_in_pixels(); Stopped
  DatasetPictures(const evaluate::Dataset& dataset, const ClassMatching& matching, std::size_t keep_bytes) {
    std::vector<std::size_t> counts(matching.names.size());
    std::size_t empty = 0, crowds = 0, too_small = 0;
    std::vector<std::size_t> class_of(matching.names.size());  // of the detector
    for (std::size_t i = 0; i < matching.of_detector.size(); ++i)
      if (matching.of_detector[i]) class_of[*matching.of_detector[i]] = i;
    for (const auto& picture : dataset.pictures) paths_.push_back(picture.path);
    const auto read = [&](std::size_t i) {
      StopSignal::throw_if_arrived();
      auto pixels = io::read_image(paths_[i]);
      auto objects = evaluate::objects_in_pixels(dataset.pictures[i], pixels.shape(0), pixels.shape(1));
      return std::pair(std::move(pixels), std::move(objects));
    };
    for_each_in_order(paths_.size(), read, [&](std::size_t, auto labelled) {
      auto& [pixels, objects] = labelled;
      const auto frame = detect::box_from_corners(0, 0, static_cast<double>(pixels.shape(1)),
                                                  static_cast<double>(pixels.shape(0)));
      auto& truths = truths_.emplace_back();
      for (const auto& object : objects) {
        const auto box = detect::clipped(object.box, frame);
        const std::size_t k = matching.of_dataset[object.class_index].value();
        if (object.is_crowd)
          ++crowds;
        else if (box.w < 1 || box.h < 1)
          ++too_small;
        else
          truths.push_back({class_of[k], box}), ++counts[k];
      }
      empty += truths.empty() ? 1U : 0U;
      const bool is_kept = pixels.size() <= keep_bytes;
      if (is_kept) keep_bytes -= pixels.size();
      kept_.push_back(is_kept ? std::move(pixels) : Array<std::uint8_t, 3>());
    });
    summary_ = std::to_string(paths_.size()) + " pictures, " + std::to_string(empty) + " without objects";
    for (std::size_t k = 0; k < counts.size(); ++k)
      if (counts[k] > 0) summary_ += ", " + printable(matching.names[k]) + " " + std::to_string(counts[k]);
    if (crowds + too_small > 0)
      summary_ += "; left out: " + std::to_string(crowds) + " crowds, " + std::to_string(too_small) +
                  " boxes with less than a pixel in the picture";
    is_empty_ = empty == paths_.size();
  }

  /// Sentence with the numbers of pictures and of objects by class.
  [[nodiscard]] const std::string& summary() const { return summary_; }
  [[nodiscard]] bool is_empty() const { return is_empty_; }

  /// Fills a batch. The result depends on the generator alone, not on the number of threads.
  /// \param fit  of pictures on the network's input
  void fill(const Random& random, const image::Fit& fit, Array<float, 4>& batch, loss::Truths& truths) const {
    truths.assign(batch.shape(0), {});
    parallel_for(batch.shape(0), [&](std::size_t i) {
      Random own = random.fork(i);
      const std::size_t index = own.index(paths_.size());
      const auto read = kept_[index].size() > 0 ? Array<std::uint8_t, 3>() : io::read_image(paths_[index]);
      const auto& picture = read.size() > 0 ? read : kept_[index];
      const auto cut = draw_cut(own, picture.shape(1), picture.shape(0));
      const auto variation = scenes::draw_variation(own);
      const auto fitted = image::fitted(cut_out(picture, cut, variation, static_cast<float>(fit.fill)),
                                        batch.shape(1), batch.shape(2), fit);
      std::ranges::copy(fitted.storage(), batch.data() + i * fitted.size());
      truths[i] =
          truths_in(truths_[index], cut, variation.mirrored, batch.shape(1), batch.shape(2), fit.kind);
    });
  }

 private:
  std::vector<std::string> paths_{};
  std::vector<Array<std::uint8_t, 3>> kept_{};  ///< empty where they are read anew
  loss::Truths truths_{};                       ///< pixels of the pictures
  std::string summary_{};
  bool is_empty_ = true;
};
}  // namespace tapestry::shell
