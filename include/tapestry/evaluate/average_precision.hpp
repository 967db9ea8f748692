#pragma once
#include <optional>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tuple>
#include <vector>

namespace tapestry::evaluate {
/// An object that is in a picture.
struct TruthBox {
  std::size_t picture = 0;
  std::size_t class_index = 0;
  detect::Box box{};        ///< pixels of the picture, as for all boxes here
  double area = 0;          ///< of the object, square pixels: that of its outline where it is known
  bool is_crowd = false;    ///< stands for many objects: ignored, however often it is found
  bool is_ignored = false;  ///< counts neither as found (once) nor as missed
};

/// One detection: an object that a detector found in a picture.
struct ScoredBox {
  std::size_t picture = 0;
  std::size_t class_index = 0;
  detect::Box box{};
  double confidence = 0;
};

namespace detail {
/// Outcome of matching a detection with the truths.
enum class Outcome : std::uint8_t { ignored, hit, miss };

/// Range of areas of the objects that count, square pixels; includes both ends.
struct AreaRange {
  double low = 0, high = 0;

  [[nodiscard]] bool holds(double area) const { return area >= low && area <= high; }
};

inline constexpr std::size_t most_detections_of_class = 100;  ///< of a picture, as COCO's maxDets

/// Matches the detections of one class with the truths, picture by picture.
///
/// Each detection, by falling confidence, takes the free truth that it overlaps most, if by at least the
/// threshold. Truths that count come before ignored ones; of equals the later is taken. The overlap is
/// IoU; with a crowd it is the share of the detection that lies in it, and a crowd is never used up. Crowds,
/// truths marked so, and truths out of the range of areas are ignored. A detection is ignored if the truth it
/// takes is, or if it takes none and is itself out of the range.
class ClassMatches {
 public:
  /// \param detections  equal confidences keep their order in a picture
  ClassMatches(std::vector<TruthBox> truths, std::vector<ScoredBox> detections);

  /// Truths that count.
  [[nodiscard]] std::size_t truth_count(const AreaRange& range) const;

  /// Outcomes of the detections over all pictures, most confident first.
  [[nodiscard]] std::vector<Outcome> outcomes(const AreaRange& range, double threshold) const;

 private:
  struct Overlap {
    std::size_t truth;
    double share;
  };

  [[nodiscard]] static bool is_ignored(const TruthBox& truth, const AreaRange& range) {
    return truth.is_crowd || truth.is_ignored || !range.holds(truth.area);
  }

  /// Larger for the truth that a detection prefers.
  [[nodiscard]] std::tuple<bool, double> preference(const Overlap& overlap, const AreaRange& range) const {
    return {!is_ignored(truths_[overlap.truth], range), overlap.share};
  }

  void keep_most_confident();

  void measure_overlaps();

  std::vector<TruthBox> truths_;       ///< in order of their pictures
  std::vector<ScoredBox> detections_;  ///< in order of their pictures, in each most confident first
  std::vector<std::size_t> ranked_;    ///< detections over all pictures, most confident first
  std::vector<Overlap> overlaps_;      ///< above 0, detection by detection
  std::vector<std::size_t> first_overlap_{0};
};
}  // namespace detail

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
/// any number of threads. Source: Lin et al., "Microsoft COCO: Common Objects in Context" (ECCV 2014), and
/// the metrics of cocodataset.org, detection evaluation. As in COCO's program, recalls are compared with
/// multiples of 0.01 in double precision, so rounding decides if a recall equals one of them.
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
