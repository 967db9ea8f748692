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

std::optional<Colour> ground_colour(const Array<float, 3>& photograph, const geometry::Camera& camera,
                                    double nearest_m, double farthest_m) {
  constexpr int rings = 8, spokes = 48;
  const auto height = static_cast<double>(photograph.shape(0)),
             width = static_cast<double>(photograph.shape(1));
  std::array<std::vector<float>, 3> seen;
  for (int place = 0; place < rings * spokes; ++place) {
    const double angle = 2 * std::numbers::pi * (place % spokes) / spokes;
    const double radius = nearest_m + (farthest_m - nearest_m) * (place / spokes) / (rings - 1);
    const Point view =
        geometry::view_from_world(camera, {radius * std::cos(angle), radius * std::sin(angle), 0});
    if (!(view[2] > camera.near)) continue;
    const auto [row, column] = geometry::picture_from_view(camera, view, height, width);
    if (!(row >= 0 && row < height && column >= 0 && column < width)) continue;
    for (std::size_t c = 0; c < 3; ++c)
      seen[c].push_back(photograph(static_cast<std::size_t>(row), static_cast<std::size_t>(column), c));
  }
  if (seen[0].size() < spokes / 4) return std::nullopt;
  Colour median{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto middle = seen[c].begin() + static_cast<std::ptrdiff_t>(seen[c].size() / 2);
    std::nth_element(seen[c].begin(), middle, seen[c].end());
    median[c] = *middle;
  }
  return median;
}

raster::Light light_of_ground(raster::Light sun, const Array<float, 3>& photograph,
                              const geometry::Camera& camera) {
  const auto around = ground_colour(photograph, camera, 2.5, 5),
             wide = ground_colour(photograph, camera, 2.5, 25);
  if (!around || !wide) return sun;
  const auto grey = [](const Colour& colour) {
    return static_cast<double>(colour[0] + colour[1] + colour[2]) / 3;
  };
  const double before = sun.ambient + sun.directional * sun.direction[2];
  const double exposure = std::clamp(grey(*around) / asphalt, 0.15, 1.3);
  sun.colour = {1, 1, 1};
  const bool is_in_shade = grey(*around) < 0.6 * grey(*wide);
  const double direct = is_in_shade ? 0 : sun.directional * sun.direction[2] / before;
  sun.directional = exposure * direct / sun.direction[2];
  sun.ambient = exposure * (1 - direct);
  for (std::size_t c = 0; c < 3 && grey(*around) > 0; ++c)
    sun.colour[c] = std::clamp(static_cast<double>((*around)[c]) / grey(*around), 0.8, 1.2);
  return sun;
}

Scene make_scene_in_photograph(Random& random, Array<float, 3> photograph, const Vehicle& vehicle,
                               const PhotographOptions& options) {
  Scene scene;
  scene.car = vehicle.mesh;
  const raster::Light sun = any_light(random);
  const double aspect = static_cast<double>(photograph.shape(1)) / static_cast<double>(photograph.shape(0));
  const double ahead = draw(random, options.distance_m);
  const double reach = ahead * std::tan(options.fov_deg * std::numbers::pi / 360);
  const double left = random.uniform(-0.6, 0.6) * reach;
  scene.camera = photograph_camera(options, ahead, left, draw(random, options.yaw_rad), aspect);
  scene.light = light_of_ground(sun, photograph, scene.camera);
  scene.photograph = std::move(photograph);
  SceneBuilder builder(scene);
  SceneOptions car;
  car.vehicle = &vehicle;
  add_vehicle(builder, scene, car, random);
  fill_attributes(scene.mesh);
  return scene;
}
}  // namespace tapestry::scenes
