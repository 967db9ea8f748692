#pragma once
#include <map>
#include <numeric>
#include <set>
#include <tapestry/raster/detail/texture_kinds.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::raster {
namespace detail {
inline constexpr std::size_t no_chart = std::numeric_limits<std::size_t>::max();

/// Disjoint sets of numbers: joined first, looked up afterwards.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t(0));
  }
  std::size_t find(std::size_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }
  void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parent_;
};

/// The chart of each face, numbered in the order of the painted faces; no_chart for unpainted ones. Painted
/// faces that share a point of uv, whichever index it has, belong to one chart.
/// \param body  with a finite uv for every corner of a painted face
inline std::vector<std::size_t> chart_of_faces(const PaintedMesh& body) {
  const auto& mesh = body.mesh;
  std::map<std::array<double, 2>, std::size_t> points;
  std::vector<std::array<std::size_t, 3>> points_of_face(body.painted.size());
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    for (std::size_t k = 0; body.painted[face] != 0 && k < 3; ++k) {
      const auto& uv = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
      points_of_face[face][k] = points.emplace(uv, points.size()).first->second;
    }
  DisjointSets sets(points.size());
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    for (std::size_t k = 1; body.painted[face] != 0 && k < 3; ++k)
      sets.join(points_of_face[face][0], points_of_face[face][k]);
  std::map<std::size_t, std::size_t> chart_of_set;
  std::vector<std::size_t> chart(body.painted.size(), no_chart);
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    if (body.painted[face] != 0)
      chart[face] =
          chart_of_set.emplace(sets.find(points_of_face[face][0]), chart_of_set.size()).first->second;
  return chart;
}

/// The chart of each texel of an atlas, no_chart for unused ones: the chart of the first painted face whose
/// uv triangle contains its centre, else of the first whose lookups read it.
inline std::vector<std::size_t> chart_of_texels(const PaintedMesh& body) {
  const TextureLayout& layout = body.layout;
  const std::vector<std::size_t> chart_of_face = chart_of_faces(body);
  std::vector<std::size_t> chart(layout.height * layout.width, no_chart);
  const auto claim = [&](std::size_t face, std::size_t row, std::size_t column) {
    std::size_t& owner = chart[row * layout.width + column];
    if (owner == no_chart) owner = chart_of_face[face];
  };
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    for_each_atlas_texel(body.mesh, layout, face,
                         [&](std::size_t row, std::size_t column, const std::array<double, 3>& barycentric) {
                           if (std::min({barycentric[0], barycentric[1], barycentric[2]}) >= 0)
                             claim(face, row, column);
                         });
  }
  for_each_used_texel(body, claim);
  return chart;
}

/// Sets a chart's box to the bounding box of its texels; it must have some.
inline void fit_box(TextureChart& chart) {
  const std::size_t top = chart.texels.front().row;
  std::size_t left = chart.texels.front().column;
  for (const ChartTexel& texel : chart.texels) left = std::min(left, texel.column);
  chart.height = chart.width = 0;
  for (ChartTexel& texel : chart.texels) {
    texel.row -= top;
    texel.column -= left;
    chart.height = std::max(chart.height, texel.row + 1);
    chart.width = std::max(chart.width, texel.column + 1);
  }
}

/// The texels with their charts as pictures, each in its bounding box.
/// \param chart_of_texel  of each texel of an atlas, row by row
inline std::vector<TextureChart> charts_in_boxes(const std::vector<std::size_t>& chart_of_texel,
                                                 std::size_t atlas_width) {
  std::map<std::size_t, TextureChart> charts;
  for (std::size_t texel = 0; texel < chart_of_texel.size(); ++texel)
    if (chart_of_texel[texel] != no_chart)
      charts[chart_of_texel[texel]].texels.push_back({texel / atlas_width, texel % atlas_width, texel});
  std::vector<TextureChart> found;
  for (auto& [number, chart] : charts) {
    fit_box(chart);
    found.push_back(std::move(chart));
  }
  return found;
}

inline std::vector<TextureChart> charts_of_atlas(const PaintedMesh& body) {
  const TextureLayout& layout = body.layout;
  try {
    return charts_in_boxes(chart_of_texels(body), layout.width);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::limit) throw;
    return charts_in_boxes(std::vector<std::size_t>(layout.height * layout.width, 0), layout.width);
  }
}

std::vector<std::size_t> used_cube_texels(std::size_t edge) {
  std::vector<std::size_t> used;
  for (std::size_t texel = 0; texel < edge * edge * edge; ++texel) {
    std::size_t least = 0, most = 0;
    for (const std::size_t at : {texel / (edge * edge), texel / edge % edge, texel % edge}) {
      least += at == 0 ? 0 : at - 1;
      most += at + 1;
    }
    if (edge == 1 || (least < edge - 1 && most > edge - 1)) used.push_back(texel);
  }
  return used;
}

inline TextureChart chart_of_cubes(const PaintedMesh& body) {
  const std::size_t edge = body.layout.texels_per_edge;
  const std::vector<std::size_t> used = used_cube_texels(edge);
  TextureChart chart{0, used.size()};
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    for (std::size_t column = 0; column < used.size(); ++column)
      chart.texels.push_back({chart.height, column, face * edge * edge * edge + used[column]});
    ++chart.height;
  }
  return chart;
}

