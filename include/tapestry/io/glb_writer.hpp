#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/atomic_file.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/json_reader.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::io {
namespace detail {

/// A glTF under construction: its lists of JSON objects and its one buffer.
class GlbBuilder {
 public:
  GlbBuilder(const geometry::Mesh& mesh, double u_extent) : mesh_(mesh), u_extent_(u_extent) {}

  /// Adds a material; texture: index of a texture, or −1.
  std::size_t add_material(std::string_view name, const std::array<float, 3>& colour, int texture) {
    std::string text = "{\"name\":" + json_string(name) + ",\"doubleSided\":true,\"pbrMetallicRoughness\":{";
    text += "\"metallicFactor\":0,\"roughnessFactor\":1,\"baseColorFactor\":[";
    for (const float channel : colour) {
      append_number(text, linear(channel));
      text += ',';
    }
    text += "1]";
    if (texture >= 0) text += ",\"baseColorTexture\":{\"index\":" + std::to_string(texture) + "}";
    return append(materials_, text + "}}");
  }

  void add_png(const std::string& file) {
    image_view_ = static_cast<int>(add_view(file.data(), file.size(), 0));
  }

  /// Adds the faces for which `is_in_part`, as one primitive; none if there are none.
  template <class Predicate>
  void add_primitive(std::size_t material, bool has_texture, Predicate is_in_part) {
    Vertices vertices;
    std::vector<std::uint32_t> indices;
    bool has_normals = true;
    for (std::size_t face = 0; face < mesh_.faces.size(); ++face) {
      if (!is_in_part(face)) continue;
      for (std::size_t k = 0; k < 3; ++k) indices.push_back(index_of(face, k, vertices));
      for (std::size_t k = 0; k < 3; ++k)
        has_normals = has_normals && index_in(mesh_.face_normals, face, k) >= 0;
    }
    if (indices.empty()) return;
    std::string text = "{\"attributes\":{\"POSITION\":" + std::to_string(add_positions(vertices));
    if (has_normals) text += ",\"NORMAL\":" + std::to_string(add_normals(vertices));
    if (has_texture) text += ",\"TEXCOORD_0\":" + std::to_string(add_uvs(vertices));
    const std::size_t view = add_view(indices.data(), 4 * indices.size(), 34963);
    text += "},\"indices\":" + std::to_string(add_accessor(view, 5125, indices.size(), "SCALAR", ""));
    append(primitives_, text + ",\"material\":" + std::to_string(material) + "}");
  }

  /// The whole file.
  [[nodiscard]] std::string file(const std::string& path) const {
    std::string json =
        "{\"asset\":{\"version\":\"2.0\",\"generator\":\"tapestry\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}]"
        ",";
    // Turns x forward, z up into glTF's z forward, y up: by −120° about (1, 1, 1).
    json += "\"nodes\":[{\"mesh\":0,\"rotation\":[-0.5,-0.5,-0.5,0.5]}],\"meshes\":[{\"primitives\":" +
            list(primitives_) + "}],";
    json += "\"materials\":" + list(materials_) + ",\"accessors\":" + list(accessors_) +
            ",\"bufferViews\":" + list(views_);
    if (image_view_ >= 0) {
      json += ",\"images\":[{\"mimeType\":\"image/png\",\"bufferView\":" + std::to_string(image_view_) + "}]";
      json += ",\"samplers\":[{\"magFilter\":9729,\"minFilter\":9987,\"wrapS\":10497,\"wrapT\":10497}]";
      json += ",\"textures\":[{\"sampler\":0,\"source\":0}]";
    }
    json += ",\"buffers\":[{\"byteLength\":" + std::to_string(buffer_.size()) + "}]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t length = 28 + std::uint64_t{json.size()} + buffer_.size();
    if (length > std::numeric_limits<std::uint32_t>::max())
      throw FileError(ErrorKind::limit, {.path = path, .what = "mesh is too large for a .glb of 4 GiB"});
    std::string file = "glTF";
    append_word(file, 2);
    append_word(file, static_cast<std::uint32_t>(length));
    append_word(file, static_cast<std::uint32_t>(json.size()));
    file += "JSON" + json;
    append_word(file, static_cast<std::uint32_t>(buffer_.size()));
    file += std::string("BIN\0", 4) + buffer_;
    return file;
  }

 private:
  using Corner = std::array<std::int32_t, 3>;  // position, uv, normal; −1 for none

  /// The corners of a primitive, each combination once.
  struct Vertices {
    std::vector<Corner> corners;
    std::map<Corner, std::uint32_t> known;
  };

  [[nodiscard]] static std::int32_t index_in(const std::vector<geometry::Corners>& list, std::size_t face,
                                             std::size_t k) {
    return face < list.size() ? list[face][k] : -1;
  }

  [[nodiscard]] std::uint32_t index_of(std::size_t face, std::size_t k, Vertices& vertices) const {
    const Corner corner{mesh_.faces[face][k], index_in(mesh_.face_uvs, face, k),
                        index_in(mesh_.face_normals, face, k)};
    const auto [entry, is_new] =
        vertices.known.emplace(corner, static_cast<std::uint32_t>(vertices.corners.size()));
    if (is_new) vertices.corners.push_back(corner);
    return entry->second;
  }

  [[nodiscard]] static std::string list(const std::vector<std::string>& items) {
    std::string text = "[";
    for (const std::string& item : items) text += (text.size() > 1 ? "," : "") + item;
    return text + "]";
  }

  static std::size_t append(std::vector<std::string>& items, std::string text) {
    items.push_back(std::move(text));
    return items.size() - 1;
  }

  static void append_word(std::string& bytes, std::uint32_t value) {
    for (unsigned shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xFFU);
  }

