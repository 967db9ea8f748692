#pragma once
#include <cstddef>
#include <cstdint>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::raster {

/// One texel of a chart.
struct ChartTexel {
  std::size_t row = 0, column = 0;  ///< in the chart's box
  std::size_t texel = 0;            ///< in the texture
};

/// Texels that belong together, by their places in a box.
struct TextureChart {
  std::size_t height = 0, width = 0;  ///< of the box
  std::vector<ChartTexel> texels{};   ///< each place at most once, row by row
};

namespace detail {

/// The texels of a cube of s³ that some trilinear lookup takes from, see visit_cube_taps(): its coordinates
/// c_k are at least 0 and at most s − 1, have the sum s − 1, and lie within 1 of the texel's.
std::vector<std::size_t> used_cube_texels(std::size_t edge);

}  // namespace detail

/// The charts of a texture: which of its texels painted faces refer to, and which of these lie side by side.
///
/// atlas: a chart is a set of painted faces that hang together in uv, by points that they share; its texels
/// are those that bilinear lookups in these faces take from, each in one chart only: that of the first face
/// which has its centre, else of the first that reaches it. Where the faces repeat the atlas so often that
/// used_texels() refuses to count, all of it is one chart.
/// The other kinds have no plane that their texels lie in, and are one chart. cube: a row for every painted
/// face, in the order of the mesh, of the texels that trilinear lookups take from; neighbours in a column are
/// near each other on the mesh as far as its faces are in order. vertex: a row of the positions that painted
/// faces have, in their order. solid: its one texel.
///
/// \returns  charts with texels, in the order of their first faces; none if no face is painted
/// \throws ShapeError, DomainError, Error (mismatch, limit) as texture_operator() does
[[nodiscard]] std::vector<TextureChart> texture_charts(const PaintedMesh& body);

/// Charts of those texels alone that are painted: of each chart the pieces that hang together side by side.
/// \param painted  [texel], 1 where painted; empty: everywhere, which leaves the charts as they are
/// \throws ShapeError if a texel of a chart has no entry
[[nodiscard]] std::vector<TextureChart> painted_charts(std::vector<TextureChart> charts,
                                                       const std::vector<std::uint8_t>& painted);

}  // namespace tapestry::raster
