#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <utility>

#include "problem_list.hpp"

namespace tapestry::shell {

inline constexpr const char* up_help = "axis of the mesh that points up: x, y, z, -x, -y or -z";
inline constexpr const char* forward_help = "axis of the mesh that points to its front; the same choice";

inline void require_axes(const geometry::MeshAxes& axes, ProblemList& list) {
  for (const auto& [option, name] : {std::pair{"--up", axes.up}, std::pair{"--forward", axes.forward}})
    list.require_choice(option, name, {"x", "y", "z", "-x", "-y", "-z"});
  list.require(axes.up.empty() || axes.forward.empty() || axes.up.back() != axes.forward.back(),
               "--up " + axes.up + " and --forward " + axes.forward + " are not at a right angle");
}

/// Warning about a mesh that is higher than long after turned_upright(); empty otherwise.
inline std::string word_on_height(const geometry::Mesh& upright, const geometry::MeshAxes& axes) {
  if (!geometry::is_higher_than_long(upright)) return {};
  const auto bounds = geometry::bounds_of(upright.positions);
  const auto extent = [&](std::size_t axis) { return std::to_string(bounds.high[axis] - bounds.low[axis]); };
  return "the mesh is " + extent(2) + " high (along " + axes.up + ") and " + extent(0) + " long (along " +
         axes.forward + "), as no car is; --up and --forward set the axes that point up and to its front";
}

/// A car's mesh with z up and its front at +x.
/// \throws FileError (mismatch) if it is higher than long
inline geometry::Mesh upright_car(const std::string& mesh_path, geometry::Mesh mesh,
                                  const geometry::MeshAxes& axes) {
  mesh = geometry::turned_upright(std::move(mesh), axes);
  if (const std::string word = word_on_height(mesh, axes); !word.empty())
    throw FileError(ErrorKind::mismatch, {mesh_path, "", word});
  return mesh;
}

}  // namespace tapestry::shell
