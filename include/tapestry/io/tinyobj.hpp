#pragma once
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>

/// Meshes that a program has read with tinyobjloader already. Its types are recognised by their members, so
/// that this header neither includes nor links it:
///
///     tinyobj::ObjReader reader;
///     reader.ParseFromFile("car.obj");
///     const auto mesh = io::mesh_of(reader.GetAttrib(), reader.GetShapes(), reader.GetMaterials());
///
/// Other programs use read_obj() of obj_file.hpp, which states why.
namespace tapestry::io {
/// tinyobj::attrib_t.
template <class A>
concept TinyObjAttributes = requires(const A& a) {
  { a.vertices.size() } -> std::convertible_to<std::size_t>;
  { a.texcoords.size() } -> std::convertible_to<std::size_t>;
  { a.normals.size() } -> std::convertible_to<std::size_t>;
};

namespace detail {
/// Numbers that lie one behind the other, N to an element.
template <std::size_t N, class Numbers>
[[nodiscard]] std::vector<std::array<double, N>> grouped(const Numbers& numbers) {
  std::vector<std::array<double, N>> groups(numbers.size() / N);
  for (std::size_t i = 0; i < groups.size() * N; ++i) groups[i / N][i % N] = static_cast<double>(numbers[i]);
  return groups;
}

/// \throws Error (mismatch) for an index of no element
inline void require_corners(const std::string& face, const char* kind, const geometry::Corners& corners,
                            std::size_t count, std::int32_t least) {
  for (const std::int32_t corner : corners)
    if (corner < least || (corner >= 0 && static_cast<std::size_t>(corner) >= count))
      throw Error(ErrorKind::mismatch, {"mesh_of: ", face, " refers to ", kind, " ", corner, " of ", count});
}

/// A face whose corners do not all have such an attribute has none.
[[nodiscard]] inline geometry::Corners all_or_none(const geometry::Corners& corners) {
  return *std::min_element(corners.begin(), corners.end()) < 0 ? geometry::Corners{-1, -1, -1} : corners;
}

/// Appends the triangles of one shape, as the mesh's last group.
template <class Shape>
void append_shape(geometry::Mesh& mesh, const Shape& shape) {
  const auto& from = shape.mesh;
  const auto group = static_cast<std::int32_t>(mesh.groups.size());
  mesh.groups.push_back(shape.name);
  std::size_t first = 0;
  for (std::size_t f = 0; f < from.num_face_vertices.size(); ++f, first += 3) {
    const std::string face = "face " + std::to_string(f) + " of shape " + in_quotes(shape.name);
    if (from.num_face_vertices[f] != 3 || first + 3 > from.indices.size())
      throw Error(ErrorKind::mismatch, {"mesh_of: ", face, " has ", +from.num_face_vertices[f],
                                        " corners, expected 3: read with tinyobj's option triangulate"});
    geometry::Corners corners{}, uvs{}, normals{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = from.indices[first + k].vertex_index;
      uvs[k] = from.indices[first + k].texcoord_index;
      normals[k] = from.indices[first + k].normal_index;
    }
    require_corners(face, "position", corners, mesh.positions.size(), 0);
    require_corners(face, "texture coordinate", uvs, mesh.uvs.size(), -1);
    require_corners(face, "normal", normals, mesh.normals.size(), -1);
    const std::int32_t material = f < from.material_ids.size() ? from.material_ids[f] : -1;
    const bool is_known = material >= 0 && static_cast<std::size_t>(material) < mesh.materials.size();
    mesh.faces.push_back(corners);
    mesh.face_uvs.push_back(all_or_none(uvs));
    mesh.face_normals.push_back(all_or_none(normals));
    mesh.face_materials.push_back(is_known ? material : -1);
    mesh.face_groups.push_back(group);
  }
}
}  // namespace detail

/// The mesh that tinyobjloader has read: faces shape by shape, each shape a group; normals of unit length;
/// the diffuse colours and textures (map_Kd) of the materials. Numbers have its precision, single unless it
/// was compiled for double. Leaves out the white vertex colours that it gives a mesh without any.
///
/// \param attributes  tinyobj::attrib_t
/// \param shapes      tinyobj::shape_t each, of triangles
/// \param materials   tinyobj::material_t each
/// \param folder      of the OBJ, put before the names of textures
/// \throws Error (mismatch) naming shape and face: one that is no triangle, an index outside its list, no
/// faces
template <TinyObjAttributes Attributes, class Shape, class Material>
[[nodiscard]] geometry::Mesh mesh_of(const Attributes& attributes, const std::vector<Shape>& shapes,
                                     const std::vector<Material>& materials, const std::string& folder = "") {
  geometry::Mesh mesh;
  mesh.positions = detail::grouped<3>(attributes.vertices);
  mesh.uvs = detail::grouped<2>(attributes.texcoords);
  mesh.normals = detail::grouped<3>(attributes.normals);
  for (auto& normal : mesh.normals) normal = geometry::normalised(normal);
  for (const Material& from : materials) {
    geometry::Material material{from.name};
    for (std::size_t c = 0; c < 3; ++c) material.colour[c] = static_cast<float>(from.diffuse[c]);
    if (!from.diffuse_texname.empty()) material.texture = folder + from.diffuse_texname;
    mesh.materials.push_back(std::move(material));
  }
  const bool has_colours = attributes.colors.size() == attributes.vertices.size() &&
                           std::ranges::any_of(attributes.colors, [](auto channel) { return channel != 1; });
  for (std::size_t i = 0; has_colours && i < mesh.positions.size(); ++i) {
    std::array<float, 3>& colour = mesh.vertex_colours.emplace_back();
    for (std::size_t c = 0; c < 3; ++c)
      colour[c] = std::clamp(static_cast<float>(attributes.colors[3 * i + c]), 0.0F, 1.0F);
  }
  for (const Shape& shape : shapes) detail::append_shape(mesh, shape);
  if (mesh.faces.empty()) throw Error(ErrorKind::mismatch, "mesh_of: no faces");
  return mesh;
}
}  // namespace tapestry::io
