#pragma once
#include <tapestry/core/random.hpp>
#include "scene_builder.hpp"

namespace tapestry::scenes {
// Parts of scenes in streets and in photographs.

/// A number of the range, uniform.
[[nodiscard]] double draw(Random& random, const std::pair<double, double>& range);

/// Sun or overcast, warm or cold; a white horizontal surface ends between 0.75 and 1.15.
[[nodiscard]] raster::Light any_light(Random& random);

/// A mesh of the user's, its painted faces in one colour.
void add_vehicle(SceneBuilder& builder, Scene& scene, const SceneOptions& options, Random& random);

/// A mesh of positions and faces alone gets the lists that belong to its faces.
void fill_attributes(geometry::Mesh& mesh);
}  // namespace tapestry::scenes
