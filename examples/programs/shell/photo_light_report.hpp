#pragma once

#include "export_check.hpp"

namespace tapestry::shell {

/// Colours of a car whose paint has the colour that a photograph shows.
inline Array<float, 2> observed_colours(const camouflage::View<float>& view, std::size_t texel_count) {
  auto colour = view.photo_light->product;
  for (std::size_t c = 0; c < 3; ++c) {
    const double light = view.photo_light->light.colour[c];
    colour[c] = std::clamp(light > 0 ? colour[c] / light : 0, 0.0, 1.0);
    if (view.space == image::ColourSpace::linear) colour[c] = image::encoded(colour[c]);
  }
  return camouflage::solid_colours<float>(texel_count, colour);
}

/// The light estimated from some views' photographs, and the difference between them and the car in the
/// colour that the photograph shows of its paint: over the whole car, over pixels that show paint, over the
/// rest, as means over pixels and encoded channels.
class PhotoLightReport {
 public:
  PhotoLightReport(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& views,
                   const raster::PaintedMesh& car) {
    for_each_in_order(
        views.size(), [&](std::size_t i) { return store.view(views[i]); },
        [&](std::size_t, const auto& view) { add(*view, car.layout.texel_count(car.mesh)); });
  }

  /// Light by the name of a view; null if the car was not recognised and the frame's light was used.
  [[nodiscard]] const Json& json() const { return json_; }

 private:
  void add(const camouflage::View<float>& view, std::size_t texel_count) {
    Json& entry = json_[view.name] = nullptr;
    if (!view.photo_light) return;
    const auto& [light, product, error] = *view.photo_light;
    entry = {{"sun", light.sun},
             {"direction", light.direction},
             {"colour", light.colour},
             {"sky", light.sky},
             {"light_times_paint", product},
             {"mean_difference_of_points_in_the_colour_space", error}};
    const auto picture = camouflage::picture_of(view, observed_colours(view, texel_count));
    const auto& paint = view.paint_to_picture->pixels;
    const auto mean = [&](auto is_counted) {
      return difference_over_car(picture, view.background, view, is_counted).mean;
    };
    const auto is_paint = [&](std::size_t pixel) {
      return std::binary_search(paint.begin(), paint.end(), pixel);
    };
    entry["mean_colour_error"] = mean([](std::size_t) { return true; });
    entry["mean_colour_error_of_paint"] = mean(is_paint);
    entry["mean_colour_error_of_rest"] = mean([&](std::size_t pixel) { return !is_paint(pixel); });
    entry["unpainted_faces_show"] = view.keeps_photograph ? "the photograph" : "their materials";
    if (view.registration) entry["registration"] = *view.registration;
  }

  Json json_ = Json::object();
};

}  // namespace tapestry::shell