  /// Factors of glTF are linear; our colours are as a display shows them (sRGB).
  [[nodiscard]] static float linear(float value) {
    return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
  }

  /// Appends bytes to the buffer, which stays a multiple of four long; target 0: none.
  std::size_t add_view(const void* bytes, std::size_t size, int target) {
    static_assert(std::endian::native == std::endian::little);
    std::string text = "{\"buffer\":0,\"byteOffset\":" + std::to_string(buffer_.size()) +
                       ",\"byteLength\":" + std::to_string(size);
    if (target != 0) text += ",\"target\":" + std::to_string(target);
    buffer_.append(static_cast<const char*>(bytes), size);
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    return append(views_, text + "}");
  }

  std::size_t add_accessor(std::size_t view, int component, std::size_t count, const char* type,
                           const std::string& bounds) {
    return append(accessors_, "{\"bufferView\":" + std::to_string(view) + ",\"componentType\":" +
                                  std::to_string(component) + ",\"count\":" + std::to_string(count) +
                                  ",\"type\":\"" + type + "\"" + bounds + "}");
  }

  std::size_t add_positions(const Vertices& vertices) {
    std::vector<float> values;
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    for (const Corner& corner : vertices.corners) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<float>(mesh_.positions[static_cast<std::size_t>(corner[0])][axis]);
        low[axis] = std::min(low[axis], value);
        high[axis] = std::max(high[axis], value);
        values.push_back(value);
      }
    }
    std::string bounds;
    for (const auto& [name, corner] : {std::pair{",\"min\":[", low}, std::pair{",\"max\":[", high}}) {
      bounds += name;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (axis > 0) bounds += ',';
        append_number(bounds, corner[axis]);
      }
      bounds += ']';
    }
    return add_floats(values, 3, "VEC3", bounds);
  }

  std::size_t add_normals(const Vertices& vertices) {
    std::vector<float> values;
    for (const Corner& corner : vertices.corners) {
      const auto& normal = mesh_.normals[static_cast<std::size_t>(corner[2])];
      const double size = std::hypot(normal[0], normal[1], normal[2]);
      for (std::size_t axis = 0; axis < 3; ++axis)
        values.push_back(size > 0 ? static_cast<float>(normal[axis] / size) : axis == 2 ? 1.0F : 0.0F);
    }
    return add_floats(values, 3, "VEC3", "");
  }

  /// v grows downwards in glTF.
  std::size_t add_uvs(const Vertices& vertices) {
    std::vector<float> values;
    for (const Corner& corner : vertices.corners) {
      const auto uv =
          corner[1] < 0 ? std::array<double, 2>{0, 0} : mesh_.uvs[static_cast<std::size_t>(corner[1])];
      values.push_back(static_cast<float>(uv[0] / u_extent_));
      values.push_back(static_cast<float>(1 - uv[1]));
    }
    return add_floats(values, 2, "VEC2", "");
  }

  std::size_t add_floats(const std::vector<float>& values, std::size_t width, const char* type,
                         const std::string& bounds) {
    return add_accessor(add_view(values.data(), 4 * values.size(), 34962), 5126, values.size() / width, type,
                        bounds);
  }

  const geometry::Mesh& mesh_;
  double u_extent_;
  std::vector<std::string> primitives_, materials_, accessors_, views_;
  std::string buffer_;
  int image_view_ = -1;
};

/// Unpainted faces, one primitive a material.
inline void add_plain_primitives(GlbBuilder& builder, const geometry::Mesh& mesh,
                                 const std::vector<std::uint8_t>& painted) {
  const auto material_of = [&](std::size_t face) {
    const std::int32_t index = face < mesh.face_materials.size() ? mesh.face_materials[face] : -1;
    return index < 0 ? mesh.materials.size() : static_cast<std::size_t>(index);
  };
  std::vector<bool> is_used(mesh.materials.size() + 1, false);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    if (painted.empty() || painted[face] == 0) is_used[material_of(face)] = true;
  for (std::size_t material = 0; material < is_used.size(); ++material) {
    if (!is_used[material]) continue;
    const geometry::Material none{"none"};
    const auto& entry = material < mesh.materials.size() ? mesh.materials[material] : none;
    builder.add_primitive(builder.add_material(entry.name, entry.colour, -1), false, [&](std::size_t face) {
      return (painted.empty() || painted[face] == 0) && material_of(face) == material;
    });
  }
}

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
  detail::GlbBuilder builder(mesh, 1);
  detail::add_plain_primitives(builder, mesh, {});
  write_file_atomically(path, builder.file(path));
}

/// Writes a painted mesh as .glb with its texture inside; parameters and errors as write_painted_obj().
template <std::floating_point T>
void write_painted_glb(const std::string& path, const raster::PaintedMesh& body, const Array<T, 3>& texture) {
  const auto& [mesh, painted, layout] = body;
  detail::require_writable_mesh(mesh);
  detail::require_faces("write_painted_glb", mesh);
  if (painted.size() != mesh.faces.size())
    throw ShapeError("write_painted_glb: painted has " + std::to_string(painted.size()) +
                     " entries, expected " + std::to_string(mesh.faces.size()));
  if (!(layout.u_extent > 0)) throw DomainError("write_painted_glb: u_extent must be positive");
  detail::GlbBuilder builder(mesh, layout.u_extent);
  builder.add_png(png_file(path, texture));
  builder.add_primitive(builder.add_material(detail::paint_name(mesh), {1, 1, 1}, 0), true,
                        [&](std::size_t face) { return body.painted[face] != 0; });
  detail::add_plain_primitives(builder, mesh, painted);
  write_file_atomically(path, builder.file(path));
}

}  // namespace tapestry::io
