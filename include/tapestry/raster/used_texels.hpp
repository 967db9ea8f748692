#pragma once
#include <tapestry/raster/detail/fragment_shader.hpp>  // require_layout

namespace tapestry::raster {
/// One texel of a chart.
struct ChartTexel {
  std::size_t row = 0, column = 0;  ///< in the chart's box
  std::size_t texel = 0;            ///< in the texture
};

/// Texels of one connected part of a texture, by their places in a box.
struct TextureChart {
  std::size_t height = 0, width = 0;  ///< of the box
  std::vector<ChartTexel> texels{};   ///< each place at most once, row by row
};

namespace detail {
/// The texels of a cube of s³ that some trilinear lookup reads, see visit_cube_taps(): its coordinates c_k
/// are at least 0 and at most s − 1, have the sum s − 1, and lie within 1 of the texel's.
std::vector<std::size_t> used_cube_texels(std::size_t edge);
}  // namespace detail

/// The charts of a texture: which texels painted faces refer to, and which of these lie side by side.
///
/// atlas: a chart is a set of painted faces that are connected in uv, by points that they share; its texels
/// are those that bilinear lookups in these faces read. A texel belongs to one chart only: the chart of the
/// first face that contains its centre, else of the first that reaches it. The atlas is one chart if faces
/// repeat it so often that used_texels() throws. The other kinds have no plane that contains their texels,
/// and are one chart. cube: a row for every painted face, in the order of the mesh, with the texels that
/// trilinear lookups read; neighbours in a column are near each other on the mesh if its faces are in order.
/// vertex: a row with the positions of painted faces, in their order. solid: its one texel.
///
/// \returns  charts with texels, in the order of their first faces; none if no face is painted
/// \throws ShapeError, DomainError, Error (mismatch, limit) as texture_operator() does
[[nodiscard]] std::vector<TextureChart> texture_charts(const PaintedMesh& body);

/// Share of the painted area that an atlas hardly holds: charts with less than one texel, or less than a
/// hundredth of the texels that an even atlas of its size would give them. Faces whose corners share a point
/// of a palette are such charts. \returns 0 to 1; 0 for textures of other kinds and where the painted faces
/// have no area \throws as texture_charts()
[[nodiscard]] double starved_share(const PaintedMesh& body);

/// Charts restricted to painted texels: the pieces of each chart that are connected side by side.
/// \param painted  [texel], 1 where painted; empty: everywhere, which leaves the charts unchanged
/// \throws ShapeError if a texel of a chart has no entry
[[nodiscard]] std::vector<TextureChart> painted_charts(std::vector<TextureChart> charts,
                                                       const std::vector<std::uint8_t>& painted);

namespace detail {
using UvTriangle = std::array<std::array<double, 2>, 3>;  // in texels: column, row

/// An open rectangle by its edges.
struct TexelRectangle {
  double left, right, top, bottom;

