#pragma once
#include "paint.hpp"

namespace tapestry::scenes {
/// Street furniture in its own frame: on the ground, around the origin.
struct Prop {
  geometry::Mesh mesh;
  double radius = 0;         ///< of the footprint; metres
  bool is_clutter = false;   ///< labelled class_clutter
  double shadow_height = 0;  ///< metres; 0 casts none
};

namespace detail {
/// Turns a profile of (radius, z) about the z axis; ring i gets materials[i].
inline void add_turned(MeshBuilder& builder, const std::vector<std::array<double, 2>>& profile,
                       std::size_t sectors, const std::vector<std::int32_t>& materials,
                       const Point& centre = {0, 0, 0}) {
  std::vector<std::int32_t> below, above;
  for (std::size_t ring = 0; ring < profile.size(); ++ring) {
    above.clear();
    for (std::size_t sector = 0; sector < sectors; ++sector) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(sector) / static_cast<double>(sectors);
      above.push_back(
          builder.vertex({centre[0] + profile[ring][0] * std::cos(angle),
                          centre[1] + profile[ring][0] * std::sin(angle), centre[2] + profile[ring][1]}));
    }
    for (std::size_t sector = 0; ring > 0 && sector < sectors; ++sector) {
      const std::size_t next = (sector + 1) % sectors;
      builder.quad({below[sector], below[next], above[next], above[sector]}, materials[ring - 1]);
    }
    below.swap(above);
  }
}

inline Colour muted_colour(Random& random) {
  const double grey = random.uniform(0.2, 0.85);
  return varied(random, {static_cast<float>(grey), static_cast<float>(grey), static_cast<float>(grey)}, 0.12);
}
}  // namespace detail

[[nodiscard]] inline Prop make_cone(Random& random) {
  MeshBuilder builder;
  const auto orange = builder.material("", varied(random, {0.92F, 0.34F, 0.08F}, 0.08));
  const auto white = builder.material("", {0.90F, 0.90F, 0.88F});
  const auto base = builder.material("", {0.12F, 0.12F, 0.12F});
  const double h = random.uniform(0.5, 1.0);
  const double r = 0.24 * h + 0.02;
  builder.box({-1.4 * r, -1.4 * r, 0}, {1.4 * r, 1.4 * r, 0.05}, random.chance(0.5) ? base : orange);
  detail::add_turned(
      builder,
      {{r, 0.05}, {0.72 * r, 0.33 * h}, {0.5 * r, 0.58 * h}, {0.3 * r, 0.78 * h}, {0.15 * r, h}, {0, h}}, 10,
      {orange, white, orange, random.chance(0.5) ? white : orange, orange});
  return {std::move(builder.mesh()), 1.6 * r, true, h};
}

[[nodiscard]] inline Prop make_crate(Random& random) {
  MeshBuilder builder;
  const Colour wood = random.chance(0.7) ? varied(random, {0.62F, 0.46F, 0.28F}, 0.1) : any_colour(random);
  const auto board = builder.material("", wood);
  const auto edge = builder.material("", scaled(wood, 0.65));
  const double a = random.uniform(0.3, 0.65), b = random.uniform(0.3, 0.65), h = random.uniform(0.4, 1.2);
  builder.box({-a, -b, 0}, {a, b, h}, board);
  for (const double z : {0.0, h - 0.08})
    builder.box({-a - 0.02, -b - 0.02, z}, {a + 0.02, b + 0.02, z + 0.08}, edge);
  for (const double x : {-a, a})
    for (const double y : {-b, b}) builder.box({x - 0.05, y - 0.05, 0}, {x + 0.05, y + 0.05, h}, edge);
  return {std::move(builder.mesh()), std::hypot(a, b), true, h};
}

[[nodiscard]] inline Prop make_bin(Random& random) {
  MeshBuilder builder;
  const Colour colour = random.chance(0.6) ? varied(random, {0.15F, 0.32F, 0.18F}, 0.12) : any_colour(random);
  const auto body = builder.material("", colour);
  const auto lid = builder.material("", scaled(colour, 0.6));
  const auto band = builder.material("", scaled(colour, 1.3));
  const double r = random.uniform(0.22, 0.38), h = random.uniform(0.8, 1.15);
  const std::vector<std::array<double, 2>> profile{
      {0.85 * r, 0},       {0.93 * r, 0.6 * h}, {0.95 * r, 0.7 * h}, {r, 0.88 * h},
      {1.1 * r, 0.88 * h}, {1.1 * r, 0.95 * h}, {0.6 * r, h},        {0, h}};
  detail::add_turned(builder, profile, 12, {body, band, body, lid, lid, lid, lid});
  return {std::move(builder.mesh()), r, true, h};
}

[[nodiscard]] inline Prop make_pole(Random& random) {
  MeshBuilder builder;
  const auto metal = builder.material("", detail::muted_colour(random));
  const double r = random.uniform(0.05, 0.12), h = random.uniform(3, 7);
  detail::add_turned(builder, {{1.6 * r, 0}, {1.6 * r, 0.5}, {r, 0.6}, {0.7 * r, h}}, 8,
                     {metal, metal, metal});
  if (random.chance(0.5)) builder.box({-0.1, -0.9, h - 0.1}, {0.1, 0.1, h}, metal);
  return {std::move(builder.mesh()), 1.6 * r, false, 0};
}

