#pragma once
#include <optional>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/detail/average_precision/class_matches.hpp>

namespace tapestry::evaluate {

/// A detector's accuracy by COCO's measures; a measure has no value where there is nothing to find.
struct PrecisionSummary {
  std::optional<double> ap{};         ///< mean over the thresholds .50, .55, … .95
  std::optional<double> ap50{};       ///< at IoU ≥ .50
  std::optional<double> ap75{};       ///< at IoU ≥ .75
  std::optional<double> ap_small{};   ///< mean over the thresholds; objects of less than 32² square pixels
  std::optional<double> ap_medium{};  ///< from 32² to 96²
  std::optional<double> ap_large{};   ///< from 96² on
  std::optional<double> recall{};     ///< AR: the largest recall, mean over the thresholds
};

/// Average precision of one class.
struct ClassPrecision {
  std::size_t truths = 0;      ///< truths that count: no crowds, none ignored
  std::size_t detections = 0;  ///< all that were given
  PrecisionSummary summary{};
};

/// Average precision over all classes that are looked for.
struct AveragePrecision {
  PrecisionSummary mean{};  ///< each over the classes that have it
  std::vector<ClassPrecision> classes{};
};

/// Average precision as COCO defines it. For each class, threshold t and range of areas, detections are
/// matched with truths by ClassMatches, and ranked over all pictures by falling confidence; then
///
///   AP = 1/101 · Σ over r = 0, .01, … 1 of max {precision at rank k : recall at rank k ≥ r}
///
/// with precision = hits / detections and recall = hits / truths; ignored detections and truths count
/// nowhere. At most 100 detections count for each class of a picture, the most confident. Equal confidences
/// keep the order of pictures and, within a picture, of its list; no other order matters. The same bits for
/// any number of threads.
/// Source: Lin et al., "Microsoft COCO: Common Objects in Context" (ECCV 2014), and the metrics of
/// cocodataset.org, detection evaluation. As in COCO's program, recalls are compared with multiples of 0.01
/// in double precision, so rounding decides if a recall equals one of them.
///
/// \param class_count  of the classes looked for; a class without truths has no value and is in no mean
/// \throws DomainError for a class that is not below class_count, for a box or an area that is not finite or
///         negative; NumericError for a confidence that is not finite
[[nodiscard]] AveragePrecision average_precision(const std::vector<TruthBox>& truths,
                                                 const std::vector<ScoredBox>& detections,
                                                 std::size_t class_count);

/// A box of a target's class in its picture.
struct BoxOnTarget {
  float confidence = 0;
  float iou = 0;  ///< with the target
};

/// average_precision() of pictures with one object each, which its target stands for: every other box of its
/// class counts as wrong, as one on another car does.
/// \param pictures  boxes of the target's class in each
[[nodiscard]] PrecisionSummary target_precision(const std::vector<std::vector<BoxOnTarget>>& pictures);

}  // namespace tapestry::evaluate
