#pragma once
#include <concepts>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::io {
namespace detail {

/// The bytes of a .glb, compiled where a program includes implementation.hpp.
/// \param painted  whether each face is; empty: none
/// \param png      the texture of the painted ones
std::string glb_file(const std::string& path, const geometry::Mesh& mesh,
                     const std::vector<std::uint8_t>& painted, const std::string& png, double u_extent);

inline void require_faces(const char* operation, const geometry::Mesh& mesh) {
  if (mesh.faces.empty()) throw DomainError(std::string(operation) + ": the mesh has no faces");
}
}  // namespace detail

/// Writes a mesh with the colours of its materials as glTF 2.0 binary (.glb), which viewers open as it is.
/// A node turns z up into glTF's y up and the front from +x to +z.
/// \throws DomainError without faces; NumericError if a vertex is not finite; FileError (write, limit)
inline void write_glb(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_glb", mesh);
  write_file_atomically(path, detail::glb_file(path, mesh, {}, "", 1));
}

/// Writes a painted mesh as .glb with its texture inside; parameters and errors as write_painted_obj().
template <std::floating_point T>
void write_painted_glb(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture) {
  const auto& [mesh, painted, layout, space, pyramid] = body;
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_painted_glb", mesh);
  if (painted.size() != mesh.faces.size())
    throw ShapeError("write_painted_glb: painted has " + std::to_string(painted.size()) +
                     " entries, expected " + std::to_string(mesh.faces.size()));
  if (!(layout.u_extent > 0)) throw DomainError("write_painted_glb: u_extent must be positive");
  const std::string png = png_file(path, detail::with_gutters_filled(body, texture));
  write_file_atomically(path, detail::glb_file(path, mesh, body.painted, png, layout.u_extent));
}

}  // namespace tapestry::io
