#pragma once
#include "bars.hpp"
#include "settings.hpp"

namespace tapestry::shell {
inline Figure occlusion_figure(const Protocol& protocol, const ProtocolResult& result) {
  Figure figure{"How often the detector finds the partly hidden car", {}, bar_legend(result), 2};
  const auto& table = protocol.table;
  for (std::size_t column = 0; column < table.columns.size(); ++column)
    figure.panels.push_back(bar_panel(
        protocol, result, {column, 0, table.rows.size(), table.column_title + " " + table.columns[column]},
        [](std::size_t row, const evaluate::Cell& cell) {
          return std::array{
              std::string(evaluate::occlusion_group_names[row]),
              cell.measured > 0 ? fixed(100 * cell.mean_hidden_share, 0) + " % hidden" : "no frames"};
        }));
  return figure;
}

/// FCA's table 4: how well the detector finds the car behind obstacles.
inline Protocol occlusion_protocol(const ProtocolSettings& settings, std::uint64_t seed,
                                   const ProtocolSubject&) {
  const auto grid = settings.quick ? evaluate::quick_occlusion_grid() : evaluate::occlusion_grid();
  Protocol protocol{"occlusion", "Partly hidden cars", evaluate::occlusion_table(grid),
                    evaluate::occlusion_frames(grid)};
  protocol.bare_name = "no car";
  protocol.notes = {
      "Rectangles of random colours, half of them striped or squared, lie over the picture, the same for "
      "every texture; the hidden share is measured on the silhouette of the car, 5 to 30, 30 to 70 and 70 to "
      "95 %. Every group and distance has the same " +
          std::to_string(protocol.frames.size() / protocol.table.cell_count()) + " views.",
      "A box counts by its overlap with that of the whole car, not of the part that still shows.",
      protocol.bare_name +
          ": the same pictures with their rectangles and without the car. What is found there is not the "
          "car, and as much of the other rows may not be."};
  const Random random = Random(seed).fork(0x6F63636C7573696FULL);
  protocol.change = [random, frames = protocol.frames](const camouflage::View<float>& view,
                                                       std::size_t frame) -> std::optional<FrameChange> {
    const auto& background = view.background;
    auto occlusion = evaluate::draw_occlusion(
        view.paint_to_picture->coverage, view.window, background.shape(0), background.shape(1),
        static_cast<evaluate::OcclusionGroup>(frames[frame].row), random.fork(frame));
    if (!occlusion) return std::nullopt;
    return FrameChange{occlusion->hidden_share, [occluders = std::move(occlusion->occluders)](auto& picture) {
                         evaluate::lay_occluders(picture, occluders);
                       }};
  };
  protocol.figure = occlusion_figure;
  return protocol;
}
}  // namespace tapestry::shell
