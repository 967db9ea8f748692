#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/views.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

std::size_t sector_of(double azimuth_deg) {
  if (!std::isfinite(azimuth_deg)) throw DomainError("sector_of: the azimuth is not finite");
  double wrapped = std::fmod(azimuth_deg, 360.0);
  if (wrapped < 0) wrapped += 360;  // may round to 360 itself
  return std::min(static_cast<std::size_t>(wrapped / 45), sector_count - 1);
}

}  // namespace tapestry::evaluate

namespace tapestry::evaluate::detail {

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

std::vector<std::string> short_numbers(const std::vector<double>& values) {
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const double value : values) texts.push_back(short_number(value));
  return texts;
}

}  // namespace tapestry::evaluate::detail

namespace tapestry::evaluate {

ProtocolTable view_table(const ViewGrid& grid) {
  ProtocolTable table{"azimuth", {}, "distance", detail::short_numbers(grid.distances)};
  for (std::size_t k = 0; k < sector_count; ++k)
    table.rows.push_back(std::to_string(45 * k) + "-" + std::to_string(45 * (k + 1)));
  return table;
}

std::vector<ProtocolFrame> view_frames(const ViewGrid& grid) {
  std::vector<ProtocolFrame> frames;
  detail::for_each_view("view_frames", grid,
                        [&](std::size_t column, double distance, double elevation, double azimuth) {
                          frames.push_back({distance, elevation, azimuth, sector_of(azimuth), column});
                        });
  return frames;
}

geometry::Camera protocol_camera(const ProtocolFrame& frame) {
  constexpr double rad_per_deg = std::numbers::pi / 180;
  return geometry::orbit_camera(frame.azimuth_deg * rad_per_deg, frame.elevation_deg * rad_per_deg,
                                frame.distance, {0, 0, 0}, 2 * protocol_half_fov_deg * rad_per_deg);
}

template <std::floating_point T>
camouflage::View<T> protocol_view(const ProtocolFrame& frame, const raster::PaintedMesh& car,
                                  const ProtocolPicture& picture) {
  io::Frame blank;
  blank.name = "distance " + detail::short_number(frame.distance) + ", elevation " +
               detail::short_number(frame.elevation_deg) + ", azimuth " +
               detail::short_number(frame.azimuth_deg);
  blank.camera = protocol_camera(frame);
  blank.image = Array<std::uint8_t, 3>(Extents<3>{1, 1, 3});  // as good as any other square of one colour
  for (std::size_t c = 0; c < 3; ++c)
    blank.image(0, 0, c) =
        static_cast<std::uint8_t>(std::lround(255 * std::clamp(picture.background[c], 0.0, 1.0)));
  return camouflage::make_view<T>(blank, car, picture.height, picture.width, picture.samples_per_axis,
                                  picture.fit);
}

template decltype(protocol_view<float>) protocol_view<float>;
template decltype(protocol_view<double>) protocol_view<double>;

}  // namespace tapestry::evaluate
