#pragma once
#include <tapestry/evaluate/controls.hpp>

namespace tapestry::evaluate {
namespace detail {
void require_chart_colours(const char* operation, const Array<float, 2>& colours,
                           const std::vector<raster::TextureChart>& charts) {
  if (colours.shape(1) != 3)
    throw ShapeError(
        {operation, ": colours are [", colours.shape(0), ", ", colours.shape(1), "], expected 3 channels"});
  for (const raster::TextureChart& chart : charts)
    for (const raster::ChartTexel& texel : chart.texels) {
      if (texel.texel >= colours.shape(0))
        throw ShapeError(
            {operation, ": a chart has texel ", texel.texel, " of a texture of ", colours.shape(0)});
      for (std::size_t c = 0; c < 3; ++c)
        if (!std::isfinite(colours(texel.texel, c)))
          throw NumericError({operation, ": texel ", texel.texel, " has a colour that is not finite"});
    }
}

inline constexpr std::size_t no_texel = std::numeric_limits<std::size_t>::max();

class PatchCutter {
 public:
  explicit PatchCutter(const raster::TextureChart& chart)
      : height_(chart.height), width_(chart.width), texels_(chart.height * chart.width, no_texel) {
    for (const raster::ChartTexel& texel : chart.texels)
      texels_[texel.row * width_ + texel.column] = texel.texel;
  }

  /// Takes the patches of a grid from the upper left corner of the box that still have all of their texels;
  /// none if there are fewer than two.
  /// \returns  the texels of each, row by row
  [[nodiscard]] std::vector<std::vector<std::size_t>> cut(const PatchExtents& extents) {
    std::vector<std::vector<std::size_t>> patches;
    std::vector<std::size_t> places;
    for (std::size_t top = 0; top + extents.height <= height_; top += extents.height)
      for (std::size_t left = 0; left + extents.width <= width_; left += extents.width) {
        std::vector<std::size_t> patch;
        for (std::size_t row = top; row < top + extents.height; ++row)
          for (std::size_t column = left; column < left + extents.width; ++column)
            patch.push_back(row * width_ + column);
        if (std::any_of(patch.begin(), patch.end(), [&](std::size_t at) { return texels_[at] == no_texel; }))
          continue;
        places.insert(places.end(), patch.begin(), patch.end());
        for (std::size_t& at : patch) at = texels_[at];
        patches.push_back(std::move(patch));
      }
    if (patches.size() < 2) return {};
    for (const std::size_t at : places) texels_[at] = no_texel;
    return patches;
  }

 private:
  std::size_t height_, width_;
  std::vector<std::size_t> texels_;
};

/// A random permutation of a single cycle: with two items or more, each goes to another's place. Source:
/// Sattolo, "An algorithm to generate a random cyclic permutation" (Information Processing Letters 22, 1986).
template <class Item>
void shuffle_in_a_cycle(std::vector<Item>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.index(i - 1)]);
}

/// Share of the values of some texels that are equal in two paints.
inline double share_in_place(const Array<float, 2>& a, const Array<float, 2>& b,
                             const raster::TextureChart& chart) {
  std::size_t same = 0;
  for (const raster::ChartTexel& texel : chart.texels)
    for (std::size_t c = 0; c < 3; ++c) same += a(texel.texel, c) == b(texel.texel, c) ? 1U : 0U;
  return chart.texels.empty() ? 0 : static_cast<double>(same) / static_cast<double>(3 * chart.texels.size());
}
}  // namespace detail

PatchExtents patch_extents(const raster::TextureLayout& layout) {
  if (layout.traits().is_picture) {
    const std::size_t edge = std::max<std::size_t>(1, layout.height / 8);
    return {edge, edge};
  }
  if (layout.traits().is_by_face) return {1, raster::detail::used_cube_texels(layout.texels_per_edge).size()};
  return {};
}

Array<float, 2> shuffled_patches(const Array<float, 2>& colours,
                                 const std::vector<raster::TextureChart>& charts, PatchExtents patch,
                                 const Random& random) {
  detail::require_chart_colours("shuffled_patches", colours, charts);
  if (patch.height == 0 || patch.width == 0)
    throw DomainError("shuffled_patches: a patch must have rows and columns");
  Array<float, 2> shuffled = colours;
  for (std::size_t i = 0; i < charts.size(); ++i) {
    Random of_chart = random.fork(i);
    detail::PatchCutter cutter(charts[i]);
    for (PatchExtents extents = patch;; extents = {std::max<std::size_t>(1, extents.height / 2),
                                                   std::max<std::size_t>(1, extents.width / 2)}) {
      const auto places = cutter.cut(extents);
      auto sources = places;
      detail::shuffle_in_a_cycle(sources, of_chart);
      for (std::size_t p = 0; p < places.size(); ++p)
        for (std::size_t k = 0; k < places[p].size(); ++k)
          for (std::size_t c = 0; c < 3; ++c) shuffled(places[p][k], c) = colours(sources[p][k], c);
      if (extents.height == 1 && extents.width == 1) break;
    }
  }
  return shuffled;
}

