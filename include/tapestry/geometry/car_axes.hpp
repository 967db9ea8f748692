#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::geometry {

/// Share of a mesh's surface near one side of its box that lies at all four corners of that side, where a car
/// has its wheels:
///
///   4 · min over corners of area(corner) / area(slab)
///
/// The slab is the 6 % of the box next to the side; a corner begins .15 of the long edge `along` and .2 of
/// the other edge off the middle. About .9 under a car, .42 for a flat face, near 0 for roof and doors. 0
/// without surface in the slab. The areas are those of 20,000 points, spread evenly over the surface.
///
/// \param down   towards the side: an axis of the mesh
/// \param along  index of the axis of the side's long edge, not that of `down`
/// \throws DomainError for a name of no axis
[[nodiscard]] double wheel_share(const Mesh& mesh, const std::string& down, std::size_t along);

/// Axes by which a car's mesh is longest to its front and stands on its wheels; none if it does so by `axes`.
///
/// The wheels are at the side, of those that are as long as the car, with the largest wheel_share(), if that
/// is at least .6 and twice that of the side now below. Without such a side, only the extents are judged.
/// Front and tail are not told apart: a front that is found has the positive sign. A flat mesh is no car.
///
/// \param mesh  as in its file, in which `axes` point up and to its front
/// \throws DomainError as world_from_mesh()
[[nodiscard]] std::optional<MeshAxes> better_car_axes(const Mesh& mesh, const MeshAxes& axes);

}  // namespace tapestry::geometry
