#pragma once
#include <algorithm>
#include <cstddef>
#include <tapestry/loss/prediction.hpp>
#include <vector>

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

/// The candidates of one head that YOLO training of the Ultralytics kind would match with the target: in
/// the cell of the target's centre, every anchor with max(w/aw, aw/w, h/ah, ah/h) < 4. May be empty; always
/// so for a box without area. Source: FCA's published program, whose hyper-parameter anchor_t is 4 and
/// which, unlike its parent, does not add neighbouring cells. A head without anchors, which that program does
/// not know, has the one candidate of the cell matched, whatever the size of the box.
/// \throws DomainError for a head of the decode family decoded, whose candidates have no cells
template <class T>
[[nodiscard]] std::vector<Candidate> matched_candidates(const Predictions<T>& predictions,
                                                        std::size_t head_index, const Target& target) {
  constexpr double largest_ratio = 4;
  const auto& head = predictions.heads[head_index];
  if (head.decode == detect::DecodeFamily::decoded)
    throw DomainError(
        "matched_candidates: candidates of the decode family decoded have no cells to be matched by; "
        "expected "
        "another loss than as_coded");
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

}  // namespace tapestry::loss
