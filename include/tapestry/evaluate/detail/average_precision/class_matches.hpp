#pragma once
#include <cstddef>
#include <cstdint>
#include <tapestry/core/compiled.hpp>
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

}  // namespace tapestry::evaluate

namespace tapestry::evaluate::detail {

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

}  // namespace tapestry::evaluate::detail
