#pragma once
#include <map>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::io {
namespace detail {
/// The picture of a material that faces show beside a paint. None if no face shows it, or it cannot be read:
/// the material's colour then replaces it, as when the mesh is drawn.
inline std::optional<Array<std::uint8_t, 3>> shown_picture(const geometry::Mesh& mesh,
                                                           const std::vector<std::uint8_t>& painted,
                                                           std::size_t material) {
  const auto shows = [&](std::size_t face) {
    return (painted.empty() || painted[face] == 0) &&
           mesh.face_materials[face] == static_cast<std::int32_t>(material) &&
           std::ranges::min(mesh.face_uvs[face]) >= 0;
  };
  std::size_t face = 0;
  const std::size_t faces = std::min(mesh.face_materials.size(), mesh.face_uvs.size());
  while (face < faces && !shows(face)) ++face;
  if (mesh.materials[material].texture.empty() || face == faces) return std::nullopt;
  try {
    std::vector<std::string> told_before;
    return read_texture(mesh.materials[material].texture, &told_before);
  } catch (const FileError&) {
    return std::nullopt;
  }
}

std::vector<std::string> write_pictures(const std::filesystem::path& stem, const geometry::Mesh& mesh,
                                        const std::vector<std::uint8_t>& painted) {
  std::vector<std::string> names(mesh.materials.size());
  std::map<std::string, std::string> written;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& source = mesh.materials[i].texture;
    const auto picture = shown_picture(mesh, painted, i);
    if (!picture) continue;
    std::string& name = written[source];
    if (name.empty()) {
      const std::string file = stem.string() + "-" + std::to_string(i + 1) + ".png";
      if (file != source) write_image(file, *picture);
      name = path_of(file).filename().string();
    }
    names[i] = name;
  }
  return names;
}

std::vector<std::string> picture_files(const std::string& path, const geometry::Mesh& mesh,
                                       const std::vector<std::uint8_t>& painted) {
  std::vector<std::string> files(mesh.materials.size());
  for (std::size_t i = 0; i < files.size(); ++i)
    if (const auto picture = shown_picture(mesh, painted, i)) files[i] = png_file(path, *picture);
  return files;
}

/// Gives unpainted faces uvs of their own beside the paint's, which are divided by its extent: pictures of
/// the mesh have the extent 1.
inline void separate_uvs(raster::PaintedMesh& body) {
  auto& mesh = body.mesh;
  const double extent = std::exchange(body.layout.u_extent, 1);
  const auto own = mesh.uvs;
  for (auto& uv : mesh.uvs) uv[0] /= extent;
  mesh.uvs.insert(mesh.uvs.end(), own.begin(), own.end());
  for (std::size_t face = 0; face < mesh.face_uvs.size(); ++face)
    for (std::int32_t& corner : mesh.face_uvs[face])
      if (body.painted[face] == 0 && corner >= 0) corner += static_cast<std::int32_t>(own.size());
}

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
  if (!body.layout.traits().is_picture && texture != charts)
    throw ShapeError({name, ": texture is ", texture, ", expected ", charts, ", the charts of the faces"});
  const auto has_picture = [](const auto& material) { return !material.texture.empty(); };
  if (written.layout.u_extent != 1 && std::ranges::any_of(written.mesh.materials, has_picture))
    separate_uvs(written);
  return written;
}
}  // namespace detail

std::string unused_material_name(const geometry::Mesh& mesh, std::string name) {
  for (std::size_t i = 0; i < mesh.materials.size(); ++i)
    for (const auto& material : mesh.materials)
      if (material.name == name) name += "_";
  return name;
}

void write_obj(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_names(path, mesh);
  detail::require_writable_mesh(mesh);
  const std::filesystem::path stem = path_of(path).replace_extension();
  write_file_atomically(stem.string() + ".mtl",
                        detail::mtl_text(mesh, "", detail::write_pictures(stem, mesh, {})));
  write_file_atomically(path, detail::obj_text(mesh, {}, stem.filename().string() + ".mtl", 1));
}

void write_glb(const std::string& path, const geometry::Mesh& mesh) {
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_glb", mesh);
  write_file_atomically(path,
                        detail::glb_file(path, mesh, {}, {"", 1, detail::picture_files(path, mesh, {})}));
}
}  // namespace tapestry::io
