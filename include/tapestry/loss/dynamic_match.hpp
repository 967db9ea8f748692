#pragma once
#include <cstddef>
#include <optional>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/loss/prediction.hpp>
#include <vector>

namespace tapestry::loss {

/// How truths choose the candidates of heads without anchors.
struct DynamicMatchOptions {
  double radius = 2.5;      ///< cells from a truth's centre, along each axis, within which cells may take it
  double overlap_cost = 3;  ///< weight of −log IoU beside the cross entropy of the classes
  std::size_t strongest = 10;  ///< overlaps that are summed for the number of cells that a truth gets
};

/// A candidate that has to predict a truth.
struct DynamicMatch {
  Candidate candidate{};
  Target truth{};
  double iou = 0;  ///< of the candidate's box with the truth's, a constant in what is trained
};

/// Per image the candidates that have a truth, in the order of candidates.
using DynamicMatches = std::vector<std::vector<DynamicMatch>>;

namespace detail {

/// −log p and −log(1 − p) of the probability p = √(σ(class) · σ(objectness)), or σ(class) of a head without
/// objectness; neither above 100, the bound of the cross entropy in YOLOX's published program.
struct ClassCost {
  double said = 0, denied = 0;

  ClassCost(double class_logit, std::optional<double> objectness_logit);
};

/// \throws DomainError unless heads have cells and no anchors
void require_free_heads(const char* operation, const std::vector<detect::Head>& heads);

}  // namespace detail

/// Which candidates of heads without anchors have to predict which truth. It depends on what they predict as
/// they are, and is not differentiated.
///
/// A truth may go to the cells whose centre lies in its box or, along both axes, less than `radius` cells
/// from its middle. To such a cell it costs, with the probabilities p_k = √(σ(class k) · σ(objectness)),
///
///   −log p_c − Σ_{k≠c} log(1 − p_k) − 3 · log(IoU + 10⁻⁸) + 10⁵ · [not both in the box and near its middle]
///
/// and the truth takes the k cheapest ones, k being the sum of its ten best IoUs, rounded down, at least 1. A
/// cell that several truths take has the one that costs least; ties go to the first cell and truth. Truths
/// without area, and those with no such cell, are left out.
///
/// Source: Ge et al., "YOLOX: exceeding YOLO series in 2021" (arXiv 2107.08430), SimOTA. There each cell of
/// any truth is open to all truths, at the cost of 10⁵; here to those that it lies in or near to. The radius,
/// the root of the product, 10⁵ and 10⁻⁸ are those of its published program, whose logarithms are at least
/// −100, as here, and which gives a cell that several truths take to the cheapest of all truths, here to the
/// cheapest of those. For heads of the family distance, which have no objectness, p_k = σ(class k).
///
/// \param logits  per head [N, D, H, W]
/// \param truths  one entry an image, boxes in pixels of the network's input
/// \throws ShapeError, DomainError as adversarial(), and DomainError for heads of other families than yolox
///         and distance; NumericError for logits that are not finite
template <class T>
[[nodiscard]] DynamicMatches dynamic_matches(const std::vector<detect::Head>& heads,
                                             const LogitsView<T>& logits, const Truths& truths,
                                             std::size_t input_height, std::size_t input_width,
                                             const DynamicMatchOptions& options = {});

}  // namespace tapestry::loss
