#pragma once
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::raster {
/// atlas: one picture that the mesh's uv coordinates point into. cube: s³ texels for every face, looked up by
/// barycentric coordinates, as in Neural Mesh Renderer. vertex: a colour for every position of the mesh,
/// interpolated over its faces. solid: one colour for all painted faces.
enum class TextureKind { atlas, cube, vertex, solid };

/// Properties of a kind of texture. Other code reads these traits; only this header and
/// detail/texture_kinds.hpp distinguish kinds.
struct TextureTraits {
  TextureKind kind;
  std::string_view name;  ///< in options and descriptions of textures
  bool is_picture;        ///< a picture that uvs point into: it can be filtered, and written to a file
  bool is_by_face;        ///< each face has texels of its own, which every sample looks up
  bool is_interpolated;   ///< a face's colour is linear between its corners: neighbours agree along an edge
  bool is_one_colour;     ///< the same everywhere
};

/// Those of all kinds, in their order.
inline constexpr std::array<TextureTraits, 4> texture_traits{{
    {TextureKind::atlas, "atlas", true, false, false, false},
    {TextureKind::cube, "cube", false, true, false, false},
    {TextureKind::vertex, "vertex", false, false, true, false},
    {TextureKind::solid, "solid", false, false, true, true},
}};

/// Lookup of an atlas. bilinear: in the atlas itself. trilinear: between the two levels of its pyramid whose
/// texels are about as large as the pixel's footprint is long, see MipPyramid. anisotropic: like trilinear,
/// with texels as large as the footprint is wide, at several places along it.
enum class TextureFilter { bilinear, trilinear, anisotropic };

/// All of them.
inline constexpr std::array texture_filters{TextureFilter::bilinear, TextureFilter::trilinear,
                                            TextureFilter::anisotropic};

/// The name in options and manifests.
[[nodiscard]] constexpr const char* name_of(TextureFilter filter) {
  if (filter == TextureFilter::bilinear) return "bilinear";
  return filter == TextureFilter::trilinear ? "trilinear" : "anisotropic";
}

/// \throws DomainError if no filter has that name
[[nodiscard]] inline TextureFilter texture_filter_by_name(const std::string& name) {
  for (const TextureFilter filter : texture_filters)
    if (name == name_of(filter)) return filter;
  throw DomainError({"no texture filter ", in_quotes(name), "; expected bilinear, trilinear or anisotropic"});
}

/// Layout of a texture; the texels themselves are an array [texel_count, 3].
struct TextureLayout {
  TextureKind kind = TextureKind::atlas;
  std::size_t height = 0;           ///< atlas: rows, row 0 on top (v = 1)
  std::size_t width = 0;            ///< atlas: columns
  double u_extent = 1;              ///< atlas: u in [0, u_extent] spans the width; 2 for the car's 2×1 atlas
  std::size_t texels_per_edge = 0;  ///< cube: s
  TextureFilter filter = TextureFilter::bilinear;  ///< of an atlas; ignored by the other kinds
  std::size_t most_lookups = 8;  ///< anisotropic: places along a footprint, at most; 1 to 64

  [[nodiscard]] constexpr const TextureTraits& traits() const {
    return texture_traits[static_cast<std::size_t>(kind)];
  }

  /// atlas: height · width, texel row · width + column; cube: F · s³, texel ((f·s + a)·s + b)·s + c;
  /// vertex: V, texel = position; solid: 1.
  [[nodiscard]] std::size_t texel_count(const geometry::Mesh& mesh) const {
    switch (kind) {
      case TextureKind::atlas:
        return height * width;
      case TextureKind::cube:
        return mesh.faces.size() * texels_per_edge * texels_per_edge * texels_per_edge;
      case TextureKind::vertex:
        return mesh.positions.size();
      case TextureKind::solid:
        break;
    }
    return 1;
  }

  /// Whether the other has the same texels and lookups.
  [[nodiscard]] bool fits(const TextureLayout& other) const {
    if (kind != other.kind) return false;
    if (traits().is_by_face) return texels_per_edge == other.texels_per_edge;
    return !traits().is_picture ||
           (height == other.height && width == other.width && u_extent == other.u_extent &&
            filter == other.filter && most_lookups == other.most_lookups);
  }
};

/// The layout of an atlas.
[[nodiscard]] constexpr TextureLayout atlas_layout(std::size_t height, std::size_t width, double u_extent = 1,
                                                   TextureFilter filter = TextureFilter::bilinear) {
  return {TextureKind::atlas, height, width, u_extent, 0, filter};
}

/// The layout of cubes of s³ texels.
[[nodiscard]] constexpr TextureLayout cube_layout(std::size_t texels_per_edge) {
  return {TextureKind::cube, 0, 0, 1, texels_per_edge};
}

/// The layout of a colour for every position.
inline constexpr TextureLayout vertex_layout{TextureKind::vertex};
/// The layout of one colour.
inline constexpr TextureLayout solid_layout{TextureKind::solid};

/// One texel and its weight in a lookup.
struct Tap {
  std::size_t texel;
  double weight;
};

/// Trilinear lookup in a face's cube of s³ texels: calls visit(Tap) up to eight times, with weights that
/// sum to 1.
///
///   c_k = clamp(b_k·(s − 1), 0, s − 1 − 10⁻³),   texel (a, b, c) at ((f·s + a)·s + b)·s + c,
/// where b_k is the perspective-correct barycentric coordinate, w_k·z/z_k in the source's terms.
/// Source: Neural Mesh Renderer, rasterisation kernel, with its eps of 10⁻³.
///
/// \param face         f
/// \param barycentric  b, in [0, 1]
template <class Visit>
void visit_cube_taps(const TextureLayout& layout, std::size_t face, const std::array<double, 3>& barycentric,
                     Visit visit) {
  const std::size_t edge = layout.texels_per_edge;
  const double last = static_cast<double>(edge) - 1;
  std::array<std::size_t, 3> cell;
  std::array<double, 3> share;
  for (std::size_t k = 0; k < 3; ++k) {
    const double position = std::max(std::min(barycentric[k] * last, last - 1e-3), 0.0);
    cell[k] = static_cast<std::size_t>(position);
    share[k] = position - static_cast<double>(cell[k]);
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::size_t texel = face;
    double weight = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool upper = ((corner >> k) & 1U) != 0;
      texel = texel * edge + cell[k] + (upper ? 1 : 0);
      weight *= upper ? share[k] : 1 - share[k];
    }
    if (weight > 0) visit(Tap{texel, weight});
  }
}

