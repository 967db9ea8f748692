#pragma once
#include <tapestry/geometry/mesh.hpp>
#include "problem_list.hpp"

namespace tapestry::shell {
inline constexpr const char* up_help = "axis of the mesh that points up: {x}, {y}, {z}, {-x}, {-y} or {-z}";
inline constexpr const char* forward_help =
    "axis of the mesh that points to its front: {x}, {y}, {z}, {-x}, {-y} or {-z}";

inline constexpr const char* object_help =
    "what the mesh shows: {car}, which must stand on its wheels and be longest to its front, or {any}";

inline void require_right_angle(const geometry::MeshAxes& axes, ProblemList& list) {
  list.require(axes.up.empty() || axes.forward.empty() || axes.up.back() != axes.forward.back(),
               "--up " + axes.up + " and --forward " + axes.forward + " are not at a right angle");
}

inline void require_axes(const geometry::MeshAxes& axes, const std::string& object, ProblemList& list) {
  list.require_choice("--object", object, words_in(object_help));
  list.require_choice("--up", axes.up, words_in(up_help));
  list.require_choice("--forward", axes.forward, words_in(forward_help));
  require_right_angle(axes, list);
}

/// A car's mesh with z up and its front at +x; any other object's without a check.
/// \param object  car or any
/// \throws FileError (mismatch) if a car does not stand on its wheels, with the axes by which it would
inline geometry::Mesh upright_object(const std::string& mesh_path, geometry::Mesh mesh,
                                     const geometry::MeshAxes& axes, const std::string& object) {
  const auto better =
      object == "car" ? geometry::better_car_axes(mesh, axes) : std::optional<geometry::MeshAxes>{};
  mesh = geometry::turned_upright(std::move(mesh), axes);
  if (!better) return mesh;
  const auto bounds = geometry::bounds_of(mesh.positions);
  const auto extent = [&](std::size_t axis) { return std::to_string(bounds.high[axis] - bounds.low[axis]); };
  const std::string front =
      better->forward == axes.forward ? "" : " or, if that is its tail, --forward -" + better->forward;
  throw file_mismatch({mesh_path, "",
                       "the mesh is " + extent(2) + " high (along " + axes.up + ") and " + extent(0) +
                           " long (along " + axes.forward +
                           "), and does not stand on its wheels as a car does; --up " + better->up +
                           " --forward " + better->forward + " would right it" + front +
                           "; --object any is for what is no car"});
}
}  // namespace tapestry::shell
