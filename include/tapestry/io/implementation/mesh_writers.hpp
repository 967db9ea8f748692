#pragma once
#include <charconv>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::io {
namespace detail {
template <class Number>
void append_number(std::string& text, Number value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  text.append(buffer.data(), end);
}

inline void append_vertex(std::string& text, const geometry::Mesh& mesh, std::size_t vertex) {
  append_record(text, "v", mesh.positions[vertex]);
  if (mesh.vertex_colours.empty()) return;
  text.pop_back();
  append_numbers(text, mesh.vertex_colours.at(vertex));
}

inline void append_face(std::string& text, const geometry::Mesh& mesh, std::size_t face) {
  text += 'f';
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const auto index = [&](const std::vector<geometry::Corners>& list) {
      return face < list.size() ? list[face][corner] + 1 : 0;
    };
    const std::int32_t uv = index(mesh.face_uvs);
    const std::int32_t normal = index(mesh.face_normals);
    text += ' ';
    append_number(text, mesh.faces[face][corner] + 1);
    if (uv > 0 || normal > 0) text += '/';
    if (uv > 0) append_number(text, uv);
    if (normal > 0) text += '/';
    if (normal > 0) append_number(text, normal);
  }
  text += '\n';
}

/// The records of the mesh; `painted` may be empty.
inline std::string obj_text(const geometry::Mesh& mesh, const std::vector<std::uint8_t>& painted,
                            const std::string& library, double u_extent) {
  std::string text = "mtllib " + library + "\n";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) append_vertex(text, mesh, i);
  for (const auto& uv : mesh.uvs) append_record(text, "vt", std::array{uv[0] / u_extent, uv[1]});
  for (const auto& normal : mesh.normals) append_record(text, "vn", normal);
  const std::string paint = paint_name(mesh);
  std::optional<std::string_view> material_now;  // empty until the first; a material may be nameless
  std::string_view group_now;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const auto label = [face](const std::vector<std::int32_t>& labels) {
      return face < labels.size() ? labels[face] : -1;
    };
    const std::int32_t group = label(mesh.face_groups);
    const std::int32_t material = label(mesh.face_materials);
    if (group >= 0 && mesh.groups[static_cast<std::size_t>(group)] != group_now) {
      group_now = mesh.groups[static_cast<std::size_t>(group)];
      text.append("g ").append(group_now).append("\n");
    }
    const std::string_view name = !painted.empty() && painted[face] != 0 ? std::string_view(paint)
                                  : material < 0                         ? std::string_view("none")
                                                 : mesh.materials[static_cast<std::size_t>(material)].name;
    if (name != material_now) text.append("usemtl ").append(name).append("\n");
    material_now = name;
    append_face(text, mesh, face);
  }
  return text;
}

/// \param texture   file of the paint; empty for none
/// \param pictures  files of the materials' pictures, one a material, empty for none
inline std::string mtl_text(const geometry::Mesh& mesh, const std::string& texture,
                            const std::vector<std::string>& pictures) {
  constexpr std::array<float, 3> white{1, 1, 1};  // many viewers multiply a picture by Kd
  std::string text;
  const auto add = [&](const std::string& name, const std::array<float, 3>& colour, const std::string& file) {
    append_numbers(text += "newmtl " + name + "\nKd", colour);
    if (!file.empty()) text += "map_Kd " + file + "\n";
  };
  bool has_none = false;
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    const auto& [name, colour, source] = mesh.materials[i];
    add(name, pictures[i].empty() ? colour : white, pictures[i]);
    has_none = has_none || mesh.materials[i].name == "none";
  }
  if (!has_none) add("none", geometry::Material{}.colour, "");
  if (!texture.empty()) add(paint_name(mesh), white, texture);
  return text;
}

/// Refuses line ends in names, because they would begin a record of their own.
inline void require_writable_names(const std::string& path, const geometry::Mesh& mesh) {
  const auto require = [&](const std::string& name) {
    const bool is_clean = std::ranges::none_of(
        name, [](char letter) { return static_cast<unsigned char>(letter) < 0x20 || letter == '\x7f'; });
    if (!is_clean)
      throw FileError(ErrorKind::usage, {path, "", "control character in a name that the OBJ would hold",
                                         "none", in_quotes(name)});
  };
  require(path_of(path).filename().string());
  for (const auto& material : mesh.materials) require(material.name);
  for (const auto& group : mesh.groups) require(group);
}

template <std::floating_point T>
Array<T, 3> with_gutters_filled(raster::PaintedMesh body, const Array<T, 3>& texture) {
  if (texture.shape(2) != 3) return texture;
  body.layout.height = texture.shape(0);
  body.layout.width = texture.shape(1);
  body.painted.resize(body.mesh.faces.size());
  for (std::size_t face = 0; face < body.painted.size(); ++face)  // faces without uv use no texel
    if (face >= body.mesh.face_uvs.size() || std::ranges::min(body.mesh.face_uvs[face]) < 0)
      body.painted[face] = 0;
  Array<T, 2> texels(Extents<2>{texture.size() / 3, 3});
  std::copy_n(texture.data(), texture.size(), texels.data());
  texels = raster::with_unused_filled(body.layout, raster::used_texels_or_all<T>(body), texels);
  Array<T, 3> filled = texture;
  std::copy_n(texels.data(), texels.size(), filled.data());
  return filled;
}

inline void require_faces(const char* operation, const geometry::Mesh& mesh) {
  if (mesh.faces.empty()) throw DomainError({operation, ": the mesh has no faces"});
}
}  // namespace detail

template <std::floating_point T>
void write_painted_obj(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture) {
  detail::require_writable_names(path, body.mesh);
  detail::require_writable_mesh(body.mesh);
  const auto written = detail::writable_body("write_painted_obj", body, texture.shape());
  const std::filesystem::path stem = path_of(path).replace_extension();
  const std::string name = stem.filename().string();
  write_image(stem.string() + ".png", detail::with_gutters_filled(written, texture));
  const auto pictures = detail::write_pictures(stem, written.mesh, written.painted);
  write_file_atomically(stem.string() + ".mtl", detail::mtl_text(written.mesh, name + ".png", pictures));
  write_file_atomically(
      path, detail::obj_text(written.mesh, written.painted, name + ".mtl", written.layout.u_extent));
}

template <std::floating_point T>
void write_painted_glb(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture) {
  detail::require_writable_mesh(body.mesh);
  detail::require_faces("write_painted_glb", body.mesh);
  const auto written = detail::writable_body("write_painted_glb", body, texture.shape());
  const std::string png = png_file(path, detail::with_gutters_filled(written, texture));
  const auto pictures = detail::picture_files(path, written.mesh, written.painted);
  write_file_atomically(
      path, detail::glb_file(path, written.mesh, written.painted, {png, written.layout.u_extent, pictures}));
}
}  // namespace tapestry::io
