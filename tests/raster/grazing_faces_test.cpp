// Large planes seen nearly edge-on: a line of samples owns all of them or nothing.
#include <tapestry/raster/detail/vertex_gradient/grazing_faces.hpp>

#include "../support/edge_on_scene.hpp"
#include "../support/threads.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Vector3;

TEST_CASE("columns of a picture integrate to the area times the mean colour", "[raster][vertex_gradient]") {
  // At depth 2 a unit spans 4 px: legs of 8 px and 4 px, 16 px², colours 0, 0 and 1 at its corners.
  const auto mesh = test::triangle_soup({{Vector3{-1, -1, 2}, Vector3{1, -1, 2}, Vector3{-1, 0, 2}}});
  const Array<double, 2> colours = {{0, 0, 0}, {0, 0, 0}, {1, 0.5, 0}};
  const auto weights = test::everywhere(1);
  const test::ColumnPicture picture(colours, weights, 64);
  CHECK(picture.loss(mesh, geometry::Camera{}) == Approx(16 * 1.5 / 3).epsilon(1e-4));
}

TEST_CASE("a line keeps the part where a function is not negative", "[raster][vertex_gradient]") {
  using Line = raster::detail::PictureLine;
  const Line column{1, 2.5}, row{0, 3};
  const auto kept = [](const Line& line, const raster::Affine& function) {
    Line::Range range{0, 16};
    line.keep(function, range);
    return std::array{range.begin, range.end};
  };
  CHECK(kept(column, {1, 2, -6}) == std::array{1.75, 16.0});  // 2.5 + 2·row − 6
  CHECK(kept(column, {2, -1, -1}) == std::array{0.0, 4.0});   // 5 − row − 1
  CHECK(kept(row, {1, 2, -7}) == std::array{1.0, 16.0});      // column + 6 − 7
  CHECK(kept(row, {0, 1, -3}) == std::array{0.0, 16.0});
  CHECK(kept(row, {0, 1, -4}) == std::array{16.0, 16.0});
  CHECK(kept(row, {1, 0, -17}) == std::array{16.0, 16.0});
}

// The triangle has legs of 8 px along row 4 and of 4 px down column 4; all borders of the faces that hide it,
// and their crossings with its own, lie between pixels, where sums over lines are exact.
TEST_CASE("the spans of a face have the area of its visible part", "[raster][vertex_gradient]") {
  using Corners = std::array<Vector3, 3>;
  const Corners triangle{Vector3{-1, -1, 2}, Vector3{1, -1, 2}, Vector3{-1, 0, 2}};
  const auto visible_area = [&](const std::vector<Corners>& soup, std::int32_t face, bool is_seen) {
    const auto mesh = test::triangle_soup(soup);
    const geometry::Camera camera;
    const raster::FacesInView faces(mesh, mesh.positions, camera, side, side);
    raster::SeenFaces seen(side, side, 1);
    for (std::size_t pixel = 0; is_seen && pixel < side * side; ++pixel)
      seen.band(0).add(pixel, static_cast<std::int32_t>(soup.size()) - 1);
    raster::FaceField field(faces, seen, camera);
    raster::detail::GrazingSpans spans({face});
    spans.find(field);
    field.fill();
    double area = 0;
    spans.visit(field, 0, [&](const raster::Fragment& fragment) {
      CHECK(fragment.face == face);
      area += fragment.coverage;
    });
    return area;
  };
  const Corners left{Vector3{0, -30, 1}, Vector3{0, 30, 1}, Vector3{-60, 0, 1}};            // to column 8
  const Corners below{Vector3{-30, -0.375, 1}, Vector3{30, -0.375, 1}, Vector3{0, 60, 1}};  // from row 5
  const Corners behind{Vector3{-9, -9, 3}, Vector3{30, -9, 3}, Vector3{-9, 30, 3}};
  CHECK(visible_area({triangle}, 0, false) == Approx(16).epsilon(1e-12));
  for (const bool is_seen : {false, true}) {
    CHECK(visible_area({triangle, left}, 0, is_seen) == Approx(4).epsilon(1e-12));
    CHECK(visible_area({triangle, below}, 0, is_seen) == Approx(7).epsilon(1e-12));
    CHECK(visible_area({triangle, behind}, 0, is_seen) == Approx(16).epsilon(1e-12));
    CHECK(visible_area({triangle, left, below}, 0, is_seen) == Approx(3).epsilon(1e-12));
    CHECK(visible_area({triangle, triangle}, 0, is_seen) == Approx(16).epsilon(1e-12));
    CHECK(visible_area({triangle, triangle}, 1, is_seen) == 0);
  }
}

