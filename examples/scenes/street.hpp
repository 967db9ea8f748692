#pragma once
#include "props.hpp"
#include "scene_builder.hpp"

namespace tapestry::scenes {
/// The street's own frame has x along it; its middle is y = 0.
struct StreetPlan {
  Pose pose;              ///< world from street
  double half_width = 4;  ///< of the road; metres
  double walk_width = 3;  ///< of the pavements
  double set_back = 2;    ///< from the pavement to the buildings
  bool has_kerb = true;
  Colour road{}, walk{}, verge{};
};

/// `colour` brighter or darker by up to ± amount, and a little off in hue.
[[nodiscard]] inline Colour weathered(Random& random, const Colour& colour, double amount) {
  const auto shift = static_cast<float>(random.uniform(-amount, amount));
  return varied(random, {colour[0] + shift, colour[1] + shift, colour[2] + shift}, 0.025);
}

[[nodiscard]] inline Colour surface_colour(Random& random) {
  static constexpr Colour surfaces[] = {{0.24F, 0.24F, 0.25F}, {0.33F, 0.33F, 0.34F}, {0.44F, 0.43F, 0.42F},
                                        {0.58F, 0.57F, 0.54F}, {0.25F, 0.36F, 0.14F}, {0.42F, 0.34F, 0.24F},
                                        {0.52F, 0.36F, 0.30F}};
  return weathered(random, surfaces[random.index(std::size(surfaces))], 0.08);
}

[[nodiscard]] inline StreetPlan make_street(Random& random) {
  StreetPlan plan;
  plan.half_width = random.chance(0.25) ? random.uniform(8, 20) : random.uniform(3.2, 7);
  plan.walk_width = random.uniform(1.5, 5);
  plan.set_back = random.uniform(0, 8);
  plan.has_kerb = random.chance(0.75);
  const double yaw = random.chance(0.2) ? random.uniform(0, 2 * std::numbers::pi) : 0.04 * random.normal();
  const double lateral = random.uniform(-1, 1) * std::max(0.3, plan.half_width - 1.4);
  plan.pose = {lateral * std::sin(yaw), -lateral * std::cos(yaw), yaw};
  plan.road = random.chance(0.75) ? weathered(random, {0.32F, 0.32F, 0.33F}, 0.14) : surface_colour(random);
  plan.walk = random.chance(0.6) ? weathered(random, {0.54F, 0.53F, 0.51F}, 0.16) : surface_colour(random);
  plan.verge = surface_colour(random);
  return plan;
}

namespace detail {
inline void add_strip(MeshBuilder& builder, double y0, double y1, double z, std::int32_t material) {
  constexpr double reach = 160;
  builder.quad({-reach, y0, z}, {reach, y0, z}, {reach, y1, z}, {-reach, y1, z}, material);
}

inline void add_rectangle(MeshBuilder& builder, double x, double y, double half_x, double half_y, double z,
                          std::int32_t material) {
  builder.quad({x - half_x, y - half_y, z}, {x + half_x, y - half_y, z}, {x + half_x, y + half_y, z},
               {x - half_x, y + half_y, z}, material);
}

/// Lane and border lines, or the bays of a car park.
inline void add_markings(MeshBuilder& builder, const StreetPlan& plan, Random& random) {
  const Colour paint = random.chance(0.8) ? Colour{0.82F, 0.82F, 0.80F} : Colour{0.80F, 0.65F, 0.15F};
  const auto line = builder.material("", mixed(plan.road, paint, random.uniform(0.4, 1)));
  const double half = random.uniform(0.05, 0.09);
  if (plan.half_width > 8) {
    const double bay = random.uniform(2.3, 2.8), length = random.uniform(4.6, 5.4),
                 start = random.uniform(-1.5, 1.5);
    for (int i = -9; i <= 9; ++i)
      add_rectangle(builder, (i + 0.5) * bay, start, half, length / 2, 0.02, line);
    return;
  }
  const double dash = random.uniform(1, 3), gap = random.uniform(2, 5), shift = random.uniform(0, 5);
  for (int i = -8; i <= 8; ++i)
    add_rectangle(builder, i * (dash + gap) + shift, 0, dash / 2, half, 0.02, line);
  if (random.chance(0.5))
    for (const double side : {-1.0, 1.0})
      add_rectangle(builder, 0, side * (plan.half_width - 0.35), 90, half, 0.02, line);
}

inline void add_patches(MeshBuilder& builder, const StreetPlan& plan, Random& random) {
  const std::size_t count = random.index(7);
  for (std::size_t i = 0; i < count; ++i) {
    const auto patch = builder.material("", scaled(plan.road, random.uniform(0.7, 1.2)));
    const double x = random.uniform(-12, 12), y = random.uniform(-1, 1) * (plan.half_width - 0.6);
    const double half_x = random.uniform(0.2, 2.5), half_y = random.uniform(0.2, 0.55);
    add_rectangle(builder, x, y, half_x, half_y, 0.01, patch);
  }
  if (random.chance(0.3)) {  // tyre tracks
    const auto track = builder.material("", scaled(plan.road, random.uniform(0.8, 0.95)));
    const double y = random.uniform(-1, 1) * (plan.half_width - 1.2);
    for (const double side : {-0.75, 0.75}) add_rectangle(builder, 0, y + side, 90, 0.13, 0.008, track);
  }
}

/// One face of a building with a grid of windows, `across` metres wide from corner `a` to corner `b`.
inline void add_facade(MeshBuilder& builder, const Point& a, const Point& b, double height, double storey,
                       double bay, const std::array<std::int32_t, 4>& materials, Random& random) {
  const Point top_a{a[0], a[1], height}, top_b{b[0], b[1], height};
  builder.quad(a, b, top_b, top_a, materials[0]);
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  const double ux = (b[0] - a[0]) / length, uy = (b[1] - a[1]) / length;
  const auto columns = static_cast<std::size_t>(std::max(1.0, length / bay));
  const auto rows = static_cast<std::size_t>(std::max(1.0, height / storey));
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const double middle = (static_cast<double>(column) + 0.5) * length / static_cast<double>(columns);
      const double sill = static_cast<double>(row) * storey + 0.32 * storey;
      const auto at = [&](double along, double z) {
        return Point{a[0] + ux * along + 0.06 * uy, a[1] + uy * along - 0.06 * ux, z};
      };
      const double half = 0.3 * length / static_cast<double>(columns), top = sill + 0.5 * storey;
      builder.quad(at(middle - half, sill), at(middle + half, sill), at(middle + half, top),
                   at(middle - half, top), materials[1 + random.index(3)]);
    }
}

/// A block; only the walls that the eye sees are made.
inline void add_building(MeshBuilder& builder, double x0, double y0, double x1, double y1, const Point& eye,
                         Random& random) {
  const Colour wall = random.chance(0.2) ? any_colour(random) : muted_colour(random);
  const Colour glass = random.chance(0.7) ? Colour{0.16F, 0.19F, 0.23F} : muted_colour(random);
  const std::array<std::int32_t, 4> materials{builder.material("", wall), builder.material("", glass),
                                              builder.material("", scaled(glass, 0.8)),
                                              builder.material("", varied(random, scaled(glass, 1.3), 0.05))};
  const double height = random.uniform(3.5, 16), storey = random.uniform(2.6, 4),
               bay = random.uniform(1.8, 5);
  const std::array<Point, 4> corners{{{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}}};
  const std::array<bool, 4> seen{eye[1]<y0, eye[0]> x1, eye[1] > y1, eye[0] < x0};
  for (std::size_t side = 0; side < 4; ++side)
    if (seen[side])
      add_facade(builder, corners[side], corners[(side + 1) % 4], height, storey, bay, materials, random);
}
}  // namespace detail

