#pragma once
#include "export_check.hpp"

namespace tapestry::shell {
/// Colours of a car as a photograph shows them: of its paint, and of faces of another colour.
inline Array<float, 2> observed_colours(const camouflage::View<float>& view, const raster::PaintedMesh& car) {
  const raster::EstimatedLight& estimate = *view.photo_light;
  const auto encoded = [&](std::array<double, 3> colour) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double light = estimate.light.colour[c];
      colour[c] = std::clamp(light > 0 ? colour[c] / light : 0, 0.0, 1.0);
      if (view.space == image::ColourSpace::linear) colour[c] = image::encoded(colour[c]);
    }
    return colour;
  };
  const std::array others{encoded(estimate.other[0]), encoded(estimate.other[1])};
  auto colours =
      camouflage::solid_colours<float>(car.layout.texel_count(car.mesh), encoded(estimate.product));
  for (std::size_t face = 0; face < estimate.others.size(); ++face)
    if (estimate.others[face] != 0 && car.painted[face] != 0)
      raster::for_each_texel_on(car.layout, car.mesh, face, [&](std::size_t texel, const auto&) {
        for (std::size_t c = 0; c < 3; ++c)
          colours(texel, c) = static_cast<float>(others[estimate.others[face] - 1U][c]);
      });
  return colours;
}

/// How far the direction of an estimated sun can be trusted.
inline std::string word_on_sun(const raster::EstimatedLight& estimate) {
  if (!(estimate.light.sun > 0)) return "there is no sun";
  const double within =
      std::max(estimate.sun_within_rad, estimate.held_out ? estimate.held_out->sun_turn_rad : 0);
  if (within > raster::unknown_sun_rad) return "not known: others explain the car as well";
  return "known within " + formatted("%.0f", within * 180 / std::numbers::pi) + " degrees";
}

/// Errors of an estimated light, first on photographs that it was not fitted to.
inline Json light_errors(const raster::EstimatedLight& estimate) {
  Json errors = Json::object();
  if (const auto& held = estimate.held_out)
    errors["photographs_held_out"] = {{"mean_colour_error_of_paint", held->error},
                                      {"mean_colour_error_with_other_colours", held->error_of_all},
                                      {"sun_turns_by_degrees", held->sun_turn_rad * 180 / std::numbers::pi},
                                      {"sun_changes_by_share", held->sun_change}};
  else
    errors["photographs_held_out"] = "none: the light is fitted to one photograph, and may fit no other";
  errors["photographs_fitted"] = {{"count", estimate.views},
                                  {"mean_colour_error_of_paint", estimate.error},
                                  {"mean_colour_error_with_other_colours", estimate.error_of_all},
                                  {"share_of_other_colours", estimate.other_share}};
  return errors;
}

/// The light estimated from some views' photographs, its errors on held-out photographs first, and the
/// difference between them and the car in the colour that the photograph shows of its paint: over the whole
/// car, over pixels that show paint, over the rest, as means over pixels and encoded channels.
class PhotoLightReport {
 public:
  PhotoLightReport(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& views,
                   const raster::PaintedMesh& car) {
    for_each_in_order(
        views.size(), [&](std::size_t i) { return store.view(views[i]); },
        [&](std::size_t, const auto& view) { add(*view, car); });
  }

  /// Light by the name of a view; null if the car was not recognised and the frame's light was used.
  [[nodiscard]] const Json& json() const { return json_; }

 private:
  void add(const camouflage::View<float>& view, const raster::PaintedMesh& car) {
    Json& entry = json_[view.name] = nullptr;
    if (!view.photo_light) return;
    const auto& light = view.photo_light->light;
    entry = light_errors(*view.photo_light);
    entry["direction_of_sun"] = word_on_sun(*view.photo_light);
    entry["white_point"] = "assumed: sun and sky are white";
    entry["sun"] = light.sun;
    entry["direction"] = light.direction;
    entry["colour"] = light.colour;
    entry["sky"] = light.sky;
    entry["light_times_paint"] = view.photo_light->product;
    if (light.coat) entry["coat_exponent"] = light.coat->exponent;
    const auto picture = camouflage::picture_of(view, observed_colours(view, car));
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
