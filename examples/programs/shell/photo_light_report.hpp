#pragma once
#include <cstddef>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

#include "export_check.hpp"
#include "run_folder.hpp"

namespace tapestry::shell {

/// The light estimated from each view's photograph, by the view's name; null if the car could not be made
/// out, so that the frame's own light was used. The error over the whole car is that of the car drawn in its
/// own colours, unpainted parts included, beside the photograph.
inline Json light_json(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& views,
                       const raster::PaintedMesh& car) {
  Json lights = Json::object();
  const auto own = camouflage::own_colours<float>(car);
  for (const std::size_t index : views) {
    const auto view = store.view(index);
    Json& entry = lights[view->name] = nullptr;
    if (!view->photo_light) continue;
    const auto& [light, product, error] = *view->photo_light;
    entry = {{"sun", light.sun},
             {"direction", light.direction},
             {"colour", light.colour},
             {"sky", light.sky},
             {"light_times_paint", product},
             {"mean_colour_error", error},
             {"mean_colour_error_over", "painted points in view that the photograph does not saturate"},
             {"mean_colour_error_of_car",
              difference_over_car(camouflage::picture_of(*view, own), view->background, *view).mean}};
  }
  return lights;
}

}  // namespace tapestry::shell
