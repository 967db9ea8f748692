#pragma once
#include <concepts>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::io {
namespace detail {

/// The bytes of a .glb, compiled where a program includes implementation.hpp.
/// \param painted  whether each face is; empty: none
/// \param png      the texture of the painted ones
std::string glb_file(const std::string& path, const geometry::Mesh& mesh,
                     const std::vector<std::uint8_t>& painted, const std::string& png, double u_extent);

}  // namespace detail

/// Writes a mesh with the colours of its materials as glTF 2.0 binary (.glb), which viewers open as it is.
/// A node turns z up into glTF's y up and the front from +x to +z.
/// \throws DomainError without faces; NumericError if a vertex is not finite; FileError (write, limit)
void write_glb(const std::string& path, const geometry::Mesh& mesh);

/// Writes a painted mesh as .glb with its texture inside; parameters and errors as write_painted_obj().
template <std::floating_point T>
void write_painted_glb(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture);

}  // namespace tapestry::io
