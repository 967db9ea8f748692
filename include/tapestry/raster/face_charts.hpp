#pragma once
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::raster {
/// A mesh with a chart of its own for every face, and the layout of an atlas for them. A texture of any kind
/// fits into it, whatever texture coordinates the mesh had.
struct FaceCharts {
  geometry::Mesh mesh;
  TextureLayout layout{};
};

/// Two faces share a square cell of t × t texels, in rows of equal length; t is 16, and less where the atlas
/// would otherwise be wider than 4096 texels. A face takes half of its cell, corners 0 to 2 at
///
///   (1, 1), (t − 3, 1), (1, t − 3)   or, for odd faces, the same points turned by half a turn,
///
/// texels from the cell's lower left corner. So at least two texels lie between any two charts, and lookups
/// of bilinear filters do not mix them. Materials, groups and normals stay.
[[nodiscard]] inline FaceCharts face_charts(geometry::Mesh mesh) {
  constexpr double widest = 4096;
  const auto cells = static_cast<double>((mesh.faces.size() + 1) / 2);
  const auto columns = std::max(1.0, std::ceil(std::sqrt(cells)));
  const double cell = std::clamp(std::floor(widest / columns), 6.0, 16.0);
  const double extent = columns * cell;
  mesh.uvs.clear();
  mesh.face_uvs.clear();
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const auto place = static_cast<double>(face / 2);
    const std::array<double, 2> origin{cell * std::fmod(place, columns), cell * std::floor(place / columns)};
    const auto first = static_cast<std::int32_t>(mesh.uvs.size());
    for (const auto& [x, y] : {std::pair(1.0, 1.0), std::pair(cell - 3, 1.0), std::pair(1.0, cell - 3)}) {
      const bool is_turned = face % 2 == 1;
      mesh.uvs.push_back({(origin[0] + (is_turned ? cell - x : x)) / extent,
                          (origin[1] + (is_turned ? cell - y : y)) / extent});
    }
    mesh.face_uvs.push_back({first, first + 1, first + 2});
  }
  TextureLayout layout{};
  layout.height = layout.width = static_cast<std::size_t>(extent);
  return {std::move(mesh), layout};
}

/// A body with an atlas, as files and viewers need it: itself, or for other kinds of texture one with
/// face_charts(), since the texture coordinates of a mesh may be missing or shared by several faces.
/// Unpainted faces keep texture coordinates into pictures of their own.
[[nodiscard]] inline PaintedMesh with_atlas(PaintedMesh body) {
  if (body.layout.traits().is_picture) return body;
  const geometry::Mesh own = std::move(body.mesh);
  auto charts = face_charts(own);
  body.mesh = std::move(charts.mesh);
  body.layout = charts.layout;
  const auto charted = static_cast<std::int32_t>(body.mesh.uvs.size());
  for (std::size_t face = 0;
       face < std::min({body.painted.size(), own.face_uvs.size(), own.face_materials.size()}); ++face) {
    const std::int32_t material = own.face_materials[face];
    if (body.painted[face] != 0 || material < 0 || std::ranges::min(own.face_uvs[face]) < 0 ||
        own.materials[static_cast<std::size_t>(material)].texture.empty())
      continue;
    if (body.mesh.uvs.size() == static_cast<std::size_t>(charted))
      body.mesh.uvs.insert(body.mesh.uvs.end(), own.uvs.begin(), own.uvs.end());
    body.mesh.face_uvs[face] = own.face_uvs[face];
    for (std::int32_t& corner : body.mesh.face_uvs[face]) corner += charted;
  }
  return body;
}
}  // namespace tapestry::raster
