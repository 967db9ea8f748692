#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/raster/face_charts.hpp>
#include "formatted.hpp"
#include "run_folder.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
// A texture carries a description of how it lies on its mesh: inside texture.npz, and for an atlas x.png in
// x.json beside it. Readers compare it with their mesh and options. Without it they have to assume.

inline constexpr const char* texture_format = "tapestry texture 1";

/// The painted faces in a description: their materials, the SHA-256 of their numbers, or all.
/// \param face_list  file of numbers, instead of materials; empty for none
inline Json painted_part(std::vector<std::string> materials, const std::string& face_list,
                         const std::vector<std::uint8_t>& painted) {
  if (face_list.empty() && materials.empty()) return "all";
  if (face_list.empty()) {
    std::ranges::sort(materials);
    materials.erase(std::unique(materials.begin(), materials.end()), materials.end());
    return {{"materials", materials}};
  }
  std::string numbers;
  for (std::size_t face = 0; face < painted.size(); ++face)
    if (painted[face] != 0) numbers += std::to_string(face + 1) + "\n";
  return {{"faces_sha256", io::sha256(numbers)}};
}

/// The description of a texture in the layout of a car.
/// \param painted  see painted_part()
/// \param axes     of the mesh in its file
inline Json description_of(const raster::PaintedMesh& car, const Json& painted,
                           const geometry::MeshAxes& axes) {
  const auto& layout = car.layout;
  Json json{{"format", texture_format}, {"kind", layout.traits().name}};
  json["texels"] = layout.texel_count(car.mesh);
  if (layout.traits().is_picture) {
    json["charts"] = "of the mesh";
    json["height"] = layout.height;
    json["width"] = layout.width;
    json["u_extent"] = layout.u_extent;
    json["v_extent"] = 1;
    json["filter"] = name_of(layout.filter);
    json["pyramid"] = car.pyramid != nullptr;
  } else if (layout.traits().is_by_face) {
    json["texels_per_edge"] = layout.texels_per_edge;
  }
  json["colour_space"] = name_of(car.space);
  json["painted"] = painted;
  json["up"] = axes.up;
  json["forward"] = axes.forward;
  return json;
}

/// The description of the atlas that a car is exported with, see raster::with_atlas(). Charts of the faces
/// fit the written mesh only: its paint's material, z up and the front at +x. \param own  of the car's
/// texture
inline Json exported_description(const raster::PaintedMesh& car, const Json& own) {
  if (car.layout.traits().is_picture) return own;
  const std::vector<std::string> paint{io::unused_material_name(car.mesh, "paint")};
  Json json = description_of(raster::with_atlas(car), painted_part(paint, "", {}), {});
  json["charts"] = "of the faces";
  return json;
}

/// Whether every painted face of a mesh has the chart that raster::face_charts() gives it.
inline bool has_face_charts(const geometry::Mesh& mesh, const std::vector<std::uint8_t>& painted) {
  const auto charted = raster::face_charts(mesh).mesh;
  if (mesh.face_uvs.size() != mesh.faces.size()) return false;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    for (std::size_t k = 0; k < 3 && painted[face] != 0; ++k) {
      if (mesh.face_uvs[face][k] < 0) return false;
      const auto& own = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
      const auto& chart = charted.uvs[static_cast<std::size_t>(charted.face_uvs[face][k])];
      if (std::abs(own[0] - chart[0]) > 1e-6 || std::abs(own[1] - chart[1]) > 1e-6) return false;
    }
  return true;
}

