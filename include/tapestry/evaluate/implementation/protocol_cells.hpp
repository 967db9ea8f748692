#pragma once
#include <tapestry/evaluate/protocol_cells.hpp>

namespace tapestry::evaluate {
namespace detail {
/// The cell with the lowest figure; of equal ones that with more views, then the first. None where there are
/// no views.
/// \param share_of  returns the figure of a cell and its views
template <class ShareOf>
[[nodiscard]] std::optional<std::size_t> lowest_cell(const std::vector<Cell>& cells, ShareOf share_of) {
  std::optional<std::size_t> lowest;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto [share, views] = share_of(cells[i]);
    if (views == 0) continue;
    if (lowest) {
      const auto [other_share, other_views] = share_of(cells[*lowest]);
      if (share > other_share || (share == other_share && views <= other_views)) continue;
    }
    lowest = i;
  }
  return lowest;
}
}  // namespace detail

std::optional<PairedRatio> share_kept(const Array<double, 2>& part, const Array<double, 2>& whole) {
  if (part.shape() != whole.shape() || whole.size() == 0 || !(two_level_difference(whole).interval[0] > 0))
    return std::nullopt;
  return two_level_ratio(part, whole);
}

std::vector<Cell> cells_of(const ProtocolTable& table, const std::vector<ProtocolFrame>& frames,
                           const ProtocolOutcomes& outcomes) {
  if (frames.size() != outcomes.frame_count())
    throw ShapeError({"cells_of: outcomes of ", outcomes.frame_count(), " frames, expected ", frames.size()});
  for (const ProtocolFrame& frame : frames)
    if (frame.row >= table.rows.size() || frame.column >= table.columns.size())
      throw ShapeError({"cells_of: a frame is in row ", frame.row, ", column ", frame.column,
                        " of a table of ", table.rows.size(), " by ", table.columns.size()});
  std::vector<Cell> cells;
  for (std::size_t cell = 0; cell < table.cell_count(); ++cell)
    cells.push_back(cell_of(
        outcomes, [&](std::size_t frame) { return table.cell_of(frames[frame]) == cell; },
        table.pictures_of_row(cell / table.columns.size())));
  return cells;
}

std::optional<std::size_t> least_hidden_cell(const std::vector<Cell>& cells, std::size_t texture) {
  return detail::lowest_cell(cells, [&](const Cell& cell) {
    const AttackSuccess& success = cell.textures.at(texture).success;
    return std::pair(success.interval[1], success.views);
  });
}

std::optional<std::size_t> least_found_cell(const std::vector<Cell>& cells, std::size_t texture) {
  return detail::lowest_cell(cells, [&](const Cell& cell) {
    const DetectionRate& rate = cell.textures.at(texture).rate;
    return std::pair(rate.interval[1], rate.views);
  });
}
}  // namespace tapestry::evaluate
