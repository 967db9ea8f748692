#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/threads.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3;

TEST_CASE("a half plane that moves gains its edge's length", "[raster][vertex_gradient]") {
  // Its edge stands at column 9.3; the other two are far outside.
  const double x = 9.3 / 8 - 1;
  const Scene<> scene{triangle_soup({{Vector3{x, -30, 1}, Vector3{x, 30, 1}, Vector3{-60, 0, 1}}})};
  auto weights = everywhere(0);
  for (std::size_t i = 0; i < side; ++i) weights(i, 9, 1) = static_cast<double>(i);  // Σ = 120
  const auto gradient = scene.gradient(weights);
  const std::vector<Vector3> right(3, Vector3{1, 0, 0}), down(3, Vector3{0, 1, 0}), away(3, Vector3{0, 0, 1});
  const double colour = scene.texels(0, 1);
  CHECK(along(gradient, right) == Approx(8 * 120 * colour).epsilon(1e-12));
  CHECK(std::abs(along(gradient, down)) <= 1e-9);
  CHECK(along(gradient, away) == Approx(-8 * x * 120 * colour).epsilon(1e-12));  // towards the middle
}

TEST_CASE("the area of a triangle grows with its corners by half the opposite edge",
          "[raster][vertex_gradient]") {
  // At depth 2 a unit spans 4 pixels, so areas in pixels are 16 of the world's.
  const std::array<Vector3, 3> corner{Vector3{-1.3, -0.9, 2}, Vector3{1.1, -0.35, 2}, Vector3{0.2, 1.45, 2}};
  const Scene<> scene{triangle_soup({corner})};
  auto weights = everywhere(0);
  for (std::size_t i = 0; i < side * side; ++i) weights.data()[3 * i] = 1;
  for (const bool is_reversed : {false, true}) {
    Scene<> turned = scene;
    if (is_reversed) std::swap(turned.mesh.faces[0][1], turned.mesh.faces[0][2]);
    const auto gradient = turned.gradient(weights);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 opposite = geometry::subtract(corner[(k + 2) % 3], corner[(k + 1) % 3]);
      CHECK(gradient[k][0] == Approx(-8 * opposite[1] * scene.texels(0, 0)).epsilon(1e-9));
      CHECK(gradient[k][1] == Approx(8 * opposite[0] * scene.texels(0, 0)).epsilon(1e-9));
    }
  }
}

TEST_CASE("hidden faces and a view without the mesh have no gradient", "[raster][vertex_gradient]") {
  const Scene<> scene{
      triangle_soup({{Vector3{-9, -9, 2}, Vector3{30, -9, 2}, Vector3{-9, 30, 2}},
                     {Vector3{-0.5, -0.5, 3}, Vector3{0.5, -0.5, 3}, Vector3{0, 0.5, 3}},
                     {Vector3{-0.5, -0.5, -3}, Vector3{0.5, -0.5, -3}, Vector3{0, 0.5, -3}}})};
  for (const Vector3& value : scene.gradient(smooth_weights())) CHECK(value == Vector3{0, 0, 0});
  for (const Vector3& value : Scene<>{Mesh{}}.gradient(smooth_weights())) CHECK(value == Vector3{0, 0, 0});
}

