#pragma once
#include <cstddef>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::camouflage {

/// The paint that a run ended with, of its texture.npz: colours, [texel, 3], and painted, [texel], 0 or 1; if
/// the latter is missing, all is paint.
/// \throws FileError: mismatch (of another car or layout), malformed (other values)
[[nodiscard]] Paint<float> read_paint(const std::string& path, std::size_t texel_count);

/// The offsets of the car's positions that a run ended with, of its texture.npz, see shape_offsets(); of
/// extent 0 if it left the shape as it was.
/// \throws FileError: mismatch (of another mesh), malformed (offsets farther than the car is long)
[[nodiscard]] Array<float, 2> read_offsets(const std::string& path, std::size_t position_count);

/// Writes what read_paint() and read_offsets() read, and the parameter that a method made it of, [row, 3].
/// \param offsets  [V, 3], or of extent 0 where the shape stays
/// \throws ShapeError as require_sound(); FileError (write)
void write_paint(const std::string& path, const Array<float, 2>& parameter, const Paint<float>& paint,
                 const Array<float, 2>& offsets = {});

}  // namespace tapestry::camouflage
