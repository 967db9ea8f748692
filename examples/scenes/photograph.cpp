#include "photograph.hpp"

#include <tapestry/image/resize.hpp>

#include "scene_parts.hpp"

namespace tapestry::scenes {

Array<float, 3> halved(const Array<float, 3>& picture) {
  Array<float, 3> half(Extents<3>{picture.shape(0) / 2, picture.shape(1) / 2, 3});
  for (std::size_t row = 0; row < half.shape(0); ++row)
    for (std::size_t column = 0; column < half.shape(1); ++column)
      for (std::size_t c = 0; c < 3; ++c)
        half(row, column, c) =
            (picture(2 * row, 2 * column, c) + picture(2 * row, 2 * column + 1, c) +
             picture(2 * row + 1, 2 * column, c) + picture(2 * row + 1, 2 * column + 1, c)) /
            4;
  return half;
}

Array<float, 3> resized_photograph(Array<float, 3> picture, std::size_t size) {
  while (std::max(picture.shape(0), picture.shape(1)) >= 2 * size) picture = halved(picture);
  const double factor =
      static_cast<double>(size) / static_cast<double>(std::max(picture.shape(0), picture.shape(1)));
  const auto scaled_side = [&](std::size_t side) {
    return std::max<std::size_t>(1,
                                 static_cast<std::size_t>(std::lround(factor * static_cast<double>(side))));
  };
  return image::resize_bilinear(picture, scaled_side(picture.shape(0)), scaled_side(picture.shape(1)));
}

geometry::Camera photograph_camera(const PhotographOptions& options, double ahead, double left, double yaw,
                                   double aspect) {
  const double pitch = options.pitch_deg * std::numbers::pi / 180;
  const auto turned = [c = std::cos(yaw), s = std::sin(yaw)](double x, double y, double z) {
    return Point{c * x + s * y, -s * x + c * y, z};
  };
  geometry::Camera camera = geometry::look_along(turned(-ahead, -left, options.camera_height_m),
                                                 turned(std::cos(pitch), 0, -std::sin(pitch)),
                                                 turned(std::sin(pitch), 0, std::cos(pitch)));
  camera.tan_half_fov_x = std::tan(options.fov_deg * std::numbers::pi / 360);
  camera.tan_half_fov_y = camera.tan_half_fov_x / aspect;
  return camera;
}

bool shows_whole_vehicle(const Vehicle& vehicle, const PhotographOptions& options, double aspect) {
  const auto is_in_view = [&](double ahead, double left, double yaw) {
    const auto camera = photograph_camera(options, ahead, left, yaw, aspect);
    return std::ranges::all_of(vehicle.mesh.positions, [&](const Point& position) {
      const Point view = geometry::add(geometry::multiply(camera.rotation, position), camera.translation);
      return view[2] > 0 && std::abs(view[0]) < camera.tan_half_fov_x * view[2] &&
             std::abs(view[1]) < camera.tan_half_fov_y * view[2];
    });
  };
  constexpr int steps = 12;
  const auto [nearest, farthest] = options.distance_m;
  for (int side = 0; side < steps; ++side) {
    const double yaw = 2 * std::numbers::pi * side / steps;
    bool is_seen = false;
    for (int step = 0; step < steps && !is_seen; ++step) {
      const double ahead = farthest - (farthest - nearest) * step / (steps - 1);
      const double left = 0.05 * ahead * std::tan(options.fov_deg * std::numbers::pi / 360);
      is_seen = is_in_view(ahead, left, yaw) && is_in_view(ahead, -left, yaw);
    }
    if (!is_seen) return false;
  }
  return true;
}

Scene make_scene_in_photograph(Random& random, Array<float, 3> photograph, const Vehicle& vehicle,
                               const PhotographOptions& options) {
  Scene scene;
  scene.car = vehicle.mesh;
  scene.light = any_light(random);
  const double aspect = static_cast<double>(photograph.shape(1)) / static_cast<double>(photograph.shape(0));
  const double ahead = draw(random, options.distance_m);
  const double reach = ahead * std::tan(options.fov_deg * std::numbers::pi / 360);
  const double left = random.uniform(-0.6, 0.6) * reach;
  scene.camera = photograph_camera(options, ahead, left, draw(random, options.yaw_rad), aspect);
  scene.photograph = std::move(photograph);
  SceneBuilder builder(scene);
  SceneOptions car;
  car.vehicle = &vehicle;
  add_vehicle(builder, scene, car, random);
  fill_attributes(scene.mesh);
  return scene;
}

}  // namespace tapestry::scenes
