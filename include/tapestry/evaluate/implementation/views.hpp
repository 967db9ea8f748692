#pragma once
#include <cstdio>
#include <tapestry/evaluate/views.hpp>

namespace tapestry::evaluate {
namespace detail {
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

/// A rectangle around a random point of a place, cut to the picture.
/// \param scale  its largest extent as a share of the place's
[[nodiscard]] inline Occluder random_occluder(const image::PixelWindow& place, std::size_t height,
                                              std::size_t width, double scale, Random& random) {
  const auto span = [&](std::size_t first, std::size_t count, std::size_t all) {
    const auto whole = static_cast<double>(count);
    const double extent = std::max(1.0, scale * whole * random.uniform(0.4, 1));
    const double begin = static_cast<double>(first) + random.uniform(0, whole) - extent / 2;
    const auto low =
        static_cast<std::size_t>(std::clamp(std::round(begin), 0.0, static_cast<double>(all - 1)));
    const auto high =
        static_cast<std::size_t>(std::clamp(std::round(begin + extent), 0.0, static_cast<double>(all)));
    return std::array<std::size_t, 2>{low, std::max(high, low + 1) - low};
  };
  const auto [top, rows] = span(place.top, place.height, height);
  const auto [left, columns] = span(place.left, place.width, width);
  Occluder occluder{{top, left, rows, columns}};
  for (auto* colour : {&occluder.colour, &occluder.other})
    for (float& channel : *colour) channel = static_cast<float>(random.uniform());
  const std::size_t period = 1 + random.index(1 + std::max(rows, columns) / 4);
  const std::size_t kind = random.index(6);  // half of them plain, half textured
  if (kind == 3 || kind == 5) occluder.period_x = period;
  if (kind == 4 || kind == 5) occluder.period_y = period;
  return occluder;
}
}  // namespace detail

std::size_t sector_of(double azimuth_deg) {
  if (!std::isfinite(azimuth_deg)) throw DomainError("sector_of: the azimuth is not finite");
  double wrapped = std::fmod(azimuth_deg, 360.0);
  if (wrapped < 0) wrapped += 360;  // may round to 360 itself
  return std::min(static_cast<std::size_t>(wrapped / 45), sector_count - 1);
}

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

camouflage::View<float> protocol_view(const ProtocolFrame& frame, const raster::PaintedMesh& car,
                                      const ProtocolPicture& picture) {
  io::Frame blank;
  blank.name = "distance " + detail::short_number(frame.distance) + ", elevation " +
               detail::short_number(frame.elevation_deg) + ", azimuth " +
               detail::short_number(frame.azimuth_deg);
  blank.camera = protocol_camera(frame);
  blank.image = Array<std::uint8_t, 3>(Extents<3>{1, 1, 3});  // any square of one colour will do
  for (std::size_t c = 0; c < 3; ++c)
    blank.image(0, 0, c) =
        static_cast<std::uint8_t>(std::lround(255 * std::clamp(picture.background[c], 0.0, 1.0)));
  return camouflage::make_view<float>(blank, car, picture.height, picture.width, picture.samples_per_axis,
                                      picture.fit);
}

HiddenPixels::HiddenPixels(const Array<float, 2>& coverage, const image::PixelWindow& place)
    : coverage_(coverage), place_(place), is_hidden_(zeros<std::uint8_t, 2>(coverage.shape())) {
  require_shape("HiddenPixels", "coverage", coverage, {place.height, place.width});
  for (const float share : coverage.storage()) total_ += static_cast<double>(share);
}

double HiddenPixels::gain_of(const image::PixelWindow& window) const {
  double gain = 0;
  for_each_pixel(window, [&](std::size_t y, std::size_t x) {
    if (is_hidden_(y, x) == 0) gain += static_cast<double>(coverage_(y, x));
  });
  return gain;
}

void HiddenPixels::hide(const image::PixelWindow& window) {
  hidden_ += gain_of(window);
  for_each_pixel(window, [&](std::size_t y, std::size_t x) { is_hidden_(y, x) = 1; });
}

std::optional<Occlusion> draw_occlusion(const Array<float, 2>& coverage, const image::PixelWindow& place,
                                        std::size_t height, std::size_t width, OcclusionGroup group,
                                        Random random) {
  image::require_window("draw_occlusion", place, height, width);
  HiddenPixels hidden(coverage, place);
  const auto [low, high] = hidden_shares[static_cast<std::size_t>(group)];
  const double wanted = random.uniform(low, high);
  double scale = std::sqrt(wanted);
  Occlusion occlusion;
  constexpr int most_attempts = 400;
  for (int attempt = 0; attempt < most_attempts && place.height > 0 && place.width > 0; ++attempt) {
    const Occluder occluder = detail::random_occluder(place, height, width, scale, random);
    const double gain = hidden.gain_of(occluder.window);
    if (!(gain > 0)) continue;
    const double share = hidden.share_with(gain);
    if (share > high || occlusion_group(share) > group) {
      scale *= 0.8;
      continue;
    }
    hidden.hide(occluder.window);
    occlusion.occluders.push_back(occluder);
    occlusion.hidden_share = hidden.share();
    if (occlusion.hidden_share >= wanted && occlusion_group(occlusion.hidden_share) == group)
      return occlusion;
  }
  return std::nullopt;
}

void lay_occluders(Array<float, 3>& picture, const std::vector<Occluder>& occluders) {
  for (const Occluder& occluder : occluders) {
    const auto& [top, left, height, width] = occluder.window;
    image::require_window("lay_occluders", occluder.window, picture.shape(0), picture.shape(1));
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        const bool odd_x = occluder.period_x > 0 && x / occluder.period_x % 2 != 0;
        const bool odd_y = occluder.period_y > 0 && y / occluder.period_y % 2 != 0;
        const auto& colour = odd_x != odd_y ? occluder.other : occluder.colour;
        for (std::size_t c = 0; c < 3; ++c) picture(top + y, left + x, c) = static_cast<float>(colour[c]);
      }
  }
}

ProtocolTable occlusion_table(const ViewGrid& grid) {
  return {"occlusion",
          {"small (<= 30 %)", "middle (30-70 %)", "large (>= 70 %)"},
          "distance",
          detail::short_numbers(grid.distances)};
}

std::vector<ProtocolFrame> occlusion_frames(const ViewGrid& grid) {
  std::vector<ProtocolFrame> frames;
  for (std::size_t group = 0; group < occlusion_group_names.size(); ++group)
    detail::for_each_view("occlusion_frames", grid,
                          [&](std::size_t column, double distance, double elevation, double azimuth) {
                            frames.push_back({distance, elevation, azimuth, group, column});
                          });
  return frames;
}
}  // namespace tapestry::evaluate