namespace detail {
/// Whether a coordinate lies outside [0, extent]; up to a billionth beyond it, as rounding may cause, counts
/// as on the border.
inline bool is_outside(double coordinate, double extent) {
  const double slack = 1e-9 * extent;
  return coordinate < -slack || coordinate > extent + slack;
}

/// A coordinate moved into [0, extent] by whole multiples of extent. Coordinates in the closed interval stay,
/// so that a chart that ends at the right or upper border does not jump to the other side.
inline double wrapped(double coordinate, double extent) {
  if (is_outside(coordinate, extent)) coordinate -= extent * std::floor(coordinate / extent);
  return std::clamp(coordinate, 0.0, extent);
}

/// Two neighbouring indices along an axis and the weight of the second.
struct AxisTaps {
  std::size_t first;
  std::size_t second;
  double share;

  AxisTaps(double position, std::size_t size) {
    const double clamped = std::clamp(position, 0.0, static_cast<double>(size - 1));
    first = static_cast<std::size_t>(static_cast<std::int64_t>(clamped));  // quicker than at once
    second = std::min(first + 1, size - 1);
    share = clamped - static_cast<double>(first);
  }
};
}  // namespace detail

/// Bilinear lookup in a picture: calls visit(Tap) up to four times, with weights that sum to 1.
/// \param u, v  in [0, 1]; v = 1 is the top
template <class Visit>
void visit_picture_taps(std::size_t height, std::size_t width, double u, double v, Visit visit) {
  const detail::AxisTaps column(u * static_cast<double>(width) - 0.5, width);
  const detail::AxisTaps row((1 - v) * static_cast<double>(height) - 0.5, height);
  const auto tap = [&](std::size_t i, std::size_t j, double weight) {
    if (weight > 0) visit(Tap{i * width + j, weight});
  };
  tap(row.first, column.first, (1 - row.share) * (1 - column.share));
  tap(row.first, column.second, (1 - row.share) * column.share);
  tap(row.second, column.first, row.share * (1 - column.share));
  tap(row.second, column.second, row.share * column.share);
}

/// Bilinear lookup in an atlas: calls visit(Tap) up to four times, with weights that sum to 1.
///
/// Texel (row i, column j) has its centre at u = (j + ½)·u_extent/width, v = 1 − (i + ½)/height. uv
/// outside [0, u_extent] × [0, 1] repeats; within the outer half texel the border texel is used alone
/// (opposite borders do not mix).
template <class Visit>
void visit_atlas_taps(const TextureLayout& layout, const std::array<double, 2>& uv, Visit visit) {
  visit_picture_taps(layout.height, layout.width, detail::wrapped(uv[0], layout.u_extent) / layout.u_extent,
                     detail::wrapped(uv[1], 1), visit);
}

/// uv of a point of a face that has texture coordinates.
/// \param b  its barycentric coordinates
[[nodiscard]] inline std::array<double, 2> uv_of_point(const geometry::Mesh& mesh, std::size_t face,
                                                       const std::array<double, 3>& b) {
  std::array<double, 2> uv{0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& corner = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
    for (std::size_t axis = 0; axis < 2; ++axis) uv[axis] += b[k] * corner[axis];
  }
  return uv;
}

/// Lookup of a point of a face without a filter: calls visit(Tap), with weights that sum to 1.
/// \param b  barycentric coordinates of the point
template <class Visit>
void visit_taps(const TextureLayout& layout, const geometry::Mesh& mesh, std::size_t face,
                const std::array<double, 3>& b, Visit visit) {
  switch (layout.kind) {
    case TextureKind::atlas:
      return visit_atlas_taps(layout, uv_of_point(mesh, face, b), visit);
    case TextureKind::cube:
      return visit_cube_taps(layout, face, b, visit);
    case TextureKind::vertex:
      for (std::size_t k = 0; k < 3; ++k) visit(Tap{static_cast<std::size_t>(mesh.faces[face][k]), b[k]});
      return;
    case TextureKind::solid:
      return visit(Tap{0, 1});
  }
}
}  // namespace tapestry::raster
