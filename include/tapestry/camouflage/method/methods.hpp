#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

/// All methods, by the names that method_by_name() takes.
inline constexpr std::array method_names{"fca",      "planar_patch", "camou",    "upc",    "das",
                                         "das_full", "rauca",        "mesh_adv", "random", "solid"};

/// The method of that name for a car; the same seed draws the same.
/// \throws DomainError for a name that is not one of method_names, or unless the texture is an atlas if the
///         method needs one; as shape_parameter(); Error (mismatch) as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> method_by_name(const std::string& name, const raster::PaintedMesh& car,
                                       std::uint64_t seed);

}  // namespace tapestry::camouflage
