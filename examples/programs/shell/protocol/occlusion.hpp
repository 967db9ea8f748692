#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tapestry/core/random.hpp>
#include <tapestry/evaluate/occlusion.hpp>
#include <utility>
#include <vector>

#include "protocol.hpp"
#include "settings.hpp"

namespace tapestry::shell {

namespace detail {

inline constexpr std::array<const char*, 4> bar_styles{"first", "second", "third", "fourth"};

/// Of clean, the camouflage, matched noise and no car.
inline std::string bar_style(const ProtocolResult& result, std::size_t texture) {
  const std::size_t style = result.is_bare(texture) ? bar_styles.size() - 1 : texture;
  return std::string("class=\"") + bar_styles[style] + "\"";
}

/// One distance: bars of the textures for every group, with their intervals.
inline Panel bar_panel(const Protocol& protocol, const ProtocolResult& result, std::size_t column) {
  constexpr double left = 52, right = 330, top = 40, bottom = 190;
  const auto& table = protocol.table;
  const auto y = [=](double share) { return bottom - share * (bottom - top); };
  std::string svg = svg_text(14, 18, "title", table.column_title + " " + table.columns[column]);
  for (int tick = 0; tick <= 4; ++tick) {
    svg += svg_line(left, y(tick / 4.0), right, y(tick / 4.0), tick == 0 ? "ink" : "grid");
    svg += svg_text(left - 6, y(tick / 4.0) + 4, "muted end",
                    std::to_string(25 * tick) + (tick == 4 ? " %" : ""));
  }
  const auto shown = result.shown_textures();
  const double group_width = (right - left) / static_cast<double>(table.rows.size());
  const double bar_width = 0.8 * group_width / static_cast<double>(shown.size());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto& cell = result.cells[row * table.columns.size() + column];
    const double group_left = left + group_width * (static_cast<double>(row) + 0.1);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const auto& rate = cell.textures[shown[i]].rate;
      const double x = group_left + bar_width * static_cast<double>(i), middle = x + bar_width / 2 - 1;
      if (rate.views == 0) {
        svg += svg_text(middle, bottom - 4, "muted middle", "-");
        continue;
      }
      svg += svg_rectangle(x, y(rate.p_at_50), bar_width - 2, bottom - y(rate.p_at_50),
                           bar_style(result, shown[i]));
      svg += svg_line(middle, y(rate.interval[0]), middle, y(rate.interval[1]), "ink");
      for (const double end : rate.interval) svg += svg_line(middle - 3, y(end), middle + 3, y(end), "ink");
    }
    const double middle = left + group_width * (static_cast<double>(row) + 0.5);
    svg += svg_text(middle, bottom + 17, "middle", evaluate::occlusion_group_names[row]);
    svg += svg_text(middle, bottom + 32, "muted middle",
                    cell.measured > 0 ? fixed(100 * cell.mean_hidden_share, 0) + " % hidden" : "no frames");
  }
  return {350, 236, svg};
}

inline Figure occlusion_figure(const Protocol& protocol, const ProtocolResult& result) {
  Figure figure{"How often the detector finds the partly hidden car", {}, {420, 70, ""}, 2};
  for (std::size_t column = 0; column < protocol.table.columns.size(); ++column)
    figure.panels.push_back(bar_panel(protocol, result, column));
  double x = 14;
  for (const std::size_t texture : result.shown_textures()) {
    figure.legend.svg += svg_rectangle(x, 8, 12, 12, bar_style(result, texture));
    figure.legend.svg += svg_text(x + 18, 18, "", result.textures[texture]);
    x += 44 + 6.5 * static_cast<double>(result.textures[texture].size());
  }
  figure.legend.svg += svg_text(14, 40, "muted", "bars: frames in which the car is found (P@0.5)") +
                       svg_text(14, 56, "muted", "lines: 95 % intervals (Wilson)");
  return figure;
}

}  // namespace detail

/// FCA's table 4: how well the detector finds the car behind something.
inline Protocol occlusion_protocol(const ProtocolSettings& settings, std::uint64_t seed,
                                   const ProtocolSubject&) {
  const auto grid = settings.quick ? evaluate::quick_occlusion_grid() : evaluate::occlusion_grid();
  Protocol protocol{"occlusion", "Partly hidden cars", evaluate::occlusion_table(grid),
                    evaluate::occlusion_frames(grid)};
  protocol.bare_name = "no car";
  protocol.notes = {
      "Rectangles of random colours, half of them striped or squared, lie over the picture, the same for "
      "every "
      "texture; the hidden share is measured on the silhouette of the car, 5 to 30, 30 to 70 and 70 to 95 %. "
      "Every "
      "group and distance has the same " +
          std::to_string(protocol.frames.size() / protocol.table.cell_count()) + " views.",
      "A box counts by its overlap with that of the whole car, not of the part that still shows.",
      protocol.bare_name +
          ": the same pictures with their rectangles and without the car. What is found there "
          "is not the car, and as much of the other rows may not be."};
  const Random random = Random(seed).fork(0x6F63636C7573696FULL);
  protocol.change = [random, frames = protocol.frames](const camouflage::View<float>& view,
                                                       std::size_t frame) -> std::optional<FrameChange> {
    const auto& background = view.background;
    auto occlusion = evaluate::draw_occlusion(
        view.paint_to_picture.coverage, view.window, background.shape(0), background.shape(1),
        static_cast<evaluate::OcclusionGroup>(frames[frame].row), random.fork(frame));
    if (!occlusion) return std::nullopt;
    return FrameChange{occlusion->hidden_share, [occluders = std::move(occlusion->occluders)](auto& picture) {
                         evaluate::lay_occluders(picture, occluders);
                       }};
  };
  protocol.figure = detail::occlusion_figure;
  return protocol;
}

}  // namespace tapestry::shell
