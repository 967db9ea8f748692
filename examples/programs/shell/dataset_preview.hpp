#pragma once
#include <tapestry/io/frame.hpp>
#include <tapestry/io/image_file.hpp>
#include "picture_sheet.hpp"

namespace tapestry::shell {
struct FramePlace {
  bool held_out;
  std::size_t index;

  [[nodiscard]] std::string name() const {
    const std::string number = std::to_string(index);
    return (held_out ? "test/" : "train/") + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') +
           number;
  }
};

/// A frame's picture with the box of its car and, in blue, the horizon of its camera.
inline MarkedPicture marked_frame(const io::Frame& frame, bool has_horizon) {
  constexpr Colour blue{40, 120, 255};
  MarkedPicture marked{frame.image, {}};
  if (frame.label) marked.boxes.push_back({frame.label->box, "", found_colour});
  const auto height = static_cast<double>(frame.image.shape(0));
  const auto width = static_cast<double>(frame.image.shape(1));
  if (!has_horizon || !frame.camera) return marked;
  const auto& forward = frame.camera->rotation[2];  // z is up
  const auto ahead = geometry::multiply(frame.camera->rotation, {forward[0], forward[1], 0});
  const double row = geometry::picture_from_view(*frame.camera, ahead, height, width)[0];
  if (row >= 0 && row < height) marked.boxes.push_back({{width / 2, row, width, 1}, "", blue});
  return marked;
}

/// Writes a sheet of at most twelve frames, evenly spread, each under its name.
/// \param train, test  frames of the two parts
/// \param draw         returns the frame of a place
template <class Draw>
void write_preview(const std::string& path, std::size_t train, std::size_t test, bool has_horizon,
                   Draw draw) {
  const std::size_t total = train + test, shown = std::min<std::size_t>(12, total);
  std::vector<FramePlace> places;
  for (const std::size_t i : shown_places(shown, total))
    places.push_back({i >= train, i >= train ? i - train : i});
  PictureSheet sheet(shown);
  std::vector<MarkedPicture> pictures(shown);
  parallel_for(shown, [&](std::size_t i) {
    pictures[i] = fitted_within(marked_frame(draw(places[i]), has_horizon), sheet.side());
  });
  for (std::size_t i = 0; i < shown; ++i) sheet.add(places[i].name(), std::move(pictures[i]));
  io::write_image(path, sheet.bitmap());
}
}  // namespace tapestry::shell
