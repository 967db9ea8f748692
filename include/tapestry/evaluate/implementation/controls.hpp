#pragma once
#include <tapestry/evaluate/controls.hpp>

namespace tapestry::evaluate::detail {

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

}  // namespace tapestry::evaluate::detail

namespace tapestry::evaluate {

PatchExtents patch_extents(const raster::TextureLayout& layout) {
  if (layout.kind == raster::TextureKind::atlas) {
    const std::size_t edge = std::max<std::size_t>(1, layout.height / 8);
    return {edge, edge};
  }
  if (layout.kind == raster::TextureKind::cube)
    return {1, raster::detail::used_cube_texels(layout.texels_per_edge).size()};
  return {};
}

}  // namespace tapestry::evaluate

namespace tapestry::evaluate::detail {

inline constexpr std::size_t no_texel = std::numeric_limits<std::size_t>::max();

/// A chart from which patches are taken away one by one.
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

}  // namespace tapestry::evaluate::detail

namespace tapestry::evaluate {

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

std::vector<Control> matched_controls(const raster::PaintedMesh& car, const camouflage::Paint<float>& paint,
                                      std::uint64_t seed, std::size_t noise_draws) {
  const auto& [colours, painted] = paint;
  camouflage::require_sound("matched_controls", paint);
  require_shape("matched_controls", "colours", colours, {car.layout.texel_count(car.mesh), 3});
  const auto charts = raster::painted_charts(raster::texture_charts(car), painted);
  const Random of_noise = Random(seed).fork(0x6D617463686564ULL);
  std::vector<Control> controls;
  for (std::size_t draw = 0; draw < noise_draws; ++draw)
    controls.push_back(
        {matched_noise_name,
         {matched_noise(colours, charts, draw == 0 ? of_noise : of_noise.fork(0x64726177ULL + draw)),
          painted}});
  auto shuffled =
      shuffled_patches(colours, charts, patch_extents(car.layout), Random(seed).fork(0x73687566666C65ULL));
  controls.push_back({shuffled_patches_name, {std::move(shuffled), painted}});
  return controls;
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
