#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/head.hpp>
#include <vector>

namespace tapestry::detect {

/// The candidate that is surest to be of a class.
struct BestCandidate {
  std::size_t head = 0;       ///< whose it is
  std::size_t candidate = 0;  ///< anchor · cells + cell within that
  double confidence = 0;  ///< objectness times the probability of the class, or without objectness the latter
};

/// Where to look for it.
struct CandidateSearch {
  std::size_t class_index = 0;
  std::optional<Box> target{};  ///< only candidates whose box has iou_threshold with it, pixels of the input
  double iou_threshold = 0.5;   ///< met exactly counts
};

/// The surest candidate of one image, however unsure and before suppression; of equals the first. Candidates
/// do not count whose box, objectness or probability is NaN or whose confidence is 0.
///
/// \param heads   of any decode family
/// \param logits  one [N, channels, H, W] a head
/// \param height  and \param width of the network's input, pixels
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image, or as
///         require_class() and require_layout()
template <std::floating_point T>
[[nodiscard]] std::optional<BestCandidate> best_candidate(const std::vector<Head>& heads,
                                                          const std::vector<const Array<T, 4>*>& logits,
                                                          std::size_t image, const CandidateSearch& search,
                                                          std::size_t height, std::size_t width);

}  // namespace tapestry::detect