TEST_CASE("what moves inside a face agrees with central differences of the picture",
          "[raster][vertex_gradient][gradient]") {
  // One face beyond the borders of the picture, tilted; one sample a pixel, so that the picture is smooth.
  Mesh mesh =
      triangle_soup({{Vector3{-9.1, -7.3, 2.13}, Vector3{14.7, -8.2, 4.19}, Vector3{-6.3, 16.1, 3.07}}},
                    {{{0.1, 0.15}, {0.9, 0.2}, {0.3, 0.95}}});
  mesh.normals = {{0, 0.6, -0.8}, {0.6, 0, -0.8}, {-0.6, 0, -0.8}};
  mesh.face_normals = {{0, 1, 2}};
  const auto weights = smooth_weights();
  const auto check = [&](const auto& scene) {
    const auto loss = [&](const auto& at) {
      const auto view = raster::texture_operator<double>(at, Camera{}, side, side, at.light, 1);
      const auto image = raster::render(view, at.texels);
      double sum = 0;
      for (std::size_t i = 0; i < image.size(); ++i) sum += image.data()[i] * weights.data()[i];
      return sum;
    };
    const auto gradient = scene.gradient(weights, raster::InteriorOnly{1});
    const auto whole = scene.gradient(weights, raster::BoundaryIntegral{1});
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const auto motion = random_motion(3, seed);
      const double h = 1e-6;
      const double expected = (loss(moved(scene, motion, h)) - loss(moved(scene, motion, -h))) / (2 * h);
      CHECK(std::abs(along(gradient, motion) - expected) <= 1e-6 * (1 + std::abs(expected)));
      CHECK(std::abs(along(whole, motion) - expected) <= 1e-6 * (1 + std::abs(expected)));
    }
  };
  for (const auto& layout : {vertex, small_atlas, cube, solid}) {
    check(Scene<>{mesh, layout});
    check(Scene<raster::Light>{mesh, layout, warm});
    check(Scene<raster::SmoothLight>{mesh, layout, raster::SmoothLight{warm}});
  }
}