/// Road, pavements with kerbs, verges, markings. Sets the scene's range of ground faces.
inline void add_ground(SceneBuilder& scene, const StreetPlan& plan, Random& random, std::size_t& ground_begin,
                       std::size_t& ground_end) {
  MeshBuilder builder;
  const auto road = builder.material("", plan.road);
  const auto walk = builder.material("", plan.walk);
  const auto verge = builder.material("", plan.verge);
  const auto kerb = builder.material("", scaled(plan.walk, 1.15));
  const double edge = plan.half_width, outer = edge + plan.walk_width, z = plan.has_kerb ? 0.12 : 0;
  detail::add_strip(builder, -edge, edge, 0, road);
  for (const double side : {-1.0, 1.0}) {
    const auto strip = [&](double from, double to, std::int32_t material) {
      detail::add_strip(builder, std::min(side * from, side * to), std::max(side * from, side * to), z,
                        material);
    };
    strip(edge, edge + 0.15, kerb);
    strip(edge + 0.15, outer, walk);
    strip(outer, outer + 150, verge);
    if (plan.has_kerb && side > 0)
      builder.quad({160, edge, 0}, {-160, edge, 0}, {-160, edge, z}, {160, edge, z}, kerb);
    if (plan.has_kerb && side < 0)
      builder.quad({-160, -edge, 0}, {160, -edge, 0}, {160, -edge, z}, {-160, -edge, z}, kerb);
  }
  detail::add_patches(builder, plan, random);
  if (random.chance(0.75)) detail::add_markings(builder, plan, random);
  ground_begin = scene.add(builder.mesh(), plan.pose);
  ground_end = ground_begin + builder.mesh().faces.size();
}