/// The texels between which faces are interpolated.
inline TextureChart chart_of_corners(const PaintedMesh& body) {
  std::set<std::size_t> used;
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    if (body.painted[face] != 0)
      visit_taps(body.layout, body.mesh, face, {}, [&](const Tap& tap) { used.insert(tap.texel); });
  TextureChart chart{1, used.size()};
  for (const std::size_t texel : used) chart.texels.push_back({0, chart.texels.size(), texel});
  return chart;
}

/// The connected pieces of a chart (side by side), each in its bounding box, in the order of their first
/// texels.
inline std::vector<TextureChart> connected_pieces(const TextureChart& chart) {
  std::vector<std::size_t> at(chart.height * chart.width, no_chart);
  for (std::size_t i = 0; i < chart.texels.size(); ++i)
    at[chart.texels[i].row * chart.width + chart.texels[i].column] = i;
  DisjointSets sets(chart.texels.size());
  for (std::size_t i = 0; i < chart.texels.size(); ++i) {
    const auto [row, column, texel] = chart.texels[i];
    const std::size_t place = row * chart.width + column;
    if (column > 0 && at[place - 1] != no_chart) sets.join(i, at[place - 1]);
    if (row > 0 && at[place - chart.width] != no_chart) sets.join(i, at[place - chart.width]);
  }
  std::map<std::size_t, std::size_t> piece_of_set;
  std::vector<TextureChart> pieces;
  for (std::size_t i = 0; i < chart.texels.size(); ++i) {
    const std::size_t piece = piece_of_set.emplace(sets.find(i), pieces.size()).first->second;
    if (piece == pieces.size()) pieces.emplace_back();
    pieces[piece].texels.push_back(chart.texels[i]);
  }
  for (TextureChart& piece : pieces) fit_box(piece);
  return pieces;
}
}  // namespace detail

std::vector<TextureChart> texture_charts(const PaintedMesh& body) {
  detail::require_layout("texture_charts", body);
  if (std::all_of(body.painted.begin(), body.painted.end(), [](std::uint8_t is) { return is == 0; }))
    return {};
  const TextureTraits& traits = body.layout.traits();
  if (traits.is_picture) return detail::charts_of_atlas(body);
  return {traits.is_by_face ? detail::chart_of_cubes(body) : detail::chart_of_corners(body)};
}

double starved_share(const PaintedMesh& body) {
  detail::require_layout("starved_share", body);
  const TextureLayout& layout = body.layout;
  if (!layout.traits().is_picture) return 0;
  const auto& mesh = body.mesh;
  const double texels_by_uv = static_cast<double>(layout.height * layout.width) / layout.u_extent;
  const std::vector<std::size_t> chart_of_face = detail::chart_of_faces(body);
  struct Sums {
    double area = 0, texels = 0;
    std::array<double, 2> low{1e9, 1e9}, high{-1e9, -1e9};  ///< of its box in uv
    [[nodiscard]] double box() const { return (high[0] - low[0]) * (high[1] - low[1]); }
  };
  std::map<std::size_t, Sums> charts;
  double whole = 0, starved = 0;
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    std::array<geometry::Vector3, 3> corner{};
    std::array<std::array<double, 2>, 3> uv{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])];
      uv[k] = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
    }
    const double area = geometry::length(
        geometry::cross(geometry::subtract(corner[1], corner[0]), geometry::subtract(corner[2], corner[0])));
    const double across = (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]),
                 back = (uv[2][0] - uv[0][0]) * (uv[1][1] - uv[0][1]);
    Sums& sums = charts[chart_of_face[face]];
    for (std::size_t k = 0; k < 6; ++k) {
      sums.low[k % 2] = std::min(sums.low[k % 2], uv[k / 2][k % 2]);
      sums.high[k % 2] = std::max(sums.high[k % 2], uv[k / 2][k % 2]);
    }
    sums.area += area / 2;
    sums.texels += std::abs(across - back) / 2 * texels_by_uv;
    whole += area / 2;
  }
  const auto texel_count = static_cast<double>(layout.height * layout.width);
  for (const auto& [chart, sums] : charts)
    if (std::min(sums.texels, sums.box() * texels_by_uv) <
        std::max(1.0, 0.01 * texel_count * sums.area / whole))
      starved += sums.area;
  return whole > 0 ? starved / whole : 0;
}

std::vector<TextureChart> painted_charts(std::vector<TextureChart> charts,
                                         const std::vector<std::uint8_t>& painted) {
  if (painted.empty()) return charts;
  std::vector<TextureChart> pieces;
  for (TextureChart& chart : charts) {
    for (const ChartTexel& texel : chart.texels)
      if (texel.texel >= painted.size())
        throw ShapeError({"painted_charts: ", painted.size(),
                          " texels are painted or not, and a chart has texel ", texel.texel});
    std::erase_if(chart.texels, [&](const ChartTexel& texel) { return painted[texel.texel] == 0; });
    for (TextureChart& piece : detail::connected_pieces(chart)) pieces.push_back(std::move(piece));
  }
  return pieces;
}
}  // namespace tapestry::raster
