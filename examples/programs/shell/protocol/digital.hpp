#pragma once
#include "protocol.hpp"
#include "settings.hpp"

namespace tapestry::shell {
inline constexpr std::size_t quick_photographs = 20;

/// A cell for each detector, which measures every photograph, one detector after another.
inline Protocol photograph_protocol(std::string name, std::string title, const ProtocolSubject& subject) {
  Protocol protocol{
      std::move(name), std::move(title), {"frames", {"photographs"}, "detector", subject.detectors}, {}};
  for (std::size_t column = 0; column < subject.detectors.size(); ++column)
    for (std::size_t i = 0; i < subject.frame_count; ++i) {
      protocol.frames.emplace_back();
      protocol.frames.back().column = column;
    }
  protocol.on_photographs = true;
  protocol.bare_name = "photo";
  return protocol;
}

/// A share of one texture, with its interval if it has one, and a mark.
struct TextureBar {
  double share = 0;
  std::optional<std::array<double, 2>> interval{};
  double mark = 0;
};

/// One detector: a bar for each texture.
inline Panel texture_panel(const ProtocolResult& result, const std::string& title,
                           const std::vector<TextureBar>& bars) {
  constexpr double left = 120, right = 338, top = 34, row_height = 22;
  const double bottom = top + row_height * static_cast<double>(result.textures.size());
  const auto x = [=](double share) { return left + share * (right - left); };
  std::string svg = svg_text(14, 18, "title", title) + share_axis(x, top, bottom);
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const auto& [share, interval, mark] = bars[k];
    const double middle = top + row_height * (static_cast<double>(k) + 0.5);
    svg += svg_text(left - 8, middle + 4, "end", result.textures[k]);
    const bool is_camouflage = result.has_camouflage && k == 1;
    svg += svg_rectangle(left, middle - 7, x(share) - left, 14,
                         is_camouflage ? "class=\"second\"" : "class=\"first\"");
    if (interval) svg += svg_interval(x, *interval, middle);
    svg += svg_rectangle(x(mark) - 2, middle - 9, 4, 18, "class=\"third\"");
  }
  return {358, bottom + 26, svg};
}

inline Figure texture_figure(const Protocol&, const ProtocolResult& result) {
  Figure figure{"How often detectors find the car in photographs",
                {},
                {{{"class=\"third\"", "mean best confidence, from 0 to 1"}},
                 "bars: photographs in which the car is found (P@0.5); lines: 95 % (Wilson)"},
                2};
  for (const auto& section : result.sections) {
    std::vector<TextureBar> bars;
    for (const auto& texture : section.cell.textures)
      bars.push_back({texture.rate.p_at_50, texture.rate.interval, texture.mean_best_confidence});
    figure.panels.push_back(texture_panel(result, section.name, bars));
  }
  return figure;
}

/// FCA's table 1: how often detectors find the car in photographs, untouched, clean, camouflaged and with
/// every control.
inline Protocol digital_protocol(const ProtocolSettings&, std::uint64_t, const ProtocolSubject& subject) {
  Protocol protocol = photograph_protocol("digital", "Photographs", subject);
  protocol.notes = {protocol.bare_name +
                    ": the untouched photograph; clean: the car in its own colours, rendered and laid over "
                    "it as every other texture is."};
  protocol.figure = texture_figure;
  return protocol;
}
}  // namespace tapestry::shell