TEST_CASE("the faces of large planes that are nearly edge-on are found, and no others",
          "[raster][vertex_gradient]") {
  const auto found = [](const geometry::Mesh& mesh, double height, double sample_distance) {
    const auto camera = EdgeOnScene::camera_at(height, std::numbers::pi / 2);
    const auto positions_view = raster::positions_in_view(mesh, camera);
    return raster::detail::grazing_faces(raster::FacesInView(mesh, positions_view, camera, 128, 128),
                                         sample_distance);
  };
  const auto box = test::edge_on_box();
  const std::vector<std::int32_t> bottom{0, 1};
  for (const double height : {0.005, -0.005, -0.1}) CHECK(found(box, height, 0.125) == bottom);
  CHECK(found(box, -0.2, 0.5) == bottom);  // 3.4 px thick
  CHECK(found(box, -0.2, 0.25).empty());
  CHECK(found(box, -0.5, 1).empty());
  CHECK(found(test::bumpy_sphere(3, 0.2, 1), 0, 1).empty());
}

TEST_CASE("a box's bottom nearly edge-on moves as the exact picture does, with any samples",
          "[raster][vertex_gradient][gradient][hard_case][repeated]") {
  const EdgeOnScene scene(test::edge_on_box(), 128);
  for (const double height : {-0.005, -0.02}) {
    CAPTURE(height);
    for (const double error : scene.errors(height, std::numbers::pi / 2, 16)) CHECK(error <= 0.03);
  }
}

TEST_CASE("gradients of planes nearly edge-on are the same for any threads, and in float",
          "[raster][vertex_gradient][hard_case]") {
  const EdgeOnScene scene(test::edge_on_truck(), 48);
  const auto camera = EdgeOnScene::camera_at(-0.123, 1.8);
  const auto gradient = same_by_threads({1, 3}, [&] { return scene.gradient<double>(camera, 4); });
  const auto in_float = scene.gradient<float>(camera, 4);
  const double largest = test::largest_component(gradient);
  for (std::size_t i = 0; i < in_float.size(); ++i)
    CHECK(geometry::length(geometry::subtract(in_float[i], gradient[i])) <= 1e-5 * largest);
}

// The bottom is 3.4 px thick: with 2 x 2 samples it is integrated along lines, with 8 x 8 it is sampled.
TEST_CASE("a light turns planes nearly edge-on as it turns others", "[raster][vertex_gradient][gradient]") {
  const auto camera = EdgeOnScene::camera_at(-0.2, std::numbers::pi / 2);
  const auto weights = test::scoring_weights(128);
  for (const auto& layout : {test::vertex, test::solid}) {
    test::Scene<raster::Light> scene{test::edge_on_box(), layout, {0.3, 0.7, Vector3{0.2, 0.4, -1}}};
    const auto gradient = [&](std::size_t samples) {
      std::vector<Vector3> sum(scene.mesh.positions.size(), Vector3{0, 0, 0});
      raster::vertex_adjoint(scene.surface(), camera, weights, sum, raster::BoundaryIntegral{samples});
      return sum;
    };
    const auto along_lines = gradient(2), sampled = gradient(8);
    const double largest = test::largest_component(sampled);
    for (std::size_t i = 0; i < sampled.size(); ++i)
      CHECK(geometry::length(geometry::subtract(along_lines[i], sampled[i])) <= 0.03 * largest);
  }
}

TEST_CASE("positions shown on a plane nearly edge-on move as the exact picture does",
          "[raster][geometry_picture][gradient][hard_case][repeated]") {
  const EdgeOnScene scene(test::edge_on_box(), 128, EdgeOnScene::Shown::positions);
  for (const double error : scene.errors(-0.005, std::numbers::pi / 2, 16)) CHECK(error <= 0.03);
}