/// \throws FileError (malformed) unless a file's JSON is the description of a texture
inline void require_description(const std::string& path, const Json& json) {
  try {
    const auto text = [&](const char* name) { return json.at(name).get<std::string>(); };
    if (text("format") != texture_format) throw DomainError(std::string("no ") + texture_format);
    (void)json.at("texels").get<std::size_t>();
    const auto* const kind =
        std::ranges::find(raster::texture_traits, text("kind"), &raster::TextureTraits::name);
    if (kind != raster::texture_traits.end() && kind->is_picture) {
      (void)(json.at("height").get<std::size_t>() + json.at("width").get<std::size_t>());
      const auto extent = json.at("u_extent").get<double>();
      if (!(extent > 0 && extent <= 1e6)) throw DomainError("u_extent is not in 0 to 1e6");
      (void)raster::texture_filter_by_name(text("filter"));
    }
    (void)image::colour_space_by_name(text("colour_space"));
    (void)geometry::world_from_mesh({text("up"), text("forward")});
    const Json& painted = json.at("painted");
    if (painted != "all" && !painted.contains("faces_sha256"))
      (void)painted.at("materials").get<std::vector<std::string>>();
  } catch (const Json::exception& error) {
    throw malformed_file(
        {path, "", std::string("not the description of a texture: ") + json_fault(error.what())});
  } catch (const DomainError& error) {
    throw malformed_file({path, "", error.what()});
  }
}

/// Compares a texture's description with a car's. Another filter changes only lookups.
/// \returns  a warning of another filter; empty for the same
/// \throws FileError (mismatch) naming the first other fact, as found and as expected
inline std::string require_same_layout(const std::string& path, const Json& found, const Json& expected) {
  for (const auto& [name, fact] : expected.items()) {
    const Json other = found.value(name, Json());
    if (other != fact && name != "filter" && name != "pyramid")
      throw file_mismatch({path, "", "the texture is laid on a car in another way: " + name,
                           fact.dump(-1, ' ', false, Json::error_handler_t::replace),
                           other.dump(-1, ' ', false, Json::error_handler_t::replace)});
  }
  const auto filter = [](const Json& json) { return json.value("filter", std::string()); };
  if (filter(found) == filter(expected)) return {};
  return path + ": the texture is made for " + filter(found) + " lookup and drawn with " + filter(expected);
}

/// x.json for x.png.
inline std::string description_path(const std::string& png) {
  return io::path_of(png).replace_extension(".json").string();
}

inline void write_described_texture(const std::string& png, const Array<float, 3>& atlas,
                                    const Json& description) {
  io::write_image(png, atlas);
  write_text(description_path(png), report_text(description));
}

/// The description beside an atlas; none if there is no such file, or one of another kind.
/// \throws FileError: malformed, or mismatch if it describes a picture of other extents
inline std::optional<Json> read_texture_description(const std::string& png,
                                                    const std::array<std::size_t, 2>& extents) {
  const std::string path = description_path(png);
  if (!is_there(path)) return std::nullopt;
  Json json = read_json_file(path);
  if (!json.is_object() || json.value("format", Json()) != texture_format) return std::nullopt;
  require_description(path, json);
  const auto extent = [&](const char* name) { return json.value(name, std::size_t(0)); };
  if (std::array{extent("height"), extent("width")} != extents)
    throw file_mismatch({path, "", "describes an atlas of other extents than " + png,
                         std::to_string(extents[1]) + " x " + std::to_string(extents[0]),
                         std::to_string(extent("width")) + " x " + std::to_string(extent("height"))});
  return json;
}

/// Reads the paint of a texture.npz for a car. Prints a warning of another filter, and the
/// assumptions without a description.
/// \param description  of the car's texture
/// \throws FileError as camouflage::read_paint(), require_description() and require_same_layout()
inline camouflage::Paint<float> read_fitting_paint(const std::string& path, const raster::PaintedMesh& car,
                                                   const Json& description) {
  const std::string text = camouflage::read_layout(path);
  if (text.empty()) {
    remark(path + ": no description in it; assumed: laid as the mesh and the options say");
  } else {
    const Json found = io::read_json(text, path + ":layout").value;
    require_description(path, found);
    if (const auto word = require_same_layout(path, found, description); !word.empty()) remark(word);
  }
  return camouflage::read_paint(path, car.layout.texel_count(car.mesh));
}
}  // namespace tapestry::shell