std::vector<std::uint8_t> faces_seen_around(const geometry::Mesh& mesh) {
  constexpr std::array<double, 4> elevations_deg{0, 15, 35, 60};
  constexpr std::size_t azimuths = 16;
  constexpr double rad_per_deg = std::numbers::pi / 180;
  const auto bounds = geometry::bounds_of(mesh.positions);
  const double radius = geometry::length(geometry::subtract(bounds.high, bounds.low)) / 2;
  if (!(radius > 0)) return std::vector<std::uint8_t>(mesh.faces.size(), 1);
  const double distance = 6 * radius, fov_rad = 2.1 * std::asin(radius / distance);
  const double fineness = std::sqrt(static_cast<double>(mesh.faces.size()) / 20000);  // of faces in a picture
  const auto side = static_cast<std::size_t>(512 * std::clamp(fineness, 1.0, 4.0));
  std::vector<std::uint8_t> is_seen(mesh.faces.size(), 0);
  for (std::size_t i = 0; i < elevations_deg.size() * azimuths; ++i) {
    const double azimuth = 2 * std::numbers::pi * static_cast<double>(i % azimuths) / azimuths;
    const auto camera = geometry::orbit_camera(azimuth, elevations_deg[i / azimuths] * rad_per_deg, distance,
                                               bounds.middle(), fov_rad);
    std::vector<std::uint8_t> samples(mesh.faces.size(), 0);  // rounding at an edge can give one sample
    for (const std::int32_t face : raster::visibility(mesh, camera, side, side, 2).face)
      if (face >= 0 && ++samples[static_cast<std::size_t>(face)] == 2)
        is_seen[static_cast<std::size_t>(face)] = 1;
  }
  if (std::ranges::find(is_seen, 1) == is_seen.end()) std::ranges::fill(is_seen, std::uint8_t{1});
  return is_seen;
}

raster::TextureChart joined_chart(const std::vector<raster::TextureChart>& charts,
                                  const raster::TextureLayout& layout) {
  raster::TextureChart joined;
  const bool is_picture = layout.traits().is_picture;
  if (is_picture) {
    joined.height = layout.height;
    joined.width = layout.width;
  }
  for (const raster::TextureChart& chart : charts) {
    for (const raster::ChartTexel& texel : chart.texels)
      joined.texels.push_back(
          is_picture ? raster::ChartTexel{texel.texel / layout.width, texel.texel % layout.width, texel.texel}
                     : raster::ChartTexel{joined.height + texel.row, texel.column, texel.texel});
    if (is_picture) continue;
    joined.height += chart.height;
    joined.width = std::max(joined.width, chart.width);
  }
  std::ranges::sort(joined.texels, {},
                    [](const raster::ChartTexel& texel) { return std::pair(texel.row, texel.column); });
  return joined;
}

std::vector<Control> matched_controls(const raster::PaintedMesh& car, const camouflage::Paint<float>& paint,
                                      std::uint64_t seed, std::size_t noise_draws) {
  const auto& colours = paint.colours;
  camouflage::require_sound("matched_controls", paint);
  require_shape("matched_controls", "colours", colours, {car.layout.texel_count(car.mesh), 3});
  raster::PaintedMesh seen = car;
  const auto is_seen = faces_seen_around(car.mesh);
  for (std::size_t face = 0; face < is_seen.size(); ++face)
    if (is_seen[face] == 0) seen.painted[face] = 0;
  const auto charts = raster::painted_charts(raster::texture_charts(seen), paint.painted);
  const auto whole = joined_chart(charts, car.layout);
  const Random of_noise = Random(seed).fork(0x6D617463686564ULL);
  std::vector<Control> controls;
  const auto add = [&](const char* name, Array<float, 2> drawn) {
    const double share = detail::share_in_place(drawn, colours, whole);
    controls.push_back({name, {std::move(drawn), paint.painted}, share});
  };
  for (std::size_t draw = 0; draw < noise_draws; ++draw)
    add(matched_noise_name,
        matched_noise(colours, {whole}, draw == 0 ? of_noise : of_noise.fork(0x64726177ULL + draw)));
  add(shuffled_patches_name,
      shuffled_patches(colours, charts, patch_extents(car.layout), Random(seed).fork(0x73687566666C65ULL)));
  return controls;
}

std::optional<double> noise_in_place(const std::vector<Control>& controls) {
  double sum = 0;
  std::size_t draws = 0;
  for (const Control& control : controls)
    if (control.name == matched_noise_name) {
      sum += control.share_in_place;
      ++draws;
    }
  return draws > 0 ? std::optional(sum / static_cast<double>(draws)) : std::nullopt;
}

std::vector<Control> plain_controls(std::size_t texel_count, std::uint64_t seed) {
  Random random = Random(seed).fork(0x636F6E74726F6CULL);
  std::vector<Control> controls;
  controls.push_back({"random", {camouflage::random_colours<float>(texel_count, random)}});
  const std::vector<std::pair<const char*, std::array<double, 3>>> solids{
      {"white", {0.95, 0.95, 0.95}}, {"grey", {0.5, 0.5, 0.5}},   {"black", {0.05, 0.05, 0.05}},
      {"red", {0.75, 0.08, 0.08}},   {"green", {0.1, 0.5, 0.15}}, {"blue", {0.1, 0.2, 0.7}}};
  for (const auto& [name, colour] : solids)
    controls.push_back({name, {camouflage::solid_colours<float>(texel_count, colour)}});
  return controls;
}

std::vector<Control> make_controls(const raster::PaintedMesh& car, const camouflage::Paint<float>& paint,
                                   std::uint64_t seed, std::size_t noise_draws) {
  auto controls = matched_controls(car, paint, seed, noise_draws);
  for (auto& control : plain_controls(paint.colours.shape(0), seed)) controls.push_back(std::move(control));
  return controls;
}
}  // namespace tapestry::evaluate
