#pragma once
#include <concepts>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/glb_writer.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::io::detail {

inline void require_faces(const char* operation, const geometry::Mesh& mesh) {
  if (mesh.faces.empty()) throw DomainError(std::string(operation) + ": the mesh has no faces");
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

void write_glb(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_glb", mesh);
  write_file_atomically(path, detail::glb_file(path, mesh, {}, "", 1));
}

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

template decltype(write_painted_glb<float>) write_painted_glb<float>;
template decltype(write_painted_glb<double>) write_painted_glb<double>;

}  // namespace tapestry::io
