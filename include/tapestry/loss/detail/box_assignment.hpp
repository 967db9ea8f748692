#pragma once
#include <tapestry/loss/prediction.hpp>

namespace tapestry::loss {
/// The cell of a grid that holds a point, if the point lies in the picture.
struct GridCell {
  std::size_t row = 0, column = 0;
  bool exists = false;
};

/// \param box  pixels of the network's input; its centre decides. A centre on or over the right or lower
///             border has no cell, whatever part of the box is visible.
[[nodiscard]] inline GridCell cell_of(const detect::Head& head, const detect::Box& box,
                                      std::size_t input_height, std::size_t input_width) {
  const auto in_cells = [&](double centre, std::size_t extent, std::size_t cells) {
    if (head.stride > 0) return centre / static_cast<double>(head.stride);
    return centre / static_cast<double>(extent) * static_cast<double>(cells);
  };
  const double row = in_cells(box.cy, input_height, head.grid_height);
  const double column = in_cells(box.cx, input_width, head.grid_width);
  const bool inside = row >= 0 && column >= 0 && row < static_cast<double>(head.grid_height) &&
                      column < static_cast<double>(head.grid_width) &&
                      box.cy < static_cast<double>(input_height) && box.cx < static_cast<double>(input_width);
  if (!inside) return {};
  return {static_cast<std::size_t>(row), static_cast<std::size_t>(column), true};
}

/// The candidates of one head that YOLO training of the Ultralytics kind would match with the target: in the
/// cell of the target's centre, every anchor with max(w/aw, aw/w, h/ah, ah/h) < 4. May be empty; always so
/// for a box without area. Source: FCA's published program, whose hyper-parameter anchor_t is 4 and which,
/// unlike its parent, does not add neighbouring cells. A head without anchors, which that program does not
/// have, matches the one candidate of the cell, whatever the box's size.
/// \throws DomainError for a head of the decode family decoded, whose candidates have no cells
template <std::floating_point T>
[[nodiscard]] std::vector<Candidate> matched_candidates(const Predictions<T>& predictions,
                                                        std::size_t head_index, const Target& target) {
  constexpr double largest_ratio = 4;
  const auto& head = predictions.heads[head_index];
  if (head.decode == detect::DecodeFamily::decoded)
    throw DomainError(
        "matched_candidates: candidates of the decode family decoded have no cells to be matched by; "
        "expected another loss than as_coded");
  const GridCell cell = cell_of(head, target.box, predictions.input_height, predictions.input_width);
  std::vector<Candidate> matched;
  if (!cell.exists || !(target.box.w > 0 && target.box.h > 0)) return matched;
  const auto ratio = [](double a, double b) { return std::max(a / b, b / a); };
  if (!detect::has_anchors(head.decode)) matched.push_back({head_index, 0, cell.row, cell.column});
  for (std::size_t anchor = 0; anchor < head.anchors.size(); ++anchor) {
    const auto& [width, height] = head.anchors[anchor];
    if (std::max(ratio(target.box.w, width), ratio(target.box.h, height)) < largest_ratio)
      matched.push_back({head_index, anchor, cell.row, cell.column});
  }
  return matched;
}

/// Settings for matching truths with candidates of heads without anchors.
struct DynamicMatchOptions {
  double radius = 2.5;      ///< cells from a truth's centre, along each axis, within which cells may take it
  double overlap_cost = 3;  ///< weight of −log IoU beside the cross entropy of the classes
  std::size_t strongest = 10;  ///< best IoUs summed for the number of cells that a truth takes
};

/// A candidate that has to predict a truth.
struct DynamicMatch {
  Candidate candidate{};
  Target truth{};
  double iou = 0;  ///< IoU of the candidate's box and the truth's, treated as constant
};

/// Per image the candidates that have a truth, in the order of candidates.
using DynamicMatches = std::vector<std::vector<DynamicMatch>>;

namespace detail {
/// −log p and −log(1 − p) of the probability p = √(σ(class) · σ(objectness)), or σ(class) of a head without
/// objectness; neither above 100, the bound of the cross entropy in YOLOX's published program.
struct ClassCost {
  double if_present = 0, if_absent = 0;

  ClassCost(double class_logit, std::optional<double> objectness_logit);
};

/// \throws DomainError unless heads have cells and no anchors
void require_free_heads(const char* operation, const std::vector<detect::Head>& heads);

/// \param require_heads  require_free_heads(), or another such function
/// \throws ShapeError, DomainError unless there are truths for each image of these logits
template <std::floating_point T, class RequireHeads>
void require_truths(const char* operation, const std::vector<detect::Head>& heads,
                    const LogitsView<T>& logits, const Truths& truths, std::size_t input_height,
                    std::size_t input_width, RequireHeads require_heads) {
  if (truths.empty()) throw DomainError({operation, ": an empty batch"});
  require_heads(operation, heads);
  const Predictions<T> last{heads, logits, truths.size() - 1, input_height, input_width};
  require_predictions(operation, last);
  require_batch(operation, "truths", truths.size(), logits);
  for (const auto& of_image : truths)
    for (const Target& truth : of_image) require_target(operation, last, truth);
}
}  // namespace detail

/// Matches truths with candidates of heads without anchors, by their present predictions. The choice is not
/// differentiated.
///
/// A truth may take a cell whose centre lies in its box or, along both axes, less than `radius` cells from
/// its middle. The cost of a cell is, with the probabilities p_k = √(σ(class k) · σ(objectness)),
///
///   −log p_c − Σ_{k≠c} log(1 − p_k) − 3 · log(IoU + 10⁻⁸) + 10⁵ · [not both in the box and near its middle]
///
/// and the truth takes its k cheapest cells, k being the sum of its ten best IoUs, rounded down, at least 1.
/// A cell that several truths take keeps the one of least cost; ties go to the first cell and truth. Truths
/// without area, and those with no such cell, are left out.
///
/// Source: Ge et al., "YOLOX: exceeding YOLO series in 2021" (arXiv 2107.08430), SimOTA. There each cell of
/// any truth is open to all truths, at the cost of 10⁵; here only to those whose box or middle it meets. The
/// radius, the root of the product, 10⁵ and 10⁻⁸ are from its published program. As here, its logarithms are
/// at least −100. Unlike here, a cell that several truths take keeps the cheapest of all truths, not only of
/// these. For heads of the family distance, which have no objectness, p_k = σ(class k).
///
/// \param logits  per head [N, D, H, W]
/// \param truths  one entry an image, boxes in pixels of the network's input
/// \throws ShapeError, DomainError as adversarial(), and DomainError for heads of other families than yolox
///         and distance; NumericError for logits that are not finite
template <std::floating_point T>
[[nodiscard]] DynamicMatches dynamic_matches(const std::vector<detect::Head>& heads,
                                             const LogitsView<T>& logits, const Truths& truths,
                                             std::size_t input_height, std::size_t input_width,
                                             const DynamicMatchOptions& options = {});
}  // namespace tapestry::loss
