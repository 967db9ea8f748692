#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/evaluate/average_precision/scored_box.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tapestry::evaluate::detail {

/// What a detection turned out to be.
enum class Outcome : std::uint8_t { ignored, hit, miss };

/// Of objects that count, square pixels; both ends belong to it.
struct AreaRange {
  double low = 0, high = 0;

  [[nodiscard]] bool holds(double area) const { return area >= low && area <= high; }
};

inline constexpr std::size_t most_detections_of_class = 100;  ///< of a picture, as COCO's maxDets

/// Finds which truth each detection of one class is, picture by picture.
///
/// Going down in confidence, a detection takes of the truths that are left the one it overlaps most, if by at
/// least the threshold; one that counts before any that is ignored, and of equals the later. The overlap is
/// IoU, with a crowd the share of the detection that lies in it, and a crowd is never used up. Ignored are
/// crowds, truths marked so, and truths out of the range of areas; a detection is ignored if what it takes
/// is, or if it takes nothing and is itself out of the range.
class ClassMatches {
 public:
  /// \param detections  equal confidences keep their order in a picture
  ClassMatches(std::vector<TruthBox> truths, std::vector<ScoredBox> detections)
      : truths_(std::move(truths)), detections_(std::move(detections)) {
    std::stable_sort(truths_.begin(), truths_.end(),
                     [](const auto& a, const auto& b) { return a.picture < b.picture; });
    std::stable_sort(detections_.begin(), detections_.end(), [](const auto& a, const auto& b) {
      return std::tuple(a.picture, -a.confidence) < std::tuple(b.picture, -b.confidence);
    });
    keep_most_confident();
    for (std::size_t d = 0; d < detections_.size(); ++d) ranked_.push_back(d);
    std::stable_sort(ranked_.begin(), ranked_.end(), [&](std::size_t a, std::size_t b) {
      return detections_[a].confidence > detections_[b].confidence;
    });
    measure_overlaps();
  }

  /// Truths that count.
  [[nodiscard]] std::size_t truth_count(const AreaRange& range) const {
    return static_cast<std::size_t>(std::count_if(
        truths_.begin(), truths_.end(), [&](const auto& truth) { return !is_ignored(truth, range); }));
  }

  /// Of the detections over all pictures, most confident first.
  [[nodiscard]] std::vector<Outcome> outcomes(const AreaRange& range, double threshold) const {
    std::vector<Outcome> found(detections_.size());
    std::vector<bool> is_taken(truths_.size());
    for (std::size_t d = 0; d < detections_.size(); ++d) {
      const Overlap* best = nullptr;
      for (std::size_t i = first_overlap_[d]; i < first_overlap_[d + 1]; ++i) {
        const Overlap& overlap = overlaps_[i];
        const TruthBox& truth = truths_[overlap.truth];
        if (overlap.share < threshold || (is_taken[overlap.truth] && !truth.is_crowd)) continue;
        if (best == nullptr || preference(overlap, range) >= preference(*best, range)) best = &overlap;
      }
      const bool is_of_range = range.holds(detections_[d].box.area());
      if (best == nullptr) {
        found[d] = is_of_range ? Outcome::miss : Outcome::ignored;
        continue;
      }
      is_taken[best->truth] = true;
      found[d] = is_ignored(truths_[best->truth], range) ? Outcome::ignored : Outcome::hit;
    }
    std::vector<Outcome> result;
    result.reserve(ranked_.size());
    for (const std::size_t d : ranked_) result.push_back(found[d]);
    return result;
  }

 private:
  struct Overlap {
    std::size_t truth;
    double share;
  };

  [[nodiscard]] static bool is_ignored(const TruthBox& truth, const AreaRange& range) {
    return truth.is_crowd || truth.is_ignored || !range.holds(truth.area);
  }

  /// Larger for the truth that a detection takes sooner.
  [[nodiscard]] std::tuple<bool, double> preference(const Overlap& overlap, const AreaRange& range) const {
    return {!is_ignored(truths_[overlap.truth], range), overlap.share};
  }

  void keep_most_confident() {
    std::vector<ScoredBox> kept;
    std::size_t in_picture = 0;
    for (const ScoredBox& detection : detections_) {
      in_picture = !kept.empty() && kept.back().picture == detection.picture ? in_picture + 1 : 1;
      if (in_picture <= most_detections_of_class) kept.push_back(detection);
    }
    detections_ = std::move(kept);
  }

  void measure_overlaps() {
    auto first = truths_.begin(), last = truths_.begin();  // of the picture
    for (const ScoredBox& detection : detections_) {
      const auto is_before = [&](const TruthBox& truth) { return truth.picture < detection.picture; };
      const auto is_up_to = [&](const TruthBox& truth) { return truth.picture <= detection.picture; };
      first = std::find_if_not(first, truths_.end(), is_before);
      last = std::find_if_not(std::max(first, last), truths_.end(), is_up_to);
      for (auto truth = first; truth != last; ++truth) {
        const double share = truth->is_crowd
                                 ? detect::intersection(detection.box, truth->box) / detection.box.area()
                                 : detect::iou(detection.box, truth->box);
        if (share > 0) overlaps_.push_back({static_cast<std::size_t>(truth - truths_.begin()), share});
      }
      first_overlap_.push_back(overlaps_.size());
    }
  }

  std::vector<TruthBox> truths_;       ///< in order of their pictures
  std::vector<ScoredBox> detections_;  ///< in order of their pictures, in each most confident first
  std::vector<std::size_t> ranked_;    ///< detections over all pictures, most confident first
  std::vector<Overlap> overlaps_;      ///< above 0, detection by detection
  std::vector<std::size_t> first_overlap_{0};
};

}  // namespace tapestry::evaluate::detail
