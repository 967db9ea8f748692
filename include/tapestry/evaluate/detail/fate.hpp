#pragma once
#include <tapestry/detect/box_decode.hpp>  // Detection
#include <tapestry/loss/prediction.hpp>    // Target

/// How a car fares in a picture. A detector that calls the car an umbrella has not lost it. P@0.5
/// and the paper's attack success ("not detected or false detected") count that as a success. These
/// five fates separate it from a picture without any box on the car. Source: kinds of error of Bolya
/// et al., TIDE (ECCV 2020).
namespace tapestry::evaluate {
/// Fate of a car in a picture: the first in this order that holds for some detection.
///
///     found      the target's class,               IoU ≥ .5
///     related    a class like it, see related_classes(), IoU ≥ .5
///     renamed    any other class,                  IoU ≥ .5
///     misplaced  the target's class,               .1 ≤ IoU < .5
///     lost       none of these; boxes of other classes may still overlap the car by less than .5
enum class Fate : std::uint8_t { found, related, renamed, misplaced, lost };

/// Names of the fates, in the order of Fate.
inline constexpr std::array fate_names{"found", "related", "renamed", "misplaced", "lost"};

/// Fate of a target in one picture, and the box that decides it.
struct ViewOutcome {
  Fate fate = Fate::lost;
  std::size_t class_index = 0;  ///< of the surest detection that decides; meaningless for lost
  double confidence = 0;        ///< of that detection; 0 for lost
  bool operator==(const ViewOutcome&) const = default;
};

/// \param detections  as they come out of suppression
/// \param related     classes that count as similar to the target's own
[[nodiscard]] ViewOutcome outcome_of(const std::vector<detect::Detection>& detections,
                                     const loss::Target& target, const std::vector<std::size_t>& related);

/// Classes that replace a road user's class without much harm: for a car, a truck, a bus, a train or a van
/// the others of these that the detector knows by name. None for any other class, or for a detector without
/// names. \param names  of the detector's classes
[[nodiscard]] std::vector<std::size_t> related_classes(const std::vector<std::string>& names,
                                                       std::size_t class_index);

/// Number of pictures of each fate, and the classes of the renamed ones.
struct FateCounts {
  std::array<std::size_t, fate_names.size()> pictures{};  ///< by Fate
  std::vector<std::size_t> renamed_to{};                  ///< pictures of each class, those renamed

  [[nodiscard]] std::size_t of(Fate fate) const { return pictures[static_cast<std::size_t>(fate)]; }
  [[nodiscard]] std::size_t all() const;
  /// Classes of the renamed, the commonest first, at most so many; of equals the lower index first.
  [[nodiscard]] std::vector<std::size_t> commonest_names(std::size_t most) const;
};

/// Counts the fates of several pictures.
[[nodiscard]] FateCounts fate_counts(const std::vector<ViewOutcome>& outcomes);
}  // namespace tapestry::evaluate