TEST_CASE("seams of duplicated vertices, repeated faces and T-junctions change no sum",
          "[raster][vertex_gradient]") {
  const auto weights = smooth_weights();
  const std::vector<Vector3> steps{{1, 0, 0}, {0, 1, 0}, {0.3, -0.2, 1}};
  const auto whole_motion = [&](const Scene<>& scene, const Vector3& step) {
    return along(scene.gradient(weights), std::vector<Vector3>(scene.mesh.positions.size(), step));
  };
  // The same square as two faces; as two with vertices of their own; each twice; and with a T-junction.
  const Vector3 a{-1.1, -1.2, 2}, b{1.3, -1, 2}, c{1.2, 1.1, 2}, d{-1, 1.4, 2};
  const Vector3 middle = geometry::scale(geometry::add(a, c), 0.5);
  Mesh shared;
  shared.positions = {a, b, c, d};
  shared.faces = {{0, 1, 2}, {0, 2, 3}};
  Mesh repeated = shared;
  repeated.faces = {{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {2, 0, 3}};
  const Scene<> plain{shared};
  for (const Scene<>& other : {Scene<>{triangle_soup({{a, b, c}, {a, c, d}})}, Scene<>{repeated},
                               Scene<>{triangle_soup({{a, b, c}, {a, middle, d}, {middle, c, d}})}}) {
    for (const Vector3& step : steps)
      CHECK(whole_motion(other, step) == Approx(whole_motion(plain, step)).epsilon(1e-9));
  }
  // A seam between two colours: half of its jump to each side's own vertices.
  Scene<> seam{triangle_soup({{a, b, c}, {a, c, d}}), vertex};
  for (std::size_t i = 0; i < 18; ++i) seam.texels.data()[i] = i < 9 ? 0.9 : 0.2;
  Scene<> welded{shared, cube};
  welded.layout.texels_per_edge = 1;
  welded.texels = {{0.9, 0.9, 0.9}, {0.2, 0.2, 0.2}};
  for (const Vector3& step : steps)
    CHECK(whole_motion(seam, step) == Approx(whole_motion(welded, step)).epsilon(1e-9));
}

TEST_CASE("faces without area and corners that are not finite change nothing", "[raster][vertex_gradient]") {
  const Scene<> plain{box(true), vertex};
  Mesh mesh = plain.mesh;
  mesh.positions.push_back({std::nan(""), 0, 2});
  mesh.positions.push_back({0, 0, std::numeric_limits<double>::infinity()});
  mesh.faces.push_back({0, 1, 8});
  mesh.faces.push_back({2, 9, 3});
  mesh.faces.push_back({4, 4, 6});
  mesh.faces.push_back({5, 5, 5});
  Scene<> scene{mesh, vertex};
  std::copy_n(plain.texels.data(), plain.texels.size(), scene.texels.data());
  const auto expected = plain.gradient(smooth_weights()), found = scene.gradient(smooth_weights());
  for (std::size_t i = 0; i < expected.size(); ++i)
    CHECK(geometry::length(geometry::subtract(found[i], expected[i])) <= 1e-9);
  CHECK(found[8] == Vector3{0, 0, 0});
}

TEST_CASE("the gradient has the same bits for any number of threads, and adds", "[raster][vertex_gradient]") {
  const Scene<raster::Light> scene{test::random_triangles(400, 5, 0.4), small_atlas, warm};
  const auto weights = smooth_weights();
  const auto check = [&](const auto& policy) {
    const auto once = same_by_threads({1, 3, 4}, [&] { return scene.gradient(weights, policy); });
    auto twice = once;
    raster::vertex_adjoint(scene.surface(), Camera{}, weights, twice, policy);
    for (std::size_t i = 0; i < once.size(); ++i)
      CHECK(geometry::length(geometry::subtract(twice[i], geometry::scale(once[i], 2))) <= 1e-9);
  };
  check(raster::BoundaryIntegral{});
  check(raster::NeuralMeshRenderer{});
}

TEST_CASE("a view that is drawn once gives picture and gradient the same bits, and no other view is taken",
          "[raster][vertex_gradient][bad_input]") {
  const auto mesh = test::random_triangles(12, 8, 1.2);
  const auto weights = test::smooth_weights();
  for (const auto& layout : {test::vertex, test::cube}) {
    const Scene<raster::Light> scene{mesh, layout, test::warm};
    const auto view = raster::drawn_view(scene, Camera{}, side, side, 4);
    const auto picture = raster::render_textured(scene, view, scene.light, scene.texels);
    const auto expected = raster::render_textured(scene, Camera{}, side, side, scene.light, scene.texels, 4);
    CHECK(picture.colour == expected.colour);
    CHECK(picture.coverage == expected.coverage);
    const auto gradient_of = [&](const auto& policy) {
      std::vector<Vector3> gradient(mesh.positions.size(), Vector3{0, 0, 0});
      raster::vertex_adjoint(scene.surface(), view, weights, gradient, policy);
      return gradient;
    };
    CHECK(gradient_of(raster::BoundaryIntegral{}) == scene.gradient(weights));
    CHECK(gradient_of(raster::InteriorOnly{}) == scene.gradient(weights, raster::InteriorOnly{}));
    CHECK_THROWS_AS(gradient_of(raster::BoundaryIntegral{2}), ShapeError);
    auto moved = scene;
    const auto of_moved = raster::drawn_view(moved, Camera{}, side, side, 4);
    moved.mesh.positions[3][0] += 0.7;
    std::vector<Vector3> sum(mesh.positions.size(), Vector3{0, 0, 0});
    CHECK_THROWS_AS(raster::vertex_adjoint(moved.surface(), of_moved, weights, sum), DomainError);
    CHECK_THROWS_WITH(
        raster::render_textured(moved, of_moved, moved.light, moved.texels),
        contains("render_textured: the view was drawn of another mesh, before its positions moved"));
    auto other = scene;
    other.layout = layout.kind == raster::TextureKind::cube ? test::vertex : test::cube;
    other.texels = tapestry::zeros<double, 2>({raster::stored_texel_count(other.layout, other.mesh), 3});
    CHECK_THROWS_AS(raster::render_textured(other, view, other.light, other.texels), DomainError);
    std::vector<Vector3> gradient(mesh.positions.size());
    const Scene<raster::Light> copy{mesh, layout, test::warm};
    CHECK_THROWS_AS(raster::vertex_adjoint(copy.surface(), view, weights, gradient), ShapeError);
  }
}

TEST_CASE("faces that are seen exactly from their side change nothing", "[raster][vertex_gradient]") {
  Mesh mesh;  // coordinates of few bits, so that the volume of eye and face is 0 to the bit
  mesh.positions = {{-0.875, -0.75, 2}, {0.75, 0.875, 2.25}, {-1.25, 1, 2.5}, {1.25, -0.75, 2.5}};
  mesh.faces = {{0, 1, 2}, {0, 3, 1}};
  const Scene<> plain{mesh, vertex};
  for (const double depth : {0.5, 2.0}) {  // in front of the line and behind it
    Mesh with = mesh;
    with.positions.push_back(geometry::scale(mesh.positions[0], depth));
    with.faces.push_back({0, 1, 4});
    Scene<> scene{with, vertex};
    std::copy_n(plain.texels.data(), plain.texels.size(), scene.texels.data());
    const auto expected = plain.gradient(smooth_weights()), found = scene.gradient(smooth_weights());
    for (std::size_t i = 0; i < expected.size(); ++i)
      CHECK(geometry::length(geometry::subtract(found[i], expected[i])) <= 1e-9);
    CHECK(found[4] == Vector3{0, 0, 0});
  }
}

TEST_CASE("edges that are kept while a mesh moves give the same bits, and no other mesh's are taken",
          "[raster][vertex_gradient]") {
  const Scene<raster::Light> scene{box(false), small_atlas, warm};
  const auto kept = std::make_shared<const raster::MeshEdges>(raster::mesh_edges(scene.mesh));
  const Vector3 step{0.1, -0.05, 0.2};
  const auto weights = smooth_weights();
  for (const double way : {0.0, 1.0}) {
    const auto at = moved(scene, std::vector<Vector3>(scene.mesh.positions.size(), step), way);
    CHECK(at.gradient(weights, raster::BoundaryIntegral{4, true, kept}) == at.gradient(weights));
  }
  const Scene<> other{box(true)};
  CHECK_THROWS_WITH(other.gradient(weights, raster::BoundaryIntegral{4, true, kept}),
                    "vertex_adjoint: edges are those of a mesh of 36 positions and 12 faces, expected 8 "
                    "positions and 12 faces");
}

TEST_CASE("the edges of a mesh say how their two faces run along them", "[raster][vertex_gradient]") {
  // A square of two faces; a third on its diagonal; the same square with a seam; with one face turned.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0.5, 0.5, 1}};
  const auto diagonal = [&](const std::vector<geometry::Corners>& faces) {
    mesh.faces = faces;
    const auto edges = raster::mesh_edges(mesh);
    REQUIRE(edges.way.size() == edges.size());
    std::size_t greatest = 0;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (edges.of(i).size() > edges.of(greatest).size()) greatest = i;
    CHECK(edges.of(greatest).size() == faces.size());
    return static_cast<int>(edges.way[greatest]);
  };
  CHECK(diagonal({{0, 1, 2}, {0, 2, 3}}) == 1);
  CHECK(diagonal({{0, 1, 2}, {2, 0, 3}}) == -1);
  CHECK(diagonal({{0, 1, 2}, {0, 3, 2}}) == -1);
  CHECK(diagonal({{0, 1, 2}, {4, 5, 3}}) == 2);
  CHECK(diagonal({{0, 1, 2}, {4, 2, 3}}) == 2);
  CHECK(diagonal({{0, 1, 2}, {4, 3, 5}}) == -2);
  CHECK(diagonal({{0, 1, 2}, {0, 2, 3}, {0, 2, 6}}) == 0);
  CHECK(diagonal({{0, 1, 2}}) == 0);

  const auto is_closed = [&](const std::vector<geometry::Corners>& faces) {
    mesh.faces = faces;
    return raster::mesh_edges(mesh).is_closed;
  };
  CHECK(is_closed({{0, 1, 2}, {0, 2, 6}, {0, 6, 1}, {1, 6, 2}}));
  CHECK(is_closed({{4, 1, 5}, {0, 2, 6}, {0, 6, 1}, {1, 6, 2}}));
  mesh.positions.insert(mesh.positions.end(), {{7, 7, 7}, {8, 7, 7}, {7, 8, 7}, {7, 7, 8}});
  const auto p = static_cast<std::int32_t>(mesh.positions.size()) - 4;
  CHECK_FALSE(is_closed({{0, 1, 2},
                         {0, 2, 6},
                         {0, 6, 1},
                         {1, 6, 2},  // two pieces
                         {p, p + 1, p + 2},
                         {p, p + 2, p + 3},
                         {p, p + 3, p + 1},
                         {p + 1, p + 3, p + 2}}));
  CHECK_FALSE(is_closed({{0, 1, 2}, {0, 2, 6}, {0, 6, 1}, {1, 2, 6}}));
  CHECK_FALSE(is_closed({{0, 1, 2}, {0, 2, 6}, {0, 6, 1}}));
}

TEST_CASE("Neural Mesh Renderer's rule on one row, worked out by hand", "[raster][vertex_gradient]") {
  // A square of two faces over columns 0 to 7; the loss wants column 10 of row 5 lit, so its adjoint is −1.
  Mesh mesh;
  mesh.positions = {{-3, -3, 1}, {-0.025, -3, 1}, {-0.025, 3, 1}, {-3, 3, 1}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  Scene<> scene{mesh};
  scene.texels = {{0.5, 0.5, 0.5}};
  auto weights = everywhere(0);
  weights(5, 10, 0) = -1;
  const auto gradient = scene.gradient(weights, raster::NeuralMeshRenderer{1});
  // Edge at sample coordinate ½(−0.025·16 + 15) = 7.3; its ends at −16.5 and 31.5, the row at 5. The pixel
  // gains (0 − 0.5)·(−1) = 0.5 at (10 − 7.3)·2/16 = 0.3375, stretched by 48/(31.5 − 5) and 48/(5 + 16.5).
  const double near_end = 0.5 / (48 / 26.5 * 0.3375 + 1e-3), far_end = 0.5 / (48 / 21.5 * 0.3375 + 1e-3);
  CHECK(gradient[1][0] == Approx(-near_end));
  CHECK(gradient[2][0] == Approx(-far_end));
  CHECK(gradient[1][1] == 0);
  CHECK(gradient[0] == Vector3{0, 0, 0});
  CHECK(gradient[3] == Vector3{0, 0, 0});
}

TEST_CASE("vertex_adjoint refuses what does not fit", "[raster][vertex_gradient][bad_input]") {
  const Scene<> scene{box(true), vertex};
  std::vector<Vector3> sum(7);
  CHECK_THROWS_WITH(raster::vertex_adjoint(scene.surface(), Camera{}, everywhere(1), sum),
                    "vertex_adjoint: positions_adjoint is [7], expected [8], one entry a position");
  sum.resize(8);
  CHECK_THROWS_AS(
      raster::vertex_adjoint(scene.surface(), Camera{}, tapestry::zeros<double, 3>({4, 4, 1}), sum),
      ShapeError);
  CHECK_THROWS_AS(
      raster::vertex_adjoint(scene.surface(), Camera{}, everywhere(1), sum, raster::BoundaryIntegral{3}),
      DomainError);
  auto mesh = test::random_triangles(2, 1);
  Scene<> filtered{mesh, raster::atlas_layout(4, 4, 1, raster::TextureFilter::trilinear)};
  sum.resize(6);
  CHECK_THROWS_AS(raster::vertex_adjoint(filtered.surface(), Camera{}, everywhere(1), sum), DomainError);
  Scene<> short_of_texels = scene;
  short_of_texels.texels = tapestry::zeros<double, 2>({3, 3});
  sum.resize(8);
  CHECK_THROWS_AS(raster::vertex_adjoint(short_of_texels.surface(), Camera{}, everywhere(1), sum),
                  ShapeError);
  Scene<raster::Light> broken{box(true), vertex, warm};
  broken.mesh.faces[7][1] = 100000000;
  CHECK_THROWS_WITH(raster::vertex_adjoint(broken.surface(), Camera{}, everywhere(1), sum),
                    "vertex_adjoint: face 7 refers to position 100000000 of 8");
  CHECK_THROWS_AS(
      raster::vertex_adjoint(broken.surface(), Camera{}, everywhere(1), sum, raster::InteriorOnly{}), Error);
  broken.painted.pop_back();
  CHECK_THROWS_WITH(raster::vertex_adjoint(broken.surface(), Camera{}, everywhere(1), sum),
                    "vertex_adjoint: painted is [11], expected [12], one entry a face");
}
