#pragma once
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::io {

std::string unused_material_name(const geometry::Mesh& mesh, std::string name) {
  for (std::size_t i = 0; i < mesh.materials.size(); ++i)
    for (const auto& material : mesh.materials)
      if (material.name == name) name += "_";
  return name;
}

}  // namespace tapestry::io

namespace tapestry::io::detail {

void require_writable_mesh(const geometry::Mesh& mesh) {
  for (const auto& position : mesh.positions)
    for (const double value : position)
      if (!std::isfinite(value)) throw NumericError("write_obj: a vertex is not finite");
}

raster::PaintedMesh writable_body(const char* operation, const raster::PaintedMesh& body,
                                  const std::array<std::size_t, 3>& texture) {
  const std::string name = operation;
  if (body.painted.size() != body.mesh.faces.size())
    throw ShapeError(
        {name, ": painted has ", body.painted.size(), " entries, expected ", body.mesh.faces.size()});
  if (!(body.layout.u_extent > 0)) throw DomainError({name, ": u_extent must be positive"});
  auto written = raster::with_atlas(body);
  const std::array<std::size_t, 3> charts{written.layout.height, written.layout.width, 3};
  if (body.layout.kind != raster::TextureKind::atlas && texture != charts)
    throw ShapeError({name, ": texture is ", texture, ", expected ", charts, ", the charts of the faces"});
  return written;
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

void write_obj(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_names(path, mesh);
  detail::require_writable_mesh(mesh);
  const std::filesystem::path stem = std::filesystem::path(path).replace_extension();
  write_file_atomically(stem.string() + ".mtl", detail::mtl_text(mesh, ""));
  write_file_atomically(path, detail::obj_text(mesh, {}, stem.filename().string() + ".mtl", 1));
}

void write_glb(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_glb", mesh);
  write_file_atomically(path, detail::glb_file(path, mesh, {}, "", 1));
}

}  // namespace tapestry::io
