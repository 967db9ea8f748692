#pragma once
#include <tapestry/evaluate/controls.hpp>

namespace tapestry::evaluate {
namespace detail {

/// Picture of a view with its paint in one grey, in the space where paint and light multiply.
inline Array<float, 3> picture_in_grey(const camouflage::View<float>& view, camouflage::Paint<float> paint,
                                       float grey) {
  for (std::size_t texel = 0; texel < paint.colours.shape(0); ++texel)
    if (paint.painted.empty() || paint.painted[texel] != 0)
      for (std::size_t c = 0; c < 3; ++c) paint.colours(texel, c) = grey;
  return image::in_space(view.space, camouflage::picture_of(view, paint.colours));
}

/// The paint in a picture: pixel = dark + light · paint, in the view's space.
struct PaintInPicture {
  Array<float, 3> dark, light;  ///< [H, W, 3]
  Array<float, 2> paint{};      ///< [pixel, 3], encoded as a texture's colours are
  /// Pixels that show it, in the box around them.
  std::vector<raster::TextureChart> charts{};
};

/// \param encoded  the view's picture with the paint
inline PaintInPicture paint_in_picture(const camouflage::View<float>& view,
                                       const camouflage::Paint<float>& paint,
                                       const Array<float, 3>& encoded) {
  constexpr float grey = 0.5F;          // white could exceed the picture's range in strong light
  constexpr float least_light = 2e-3F;  // less is rounding, and cannot be seen
  PaintInPicture found{picture_in_grey(view, paint, 0), picture_in_grey(view, paint, grey)};
  const auto picture = image::in_space(view.space, encoded);
  const float paint_of_grey = view.space == image::ColourSpace::linear ? image::linearised(grey) : grey;
  const std::size_t width = picture.shape(1), pixels = picture.shape(0) * width;
  found.paint = zeros<float, 2>({pixels, 3});
  raster::TextureChart chart;
  std::size_t top = pixels, left = width;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    bool shows = true;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      float& light = found.light.data()[i];
      light = (light - found.dark.data()[i]) / paint_of_grey;
      shows = shows && light > least_light;
    }
    if (!shows) continue;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const float shown = (picture.data()[i] - found.dark.data()[i]) / found.light.data()[i];
      found.paint.data()[i] =
          std::clamp(view.space == image::ColourSpace::linear ? image::encoded(std::max(shown, 0.0F)) : shown,
                     0.0F, 1.0F);
    }
    chart.texels.push_back({pixel / width, pixel % width, pixel});
    top = std::min(top, pixel / width);
    left = std::min(left, pixel % width);
  }
  for (raster::ChartTexel& texel : chart.texels) {
    texel.row -= top;
    texel.column -= left;
    chart.height = std::max(chart.height, texel.row + 1);
    chart.width = std::max(chart.width, texel.column + 1);
  }
  if (!chart.texels.empty()) found.charts.push_back(std::move(chart));
  return found;
}

}  // namespace detail

Array<float, 3> picture_with_noise(const camouflage::View<float>& view, const camouflage::Paint<float>& paint,
                                   const Random& random) {
  camouflage::require_sound("picture_with_noise", paint);
  auto picture = camouflage::picture_of(view, paint.colours);
  if (view.visible_pixels == 0) return picture;
  const auto found = detail::paint_in_picture(view, paint, picture);
  const auto noise = matched_noise(found.paint, found.charts, random, picture_noise_rounds);
  for (const raster::TextureChart& chart : found.charts)
    for (const raster::ChartTexel& texel : chart.texels)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = 3 * texel.texel + c;
        const float colour = noise(texel.texel, c);
        const float shown = view.space == image::ColourSpace::linear ? image::linearised(colour) : colour;
        const float value = found.dark.data()[i] + found.light.data()[i] * shown;
        picture.data()[i] = std::clamp(
            view.space == image::ColourSpace::linear ? image::encoded(std::max(value, 0.0F)) : value, 0.0F,
            1.0F);
      }
  return picture;
}

}  // namespace tapestry::evaluate