/// Rows of buildings on one or both sides, without those in the camera's way.
inline void add_buildings(SceneBuilder& scene, const StreetPlan& plan, Random& random) {
  MeshBuilder builder;
  const Point eye = plan.pose.inverse(scene.eye());
  const Point car = plan.pose.inverse({0, 0, 0});
  const double front = plan.half_width + plan.walk_width + plan.set_back;
  const auto hides_car = [&](double x0, double y0, double x1, double y1) {
    for (double t = 0; t <= 1; t += 0.05) {
      const double x = car[0] + t * (eye[0] - car[0]), y = car[1] + t * (eye[1] - car[1]);
      const double margin = 0.5 + 2.5 * (1 - t);
      if (x > x0 - margin && x < x1 + margin && y > y0 - margin && y < y1 + margin) return true;
    }
    return false;
  };
  for (const double side : {-1.0, 1.0}) {
    if (random.chance(0.25)) continue;
    double x = -45 + random.uniform(0, 10);
    while (x < 45) {
      const double width = random.uniform(6, 18), depth = random.uniform(6, 12),
                   back = front + random.uniform(0, 2);
      const double y0 = side > 0 ? back : -back - depth;
      const Point centre = plan.pose({x + width / 2, y0 + depth / 2, 0});
      if (scene.in_view(centre[0], centre[1], 12) && !hides_car(x, y0, x + width, y0 + depth) &&
          random.chance(0.9))
        detail::add_building(builder, x, y0, x + width, y0 + depth, eye, random);
      x += width + (random.chance(0.3) ? random.uniform(1, 8) : 0);
    }
  }
  scene.add(builder.mesh(), plan.pose);
}

/// Hedges, hills or far roofs along the horizon.
inline void add_skyline(SceneBuilder& scene, const Colour& haze, Random& random) {
  MeshBuilder builder;
  const Colour base = random.chance(0.6) ? Colour{0.22F, 0.30F, 0.18F} : detail::muted_colour(random);
  const double level = random.uniform(2, 9);
  constexpr int steps = 40;
  double height = level;
  for (int i = 0; i < steps; ++i) {
    const double a = 2 * std::numbers::pi * i / steps, b = 2 * std::numbers::pi * (i + 1) / steps;
    const auto material = builder.material("", mixed(varied(random, base, 0.04), haze, 0.35));
    const double next = std::clamp(height + random.uniform(-2.5, 2.5), 0.5, 2 * level);
    builder.quad({110 * std::cos(b), 110 * std::sin(b), -1}, {110 * std::cos(a), 110 * std::sin(a), -1},
                 {110 * std::cos(a), 110 * std::sin(a), height}, {110 * std::cos(b), 110 * std::sin(b), next},
                 material);
    height = next;
  }
  scene.add(builder.mesh(), {});
}
}  // namespace tapestry::scenes
