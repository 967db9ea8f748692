#pragma once
#include <cstddef>
#include <tapestry/camouflage/view_store.hpp>
#include <vector>

#include "run_folder.hpp"

namespace tapestry::shell {

/// The light estimated from each view's photograph, by the view's name; null if the car could not be made
/// out, so that the frame's own light was used.
inline Json light_json(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& views) {
  Json lights = Json::object();
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
             {"mean_colour_error_over", "painted points in view that the photograph does not saturate"}};
  }
  return lights;
}

}  // namespace tapestry::shell
