#include <tapestry/raster/face_charts.hpp>

#include <map>
#include <tapestry/raster/bake.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
/// Triangles, all in the same place: charts do not depend on positions.
geometry::Mesh faces_without_uv(std::size_t count) {
  geometry::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.assign(count, {0, 1, 2});
  mesh.face_materials.assign(count, -1);
  return mesh;
}
}  // namespace

TEST_CASE("no texel belongs to two charts, nor do its neighbours", "[raster][face_charts]") {
  for (const std::size_t count : {1U, 2U, 7U, 200U}) {
    const auto charts = raster::face_charts(faces_without_uv(count));
    REQUIRE(charts.mesh.face_uvs.size() == count);
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> owner;
    for (std::size_t face = 0; face < count; ++face) {
      std::size_t texels = 0;
      raster::for_each_atlas_texel(charts.mesh, charts.layout, face,
                                   [&](std::size_t row, std::size_t column, const auto&) {
                                     ++texels;
                                     CHECK(owner.try_emplace({row, column}, face).second);
                                   });
      CHECK(texels >= 12 * 12 / 2);
    }
  }
}

TEST_CASE("charts of many faces grow smaller, and stay within the atlas", "[raster][face_charts]") {
  const auto charts = raster::face_charts(faces_without_uv(400000));
  CHECK(charts.layout.width <= 4096);
  CHECK(charts.layout.height == charts.layout.width);
  for (const auto& uv : charts.mesh.uvs) {
    const bool is_inside = std::min(uv[0], uv[1]) > 0 && std::max(uv[0], uv[1]) < 1;
    if (!is_inside) FAIL_CHECK("uv " << uv[0] << ", " << uv[1]);
  }
}

TEST_CASE("a mesh without faces has an empty chart", "[raster][face_charts]") {
  const auto charts = raster::face_charts({});
  CHECK(charts.mesh.uvs.empty());
  CHECK(charts.layout.width > 0);
}
