#pragma once
#include <tapestry/core/random.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
/// Draws a street scene: the main vehicle at the origin in the world's frame, so that the scene's
/// camera is also the one to render the vehicle alone with.
[[nodiscard]] Scene make_scene(Random& random, const SceneOptions& options);
}  // namespace tapestry::scenes
