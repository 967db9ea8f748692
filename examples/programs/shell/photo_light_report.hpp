#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

#include "report.hpp"
#include "run_folder.hpp"

namespace tapestry::shell {

/// Mean differences of a view's picture from its photograph: over the car, over pixels that show paint, and
/// over the rest of it.
struct PhotoDifference {
  double car = 0, paint = 0, rest = 0;
};

inline PhotoDifference photo_difference(const camouflage::View<float>& view, const Array<float, 2>& colours) {
  const auto picture = camouflage::picture_of(view, colours);
  const auto& drawn = *view.paint_to_picture;
  std::array<double, 2> sums{0, 0}, counts{0, 0};  // of the rest, of paint
  for (std::size_t pixel = 0; pixel < drawn.coverage.size(); ++pixel) {
    if (!(drawn.coverage.data()[pixel] > 0)) continue;
    const std::size_t part = std::binary_search(drawn.pixels.begin(), drawn.pixels.end(), pixel) ? 1 : 0;
    const std::size_t row = pixel / drawn.width + view.window.top;
    const std::size_t column = pixel % drawn.width + view.window.left;
    for (std::size_t c = 0; c < 3; ++c)
      sums[part] += std::abs(static_cast<double>(picture(row, column, c) - view.background(row, column, c)));
    counts[part] += 3;
  }
  const auto mean = [](double sum, double count) { return count > 0 ? sum / count : 0; };
  return {mean(sums[0] + sums[1], counts[0] + counts[1]), mean(sums[1], counts[1]), mean(sums[0], counts[0])};
}

/// Colours of a car in the colour that a photograph shows of its paint.
inline Array<float, 2> observed_colours(const camouflage::View<float>& view, std::size_t texel_count) {
  auto product = view.photo_light->product;
  for (double& channel : product) {
    if (view.space == image::ColourSpace::linear) channel = image::encoded(channel);
    channel = std::clamp(channel, 0.0, 1.0);
  }
  return camouflage::solid_colours<float>(texel_count, product);
}

/// The light estimated from each view's photograph, by the view's name; null if the car could not be made
/// out, so that the frame's own light was used. Differences are those of the car in the colour that the
/// photograph shows of its paint.
inline Json light_json(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& views,
                       const raster::PaintedMesh& car) {
  Json lights = Json::object();
  for (const std::size_t index : views) {
    const auto view = store.view(index);
    Json& entry = lights[view->name] = nullptr;
    if (!view->photo_light) continue;
    const auto& [light, product, error] = *view->photo_light;
    const auto difference =
        photo_difference(*view, observed_colours(*view, car.layout.texel_count(car.mesh)));
    entry = {{"sun", light.sun},
             {"direction", light.direction},
             {"colour", light.colour},
             {"sky", light.sky},
             {"light_times_paint", product},
             {"mean_difference_of_points", error},
             {"mean_colour_error", difference.car},
             {"mean_colour_error_of_paint", difference.paint},
             {"mean_colour_error_of_rest", difference.rest},
             {"unpainted_faces_show", view->keeps_photograph ? "the photograph" : "their materials"}};
    if (view->registration) entry["registration"] = *view->registration;
  }
  return lights;
}

/// A word on the views whose photographs do not hold the car where the mesh is; empty if there are none.
inline std::string word_on_registration(camouflage::ViewStore<float>& store,
                                        const std::vector<std::size_t>& views) {
  std::size_t apart = 0;
  std::string first;
  for (const std::size_t index : views) {
    const auto view = store.view(index);
    if (!view->photo_light || view->keeps_photograph) continue;
    if (apart++ == 0) first = view->name + ": " + decimal_text(view->registration.value_or(0));
  }
  if (apart == 0) return {};
  return "in " + std::to_string(apart) + " of " + std::to_string(views.size()) +
         " views the mask is not the car's silhouette (IoU below 0.9; " + first +
         "): unpainted faces show their materials there, not the photograph";
}

}  // namespace tapestry::shell