  /// Whether it meets a triangle, which may have no area: no line parallel to a side of either separates
  /// them.
  [[nodiscard]] bool meets(const UvTriangle& corner) const;
};

/// Bounds, along one axis, of the places whose lookups read texel `index`: within a texel of its centre, and
/// within the same repetition of the atlas.
std::array<double, 2> reach_of_texel(long long index, double size);

/// Bounds the work for faces with many repetitions.
inline constexpr std::uint64_t most_texel_visits = std::uint64_t(1) << 30U;

/// Calls visit(row, column) for the texels that lookups in a uv triangle read.
template <class Visit>
void for_each_texel_of(const UvTriangle& corner, const TextureLayout& layout, std::uint64_t& work,
                       Visit visit) {
  const std::array<double, 2> size{static_cast<double>(layout.width), static_cast<double>(layout.height)};
  const auto bounds = [&](std::size_t axis) {
    const auto [low, high] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
    return std::array<long long, 2>{static_cast<long long>(std::floor(low - 1.5)),
                                    static_cast<long long>(std::ceil(high + 1.5))};
  };
  const auto wrapped_index = [](long long index, std::size_t extent) {
    const auto period = static_cast<long long>(extent);
    return static_cast<std::size_t>(((index % period) + period) % period);
  };
  const auto columns = bounds(0), rows = bounds(1);
  work += static_cast<std::uint64_t>(columns[1] - columns[0]) * static_cast<std::uint64_t>(rows[1] - rows[0]);
  if (work > most_texel_visits)
    throw Error(ErrorKind::limit, {"used_texels: the painted faces span over more than ", most_texel_visits,
                                   " texels, each counted for itself"});
  for (long long row = rows[0]; row < rows[1]; ++row)
    for (long long column = columns[0]; column < columns[1]; ++column) {
      const auto x = reach_of_texel(column, size[0]), y = reach_of_texel(row, size[1]);
      if (TexelRectangle{x[0], x[1], y[0], y[1]}.meets(corner))
        visit(wrapped_index(row, layout.height), wrapped_index(column, layout.width));
    }
}

/// Distances, in texels, to move a triangle along an axis: 0, unless the triangle has no extent and lies on a
/// border of the atlas, as unused uv often do. Then it is moved to the side that lookups read, see wrapped();
/// to both sides if rounding decides.
/// \param axis  0 for columns, 1 for rows; rows run against v
[[nodiscard]] std::vector<double> moves_off_border(const UvTriangle& corner, std::size_t axis, double size);

/// Calls visit(face, row, column) for the texels that lookups in each painted face read.
/// \param body   with an atlas, and past require_layout()
/// \throws Error (limit) as used_texels()
template <class Visit>
void for_each_used_texel(const PaintedMesh& body, Visit visit) {
  const TextureLayout& layout = body.layout;
  std::uint64_t work = 0;
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    UvTriangle corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& uv = body.mesh.uvs[static_cast<std::size_t>(body.mesh.face_uvs[face][k])];
      corner[k] = {uv[0] / layout.u_extent, 1 - uv[1]};
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto [low, high] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
      if (high - low > 8)
        throw Error(ErrorKind::limit, {"used_texels: face ", face, " spans over ", high - low,
                                       " repetitions of the atlas, expected at most 8"});
      for (auto& point : corner) point[axis] *= static_cast<double>(axis == 0 ? layout.width : layout.height);
    }
    for (const double right : moves_off_border(corner, 0, static_cast<double>(layout.width)))
      for (const double down : moves_off_border(corner, 1, static_cast<double>(layout.height))) {
        UvTriangle moved = corner;
        for (auto& [column, row] : moved) {
          column += right;
          row += down;
        }
        for_each_texel_of(moved, layout, work,
                          [&](std::size_t row, std::size_t column) { visit(face, row, column); });
      }
  }
}
}  // namespace detail

/// The texels of an atlas that painted faces refer to, from any view: those that some bilinear lookup within
/// a face reads. Losses over a texture count steps within this mask.
///
/// \returns  [height, width], 1 where used and 0 elsewhere; row 0 on top
/// \throws DomainError unless the layout is an atlas; ShapeError, DomainError, Error (mismatch) as
///         texture_operator() does; Error (limit) if a painted face spans over more than 8 repetitions of the
///         atlas along an axis, or all of them over more than 2³⁰ texels
template <std::floating_point T>
[[nodiscard]] Array<T, 2> used_texels(const PaintedMesh& body);

/// used_texels(), or all texels if faces repeat the atlas so often that it throws.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> used_texels_or_all(const PaintedMesh& body);

/// The pyramid of a body's atlas, over the texels that painted faces refer to; null if the atlas is not
/// filtered.
/// \throws as used_texels(), except for its limit
[[nodiscard]] std::shared_ptr<const MipPyramid> pyramid_of(const PaintedMesh& body);
}  // namespace tapestry::raster
