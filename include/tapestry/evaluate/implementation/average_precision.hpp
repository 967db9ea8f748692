#pragma once
#include <array>
#include <tapestry/core/parallel.hpp>
#include <tapestry/evaluate/average_precision.hpp>

namespace tapestry::evaluate {
namespace detail {
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

/// COCO's precision and recall of a class at one threshold.
struct CurveSummary {
  double precision = 0;  ///< interpolated precision, mean over 101 recalls
  double recall = 0;     ///< the largest
};

/// The mean over r = 0, .01, … 1 of the largest precision at a recall of at least r, 0 where there is none.
///
/// \param outcomes  most confident first
/// \param truths    that can be found, at least 1
[[nodiscard]] inline CurveSummary curve_summary(const std::vector<Outcome>& outcomes, std::size_t truths) {
  constexpr std::size_t steps = 100;
  std::vector<double> precision;   // at each hit
  std::size_t hits = 0, seen = 0;  // detections that count
  for (const Outcome outcome : outcomes) {
    if (outcome == Outcome::ignored) continue;
    ++seen;
    if (outcome != Outcome::hit) continue;
    ++hits;
    precision.push_back(static_cast<double>(hits) / static_cast<double>(seen));
  }
  for (std::size_t i = precision.size(); i-- > 1;)
    precision[i - 1] = std::max(precision[i - 1], precision[i]);
  double sum = 0;
  std::size_t needed = 1;  // hits for a recall
  for (std::size_t r = 0; r <= steps; ++r) {
    const double recall = static_cast<double>(r) * 0.01;
    while (needed <= hits && static_cast<double>(needed) / static_cast<double>(truths) < recall) ++needed;
    if (needed > hits) break;
    sum += precision[needed - 1];
  }
  return {sum / (steps + 1), static_cast<double>(hits) / static_cast<double>(truths)};
}

inline constexpr std::array<AreaRange, 4> coco_area_ranges{
    {{0, 1e10}, {0, 32.0 * 32}, {32.0 * 32, 96.0 * 96}, {96.0 * 96, 1e10}}};

inline constexpr std::size_t coco_threshold_count = 10;

[[nodiscard]] inline ClassPrecision class_precision(const std::vector<TruthBox>& truths,
                                                    const std::vector<ScoredBox>& detections) {
  ClassPrecision result;
  result.detections = detections.size();
  const ClassMatches matches(truths, detections);
  PrecisionSummary& summary = result.summary;
  const std::array of_range{&summary.ap, &summary.ap_small, &summary.ap_medium, &summary.ap_large};
  for (std::size_t a = 0; a < coco_area_ranges.size(); ++a) {
    const std::size_t count = matches.truth_count(coco_area_ranges[a]);
    if (a == 0) result.truths = count;
    if (count == 0) continue;
    double precision = 0, recall = 0;
    for (std::size_t t = 0; t < coco_threshold_count; ++t) {
      const double threshold = static_cast<double>(10 + t) / 20;
      const CurveSummary curve = curve_summary(matches.outcomes(coco_area_ranges[a], threshold), count);
      precision += curve.precision;
      recall += curve.recall;
      if (a == 0 && t == 0) summary.ap50 = curve.precision;
      if (a == 0 && t == 5) summary.ap75 = curve.precision;
    }
    *of_range[a] = precision / coco_threshold_count;
    if (a == 0) summary.recall = recall / coco_threshold_count;
  }
  return result;
}

inline void require_sound_box(std::string_view what, std::size_t index, const detect::Box& box) {
  if (std::isfinite(box.cx) && std::isfinite(box.cy) && std::isfinite(box.w) && std::isfinite(box.h) &&
      box.w >= 0 && box.h >= 0)
    return;
  throw DomainError(
      {"average_precision: box of ", what, " ", index, " is not finite, or of negative extent"});
}

inline void require_class_below(std::string_view what, std::size_t index, std::size_t class_index,
                                std::size_t class_count) {
  if (class_index >= class_count)
    throw DomainError({"average_precision: ", what, " ", index, " is of class ", class_index,
                       ", expected less than ", class_count});
}

[[nodiscard]] inline PrecisionSummary mean_summary(const std::vector<ClassPrecision>& classes) {
  PrecisionSummary mean;
  for (const auto member :
       {&PrecisionSummary::ap, &PrecisionSummary::ap50, &PrecisionSummary::ap75, &PrecisionSummary::ap_small,
        &PrecisionSummary::ap_medium, &PrecisionSummary::ap_large, &PrecisionSummary::recall}) {
    double sum = 0;
    std::size_t count = 0;
    for (const auto& one : classes)
      if (const auto& value = one.summary.*member) {
        sum += *value;
        ++count;
      }
    if (count > 0) mean.*member = sum / static_cast<double>(count);
  }
  return mean;
}
}  // namespace detail

AveragePrecision average_precision(const std::vector<TruthBox>& truths,
                                   const std::vector<ScoredBox>& detections, std::size_t class_count) {
  std::vector<std::vector<TruthBox>> truths_of(class_count);
  std::vector<std::vector<ScoredBox>> detections_of(class_count);
  for (std::size_t i = 0; i < truths.size(); ++i) {
    detail::require_class_below("truth", i, truths[i].class_index, class_count);
    detail::require_sound_box("truth", i, truths[i].box);
    if (!(std::isfinite(truths[i].area) && truths[i].area >= 0))
      throw DomainError({"average_precision: area of truth ", i, " is not finite, or negative"});
    truths_of[truths[i].class_index].push_back(truths[i]);
  }
  for (std::size_t i = 0; i < detections.size(); ++i) {
    detail::require_class_below("detection", i, detections[i].class_index, class_count);
    detail::require_sound_box("detection", i, detections[i].box);
    if (!std::isfinite(detections[i].confidence))
      throw NumericError({"average_precision: confidence of detection ", i, " is not finite"});
    detections_of[detections[i].class_index].push_back(detections[i]);
  }
  AveragePrecision result;
  result.classes.resize(class_count);
  parallel_for(class_count, [&](std::size_t k) {
    result.classes[k] = detail::class_precision(truths_of[k], detections_of[k]);
  });
  result.mean = detail::mean_summary(result.classes);
  return result;
}

PrecisionSummary target_precision(const std::vector<std::vector<BoxOnTarget>>& pictures) {
  std::vector<TruthBox> truths;
  std::vector<ScoredBox> detections;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    truths.push_back({i, 0, detect::box_from_corners(0, 0, 1, 1), 1});
    for (const auto& [confidence, iou] : pictures[i])  // a part of the target that has this IoU with it
      detections.push_back({i, 0, detect::box_from_corners(0, 0, double(iou), 1), double(confidence)});
  }
  return average_precision(truths, detections, 1).mean;
}
}  // namespace tapestry::evaluate
