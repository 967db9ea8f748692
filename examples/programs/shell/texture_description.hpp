#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/texture_layout.hpp>

#include "run_folder.hpp"

namespace tapestry::shell {

// Beside an atlas x.png stands x.json: how the atlas lies on its mesh. Without it, a reader has to assume.

/// How an atlas lies on a mesh, as its description says.
struct TextureDescription {
  double u_extent = 1;  ///< the width of the atlas in u
  raster::TextureFilter filter = raster::TextureFilter::bilinear;
  image::ColourSpace space = image::ColourSpace::linear;
};

inline constexpr const char* texture_format = "tapestry texture 1";

/// x.json for x.png.
inline std::string description_of_texture(const std::string& png) {
  return std::filesystem::path(png).replace_extension(".json").string();
}

/// Writes an atlas as PNG, and its description beside it.
/// \param car  in whose layout the atlas is
inline void write_described_texture(const std::string& png, const Array<float, 3>& atlas,
                                    const raster::PaintedMesh& car) {
  io::write_image(png, atlas);
  write_text(description_of_texture(png), report_text({{"format", texture_format},
                                                       {"height", atlas.shape(0)},
                                                       {"width", atlas.shape(1)},
                                                       {"u_extent", car.layout.u_extent},
                                                       {"v_extent", 1},
                                                       {"filter", name_of(car.layout.filter)},
                                                       {"colour_space", name_of(car.space)}}));
}

/// The description beside an atlas; none if there is no such file, or one of another kind.
/// \throws FileError: malformed, or mismatch if it describes a picture of other extents
inline std::optional<TextureDescription> read_texture_description(const std::string& png,
                                                                  const std::array<std::size_t, 2>& extents) {
  const std::string path = description_of_texture(png);
  if (!is_there(path)) return std::nullopt;
  const Json json = read_json_file(path);
  if (!json.is_object() || json.value("format", Json()) != texture_format) return std::nullopt;
  try {
    const auto described =
        std::array{json.at("height").get<std::size_t>(), json.at("width").get<std::size_t>()};
    if (described != extents)
      throw FileError(ErrorKind::mismatch,
                      {path, "", "describes an atlas of other extents than " + png,
                       std::to_string(extents[1]) + " x " + std::to_string(extents[0]),
                       std::to_string(described[1]) + " x " + std::to_string(described[0])});
    TextureDescription description{json.at("u_extent").get<double>(),
                                   raster::texture_filter_by_name(json.at("filter").get<std::string>()),
                                   image::colour_space_by_name(json.at("colour_space").get<std::string>())};
    if (!(description.u_extent > 0 && description.u_extent <= 1e6))
      throw DomainError("u_extent is not in 0 to 1e6");
    return description;
  } catch (const Json::exception& error) {
    throw FileError(ErrorKind::malformed,
                    {path, "", std::string("not the description of a texture: ") + error.what()});
  } catch (const DomainError& error) {
    throw FileError(ErrorKind::malformed, {path, "", error.what()});
  }
}

}  // namespace tapestry::shell
