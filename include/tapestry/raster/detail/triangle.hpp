#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace tapestry::raster {

/// A triangle ready for rasterising.
///
/// Depth has the same bits wherever and with whatever instructions it is computed, fused or not. At sample
/// (row, column) with column = 16·g + lane
///   1/z = clamp(float((c₀ + c₁·16·g) + c₂·row) + lane·step),
/// where c₁ and c₂ have 37 significant bits and step, which is c₁ again, has 20: all products are exact.
struct ScreenTriangle {
  std::array<std::int32_t, 3> x;  ///< 1/256 of a sample's width; corners run clockwise on the screen
  std::array<std::int32_t, 3> y;  ///< 1/256 of a sample's height
  std::int32_t face;
  float inverse_depth_min;  ///< 1/z is clamped to that of the face's own points: an edge-on plane is steep
  float inverse_depth_max;
  float step;
  std::array<double, 3> inverse_depth;  ///< c₀, c₁, c₂

  bool operator==(const ScreenTriangle&) const = default;
};

inline constexpr std::int32_t depth_group = 16;  ///< samples side by side that share c₀ + c₁·16·g

/// Samples of a tile along each axis; a tile's faces and depths fill 16 KiB.
inline constexpr std::size_t tile_width = 64;
inline constexpr std::size_t tile_height = 32;  ///< see tile_width

/// Tiles that a triangle's box touches, ends included.
struct TileRange {
  std::uint16_t first_column, first_row, last_column, last_row;

  bool operator==(const TileRange&) const = default;
};

/// The part of a picture that is drawn at once.
struct Tile {
  std::int32_t row;      ///< of its first sample in the picture
  std::int32_t column;   ///< likewise; a multiple of tile_width
  std::int32_t rows;     ///< samples, at most tile_height
  std::int32_t columns;  ///< samples, at most tile_width; what lies beyond, up to a multiple of 16, is
                         ///< overwritten, too
  std::int32_t* faces;   ///< [rows, columns]
  std::size_t stride;    ///< step between rows of `faces`
  float* depth;          ///< [rows, tile_width], 1/z, 0 for none
};

}  // namespace tapestry::raster