[[nodiscard]] inline Prop make_sign(Random& random) {
  MeshBuilder builder;
  const auto metal = builder.material("", {0.55F, 0.56F, 0.57F});
  const auto face = builder.material("", any_colour(random));
  const auto border = builder.material("", {0.92F, 0.92F, 0.90F});
  const double h = random.uniform(1.8, 2.6), s = random.uniform(0.25, 0.4);
  detail::add_turned(builder, {{0.04, 0}, {0.04, h + s}}, 6, {metal});
  builder.box({-0.03, -s, h - s}, {0.03, s, h + s}, border);
  builder.box({-0.035, -0.8 * s, h - 0.8 * s}, {0.035, 0.8 * s, h + 0.8 * s}, face);
  return {std::move(builder.mesh()), 0.3, false, 0};
}

[[nodiscard]] inline Prop make_tree(Random& random) {
  MeshBuilder builder;
  const auto bark = builder.material("", varied(random, {0.30F, 0.22F, 0.15F}, 0.06));
  const Colour green = varied(random, {0.20F, 0.36F, 0.12F}, 0.1);
  std::array<std::int32_t, 4> leaves{};
  for (std::size_t i = 0; i < leaves.size(); ++i)
    leaves[i] = builder.material("", varied(random, scaled(green, 0.75 + 0.16 * double(i)), 0.03));
  const double trunk = random.uniform(1.4, 2.6), r = random.uniform(1.0, 2.2),
               squeeze = random.uniform(0.9, 1.5);
  detail::add_turned(builder, {{0.2, 0}, {0.12, trunk + 0.4 * r}}, 7, {bark});
  const std::size_t first = builder.mesh().positions.size();
  constexpr std::size_t rings = 6;
  std::vector<std::array<double, 2>> profile;
  for (std::size_t ring = 0; ring <= rings; ++ring) {
    const double angle = std::numbers::pi * static_cast<double>(ring) / rings;
    profile.push_back({r * std::sin(angle), squeeze * r * (1 - std::cos(angle))});
  }
  const std::size_t first_face = builder.mesh().faces.size();
  detail::add_turned(builder, profile, 9, std::vector<std::int32_t>(rings, leaves[0]), {0, 0, trunk});
  for (std::size_t face = first_face; face < builder.mesh().faces.size(); ++face)
    builder.mesh().face_materials[face] = leaves[random.index(leaves.size())];
  for (std::size_t i = first; i < builder.mesh().positions.size(); ++i)
    for (double& coordinate : builder.mesh().positions[i]) coordinate += random.uniform(-0.14, 0.14) * r;
  return {std::move(builder.mesh()), 0.35, false, 0};
}

[[nodiscard]] inline Prop make_wall(Random& random) {
  MeshBuilder builder;
  const Colour colour = detail::muted_colour(random);
  const auto stone = builder.material("", colour);
  const auto cap = builder.material("", scaled(colour, 0.8));
  const double half = random.uniform(1, 4), h = random.uniform(0.5, 1.6);
  builder.box({-half, -0.12, 0}, {half, 0.12, h}, stone);
  builder.box({-half - 0.05, -0.17, h}, {half + 0.05, 0.17, h + 0.08}, cap);
  return {std::move(builder.mesh()), half, false, 0};
}

/// A panel of coloured blocks on two posts: colours and edges that belong to no car.
[[nodiscard]] inline Prop make_billboard(Random& random) {
  MeshBuilder builder;
  const auto metal = builder.material("", detail::muted_colour(random));
  const double half = random.uniform(0.8, 2.2), low = random.uniform(0.3, 1.6),
               h = low + random.uniform(0.9, 2.2);
  for (const double y : {-0.7 * half, 0.7 * half})
    builder.box({-0.05, y - 0.05, 0}, {0.05, y + 0.05, low}, metal);
  builder.box({-0.05, -half, low}, {0.05, half, h}, metal);
  const std::size_t columns = 1 + random.index(8), rows = 1 + random.index(4);
  for (std::size_t i = 0; i < columns; ++i)
    for (std::size_t j = 0; j < rows; ++j) {
      const double y0 = half * (2 * static_cast<double>(i) / double(columns) - 1),
                   y1 = y0 + 2 * half / double(columns);
      const double z0 = low + (h - low) * static_cast<double>(j) / double(rows),
                   z1 = z0 + (h - low) / double(rows);
      const auto front = builder.material("", any_colour(random));
      builder.quad({0.06, y0, z0}, {0.06, y1, z0}, {0.06, y1, z1}, {0.06, y0, z1}, front);
      builder.quad({-0.06, y1, z0}, {-0.06, y0, z0}, {-0.06, y0, z1}, {-0.06, y1, z1}, front);
    }
  return {std::move(builder.mesh()), half, false, 0};
}

/// Cones, crates and bins are the detector's class clutter and come up in half of the draws.
[[nodiscard]] inline Prop any_prop(Random& random, bool allow_large) {
  const double draw = random.uniform();
  if (draw < 0.2) return make_cone(random);
  if (draw < 0.35) return make_crate(random);
  if (draw < 0.5) return make_bin(random);
  if (draw < 0.62 || !allow_large) return make_pole(random);
  if (draw < 0.70) return make_sign(random);
  if (draw < 0.84) return make_tree(random);
  return draw < 0.91 ? make_wall(random) : make_billboard(random);
}
}  // namespace tapestry::scenes
