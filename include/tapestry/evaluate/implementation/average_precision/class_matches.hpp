#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/evaluate/average_precision/class_matches.hpp>
#include <tapestry/evaluate/average_precision/scored_box.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace tapestry::evaluate::detail {

ClassMatches::ClassMatches(std::vector<TruthBox> truths, std::vector<ScoredBox> detections)
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

std::size_t ClassMatches::truth_count(const AreaRange& range) const {
  return static_cast<std::size_t>(std::count_if(
      truths_.begin(), truths_.end(), [&](const auto& truth) { return !is_ignored(truth, range); }));
}

std::vector<Outcome> ClassMatches::outcomes(const AreaRange& range, double threshold) const {
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

void ClassMatches::keep_most_confident() {
  std::vector<ScoredBox> kept;
  std::size_t in_picture = 0;
  for (const ScoredBox& detection : detections_) {
    in_picture = !kept.empty() && kept.back().picture == detection.picture ? in_picture + 1 : 1;
    if (in_picture <= most_detections_of_class) kept.push_back(detection);
  }
  detections_ = std::move(kept);
}

void ClassMatches::measure_overlaps() {
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

}  // namespace tapestry::evaluate::detail
