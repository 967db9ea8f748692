#pragma once
#include <tapestry/core/finite.hpp>
#include <tapestry/io/json.hpp>
#include <tapestry/io/mesh_writers.hpp>

/// \file
/// The compiled part of the GLB writer.

namespace tapestry::io::detail {
/// A glTF file under construction: its JSON and its single buffer.
class GlbBuilder {
 public:
  GlbBuilder(const geometry::Mesh& mesh, double u_extent) : mesh_(mesh), u_extent_(u_extent) {}

  /// Adds a material; texture: index of a texture, or −1.
  std::size_t add_material(std::string_view name, const std::array<float, 3>& colour, int texture) {
    std::array<float, 3> linear = colour;  // glTF's factors are linear light
    for (float& channel : linear) channel = image::linearised(channel);
    nlohmann::json surface{{"metallicFactor", 0},
                           {"roughnessFactor", 1},
                           {"baseColorFactor", {linear[0], linear[1], linear[2], 1}}};
    if (texture >= 0) surface["baseColorTexture"] = {{"index", texture}};
    return append(json_["materials"],
                  {{"name", name}, {"doubleSided", true}, {"pbrMetallicRoughness", std::move(surface)}});
  }

  /// Adds a picture; returns the index of its texture, −1 without a file.
  int add_png(const std::string& file) {
    if (file.empty()) return -1;
    if (!json_.contains("samplers"))
      json_["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 10497}, {"wrapT", 10497}}};
    const std::size_t image =
        append(json_["images"], {{"mimeType", "image/png"}, {"bufferView", add_view(file, 0)}});
    return static_cast<int>(append(json_["textures"], {{"sampler", 0}, {"source", image}}));
  }

  /// Adds the faces with `is_in_part` as one primitive; adds nothing if there are none.
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
    nlohmann::json attributes{{"POSITION", add_positions(vertices)}};
    if (has_normals) attributes["NORMAL"] = add_normals(vertices);
    if (has_texture) attributes["TEXCOORD_0"] = add_uvs(vertices);
    const std::size_t view = add_words(indices, 34963);
    append(json_["meshes"][0]["primitives"], {{"attributes", std::move(attributes)},
                                              {"indices", add_accessor(view, 5125, indices.size(), "SCALAR")},
                                              {"material", material}});
  }

