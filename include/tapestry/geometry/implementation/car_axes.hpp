#pragma once
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::geometry {
namespace detail {
inline std::size_t axis_index(const std::string& name) {
  const Vector3 axis = axis_by_name(name);
  return static_cast<std::size_t>(std::ranges::find_if(axis, [](double x) { return x != 0; }) - axis.begin());
}

inline std::string axis_name(std::size_t index) { return {static_cast<char>('x' + index)}; }

/// Calls visit(point) for `count` points, spread evenly over the surface: each face gets its share in the
/// order of faces, and within faces points follow the sequence of Roberts, The unreasonable effectiveness of
/// quasirandom sequences (2018), folded into a triangle.
template <class Visit>
void for_each_surface_point(const Mesh& mesh, std::size_t count, Visit visit) {
  const auto corner = [&](std::size_t face, std::size_t k) {
    return mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])];
  };
  const auto area = [&](std::size_t face) {
    const Vector3 a = corner(face, 0);
    return length(cross(subtract(corner(face, 1), a), subtract(corner(face, 2), a)));
  };
  double whole = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) whole += area(face);
  double passed = 0;
  std::size_t point = 0;
  for (std::size_t face = 0; face < mesh.faces.size() && whole > 0; ++face) {
    passed += area(face);
    for (; point < count && (static_cast<double>(point) + 0.5) * whole < passed * static_cast<double>(count);
         ++point) {
      const auto part = [&](double step) {
        const double at = (static_cast<double>(point) + 1) * step;
        return at - std::floor(at);
      };
      double u = part(0.7548776662466927), v = part(0.5698402909980532);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      visit(
          add(add(scale(corner(face, 0), 1 - u - v), scale(corner(face, 1), u)), scale(corner(face, 2), v)));
    }
  }
}

/// The box around the corners of faces; other positions may lie anywhere.
inline Bounds bounds_of_faces(const Mesh& mesh) {
  std::vector<Vector3> corners;
  for (const Corners& face : mesh.faces)
    for (const std::int32_t at : face) corners.push_back(mesh.positions[static_cast<std::size_t>(at)]);
  return bounds_of(corners);
}
}  // namespace detail

double wheel_share(const Mesh& mesh, const std::string& down, std::size_t along) {
  const Bounds bounds = detail::bounds_of_faces(mesh);
  const Vector3 extent = subtract(bounds.high, bounds.low), side = axis_by_name(down);
  const std::size_t vertical = detail::axis_index(down), across = 3 - vertical - along;
  if (!(std::ranges::min(extent) > 0)) return 0;
  std::array<std::size_t, 4> corners{};
  std::size_t slab = 0;
  detail::for_each_surface_point(mesh, 20000, [&](const Vector3& point) {
    Vector3 share = subtract(point, bounds.middle());
    for (std::size_t axis = 0; axis < 3; ++axis) share[axis] /= extent[axis];
    if (share[vertical] * side[vertical] < 0.5 - 0.06) return;
    ++slab;
    if (std::abs(share[along]) > 0.15 && std::abs(share[across]) > 0.2)
      ++corners[(share[along] > 0 ? 2U : 0U) + (share[across] > 0 ? 1U : 0U)];
  });
  return slab == 0 ? 0 : 4 * static_cast<double>(std::ranges::min(corners)) / static_cast<double>(slab);
}

std::optional<MeshAxes> better_car_axes(const Mesh& mesh, const MeshAxes& axes) {
  (void)world_from_mesh(axes);
  const Bounds bounds = detail::bounds_of_faces(mesh);
  const Vector3 extent = subtract(bounds.high, bounds.low);
  if (!(std::ranges::min(extent) > 0)) return {};
  std::size_t along = detail::axis_index(axes.forward);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (extent[axis] > extent[along]) along = axis;
  MeshAxes better = axes;
  if (along != detail::axis_index(axes.forward)) better.forward = detail::axis_name(along);
  const bool is_up_free = detail::axis_index(axes.up) != along;
  if (!is_up_free) better.up = detail::axis_name(along == 1 ? 2 : 1);
  const auto share_on = [&](const std::string& up) {
    const std::string down = up.starts_with('-') ? up.substr(1) : std::string(1, '-').append(up);
    return wheel_share(mesh, down, along);
  };
  double largest = std::max(is_up_free ? 2 * share_on(axes.up) : 0, 0.6);
  for (const std::string up : {"z", "y", "x", "-z", "-y", "-x"}) {
    if (detail::axis_index(up) == along || up == axes.up) continue;
    const double share = share_on(up);
    if (share < largest) continue;
    largest = share;
    better.up = up;
  }
  if (better.up == axes.up && better.forward == axes.forward) return {};
  return better;
}
}  // namespace tapestry::geometry
