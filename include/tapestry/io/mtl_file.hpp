#pragma once
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::io {

/// Reads the names, diffuse colours (Kd) and names of textures (map_Kd) of a Wavefront material file held in
/// memory; the other properties are ignored. The name may be empty; a material without a colour has that of
/// geometry::Material. Textures outside the folder of the file are left out with a warning; whether the
/// others are there is not looked at.
///
/// \param path      names the file in messages
/// \param warnings  receives oddities that are no reason to refuse, one line each and at most 100
/// \throws FileError: malformed (colours that are not numbers; colours or textures before the first material)
[[nodiscard]] std::vector<geometry::Material> parse_mtl(std::string_view text, const std::string& path,
                                                        std::vector<std::string>& warnings);

/// Reads a Wavefront material file of at most 16 MiB; otherwise as parse_mtl().
/// Takes memory of at most 24 times the file and 1 MiB.
/// \throws FileError as parse_mtl() and read_text_file()
[[nodiscard]] std::vector<geometry::Material> read_mtl(const std::string& path,
                                                       std::vector<std::string>& warnings);

}  // namespace tapestry::io