  [[nodiscard]] std::string file(const std::string& path) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "tapestry"}};
    json_["scene"] = 0;
    json_["scenes"] = {{{"nodes", {0}}}};
    // Turns x forward, z up into glTF's z forward, y up: by −120° about (1, 1, 1).
    json_["nodes"] = {{{"mesh", 0}, {"rotation", {-0.5, -0.5, -0.5, 0.5}}}};
    json_["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string json = json_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t length = 28 + std::uint64_t{json.size()} + buffer_.size();
    if (length > std::numeric_limits<std::uint32_t>::max())
      throw FileError(ErrorKind::limit, {path, "", "mesh is too large for a .glb of 4 GiB"});
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

  /// The corners of a primitive, each different combination once.
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

  /// \returns the index of the item in the list
  static std::size_t append(nlohmann::json& list, nlohmann::json item) {
    list.push_back(std::move(item));
    return list.size() - 1;
  }

  static void append_word(std::string& bytes, std::uint32_t value) {
    for (unsigned shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xFFU);
  }

  /// Appends words, the least significant byte first.
  template <class Word>
  std::size_t add_words(const std::vector<Word>& words, int target) {
    std::string bytes;
    bytes.reserve(4 * words.size());
    for (const Word word : words) append_word(bytes, std::bit_cast<std::uint32_t>(word));
    return add_view(bytes, target);
  }

  /// Appends bytes to the buffer, which stays a multiple of four long; target 0: none.
  std::size_t add_view(const std::string& bytes, int target) {
    nlohmann::json view{{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
    if (target != 0) view["target"] = target;
    buffer_ += bytes;
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    return append(json_["bufferViews"], std::move(view));
  }

  std::size_t add_accessor(std::size_t view, int component, std::size_t count, const char* type,
                           nlohmann::json bounds = nlohmann::json::object()) {
    bounds.update({{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return append(json_["accessors"], std::move(bounds));
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
    return add_floats(values, 3, "VEC3", {{"min", low}, {"max", high}});
  }

  std::size_t add_normals(const Vertices& vertices) {
    std::vector<float> values;
    for (const Corner& corner : vertices.corners) {
      const auto& normal = mesh_.normals[static_cast<std::size_t>(corner[2])];
      const double size = hypot(normal[0], normal[1], normal[2]);
      for (std::size_t axis = 0; axis < 3; ++axis)
        values.push_back(size > 0 ? static_cast<float>(normal[axis] / size) : axis == 2 ? 1.0F : 0.0F);
    }
    return add_floats(values, 3, "VEC3");
  }

  /// Texture coordinates of the vertices; v grows downwards in glTF.
  std::size_t add_uvs(const Vertices& vertices) {
    std::vector<float> values;
    for (const Corner& corner : vertices.corners) {
      const auto uv =
          corner[1] < 0 ? std::array<double, 2>{0, 0} : mesh_.uvs[static_cast<std::size_t>(corner[1])];
      values.push_back(static_cast<float>(uv[0] / u_extent_));
      values.push_back(static_cast<float>(1 - uv[1]));
    }
    return add_floats(values, 2, "VEC2");
  }

  std::size_t add_floats(const std::vector<float>& values, std::size_t width, const char* type,
                         nlohmann::json bounds = nlohmann::json::object()) {
    return add_accessor(add_words(values, 34962), 5126, values.size() / width, type, std::move(bounds));
  }

  const geometry::Mesh& mesh_;
  double u_extent_;
  nlohmann::json json_;
  std::string buffer_;
};

/// Unpainted faces, one primitive a material; with a picture, another primitive for faces without uv.
inline void add_plain_primitives(GlbBuilder& builder, const geometry::Mesh& mesh,
                                 const std::vector<std::uint8_t>& painted,
                                 const std::vector<std::string>& pictures) {
  std::vector<int> textures(mesh.materials.size() + 1, -1);
  // For each material, and for none: faces with its colour, faces with its picture.
  std::vector<std::array<std::vector<std::uint8_t>, 2>> parts(textures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {  // materials may share one
    const auto first = static_cast<std::size_t>(std::ranges::find(pictures, pictures[i]) - pictures.begin());
    textures[i] = first < i ? textures[first] : builder.add_png(pictures[i]);
  }
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (!painted.empty() && painted[face] != 0) continue;
    const std::int32_t index = face < mesh.face_materials.size() ? mesh.face_materials[face] : -1;
    const std::size_t material = index < 0 ? mesh.materials.size() : static_cast<std::size_t>(index);
    const bool has_uv = face < mesh.face_uvs.size() && std::ranges::min(mesh.face_uvs[face]) >= 0;
    auto& part = parts[material][textures[material] >= 0 && has_uv ? 1 : 0];
    part.resize(mesh.faces.size());
    part[face] = 1;
  }
  for (std::size_t material = 0; material < parts.size(); ++material)
    for (const bool has_picture : {false, true}) {
      const auto& part = parts[material][has_picture ? 1 : 0];
      if (part.empty()) continue;
      const geometry::Material none{"none"};
      const auto& entry = material < mesh.materials.size() ? mesh.materials[material] : none;
      const auto colour = has_picture ? std::array<float, 3>{1, 1, 1} : entry.colour;
      builder.add_primitive(builder.add_material(entry.name, colour, has_picture ? textures[material] : -1),
                            has_picture, [&](std::size_t face) { return part[face] != 0; });
    }
}

std::string glb_file(const std::string& path, const geometry::Mesh& mesh,
                     const std::vector<std::uint8_t>& painted, const GlbPictures& pictures) {
  GlbBuilder builder(mesh, pictures.u_extent);
  if (const int texture = builder.add_png(pictures.paint); texture >= 0)
    builder.add_primitive(builder.add_material(paint_name(mesh), {1, 1, 1}, texture), true,
                          [&](std::size_t face) { return painted[face] != 0; });
  add_plain_primitives(builder, mesh, painted, pictures.materials);
  return builder.file(path);
}
}  // namespace tapestry::io::detail
