#include <tapestry/raster/geometry_picture.hpp>

#include "../support/finite_difference.hpp"
#include "../support/threads.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3;

namespace {
constexpr std::size_t large = 48;  // pixels, where edges are to be far from each other

template <class Output>
using Picture = Array<double, raster::geometry_rank<Output>>;

template <class Output>
Picture<Output> drawn(const Mesh& mesh, const Camera& camera = {}, std::size_t size = side) {
  return raster::geometry_picture<Output, double>(mesh, camera, size, size);
}

template <class Output>
std::vector<Vector3> gradient_of(const Mesh& mesh, const Picture<Output>& weights, const Camera& camera = {},
                                 std::size_t samples = 4) {
  std::vector<Vector3> gradient(mesh.positions.size(), Vector3{0, 0, 0});
  raster::geometry_picture_adjoint<Output>(mesh, camera, weights, gradient, samples);
  return gradient;
}

template <class Output>
Picture<Output> random_weights(std::size_t size = side) {
  auto weights = drawn<Output>(Mesh{}, {}, size);
  const auto values = test::random_array<double>({weights.size()}, 5, -1);
  std::copy(values.begin(), values.end(), weights.begin());
  return weights;
}

/// A camera whose axis misses the middle of its picture, and which looks at the box from its side.
Camera sheared_camera() {
  Camera camera = geometry::look_at({-1.5, -1.2, 0.4}, {0, 0, 2.2}, {0, 1, 0}, 1.1, 0.9);
  for (std::size_t k = 0; k < 3; ++k) camera.rotation[0][k] += 0.2 * camera.rotation[2][k];
  camera.translation[0] += 0.2 * camera.translation[2];
  return camera;
}

Mesh moved(Mesh mesh, const std::vector<Vector3>& motion, double step) {
  for (std::size_t i = 0; i < motion.size(); ++i)
    mesh.positions[i] = geometry::add(mesh.positions[i], geometry::scale(motion[i], step));
  return mesh;
}

/// ∂⟨weights, picture⟩/∂positions beside central differences of the same samples.
template <class Output>
void check_differences(const Mesh& mesh, const Picture<Output>& weights, const Camera& camera) {
  const auto gradient = gradient_of<Output>(mesh, weights, camera);
  const double step = test::central_difference_step<double>();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto motion = test::random_motion(mesh.positions.size(), seed);
    const auto value = [&](double way) {
      return test::dot(weights, drawn<Output>(moved(mesh, motion, way), camera, large));
    };
    const double expected = (value(step) - value(-step)) / (2 * step);
    CHECK(std::abs(expected) > 1e-3);
    CHECK(std::abs(along(gradient, motion) - expected) <= 1e-6 * (1 + std::abs(expected)));
  }
}

/// Random weights, 0 where a pixel or one beside it shows anything but one face.
template <class Output>
Picture<Output> weights_off_edges(const Mesh& mesh, const Camera& camera) {
  const auto shown = raster::visibility(mesh, camera, 3 * large, 3 * large, 1);
  auto weights = random_weights<Output>(large);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < large * large; ++i) {
    const std::size_t row = i / large, column = i % large;
    const auto face_at = [&](std::size_t down,
                             std::size_t right) {  // 9 x 9 places, from the pixel before on
      return shown.face[(3 * row + down - 3) * 3 * large + 3 * column + right - 3];
    };
    bool keeps = row > 0 && column > 0 && row + 1 < large && column + 1 < large;
    keeps = keeps && face_at(4, 4) >= 0;
    for (std::size_t k = 0; keeps && k < 81; ++k) keeps = face_at(k / 9, k % 9) == face_at(4, 4);
    kept += keeps ? 1 : 0;
    for (std::size_t c = 0; !keeps && c < Output::channel_count; ++c)
      weights.data()[Output::channel_count * i + c] = 0;
  }
  CHECK(kept > 4);
  return weights;
}
}  // namespace

TEST_CASE("depth, position and normal of a tilted plane are those of the rays that meet it",
          "[raster][geometry_picture]") {
  // z = 3 + x/2 − y/4 in front of the whole picture.
  const auto at = [](double x, double y) { return Vector3{x, y, 3 + x / 2 - y / 4}; };
  const auto mesh = test::triangle_soup({{at(-90, -60), at(60, -60), at(-10, 99)}});
  const Vector3 normal = geometry::normalised({0.5, -0.25, -1});  // towards the camera
  const auto depth = drawn<raster::Depth>(mesh);
  const auto position = drawn<raster::SurfacePosition>(mesh), normals = drawn<raster::Normal>(mesh);
  for (std::size_t row = 0; row < side; ++row)
    for (std::size_t column = 0; column < side; ++column) {
      const double x = (static_cast<double>(column) + 0.5) / 8 - 1,
                   y = (static_cast<double>(row) + 0.5) / 8 - 1;
      const double z = 3 / (1 - x / 2 + y / 4);
      CHECK(depth(row, column) == Approx(z).epsilon(1e-12));
      const Vector3 expected{x * z, y * z, z};
      for (std::size_t c = 0; c < 3; ++c) {
        CHECK(position(row, column, c) == Approx(expected[c]).epsilon(1e-11).margin(1e-11));
        CHECK(normals(row, column, c) == Approx(normal[c]).epsilon(1e-12));
      }
    }
}

TEST_CASE("depth, position and normal of a sphere are a ball's, as far as its faces are flat",
          "[raster][geometry_picture]") {
  // Faces of 4 cuts are at most 0.081 wide: corners of one lie within 0.047 of its middle, seen from the
  // centre.
  const auto sphere = geometry::icosphere(4);
  const Vector3 eye{0, -4, 0};
  const auto camera = geometry::look_at(eye, {0, 0, 0}, {0, 0, 1}, 0.5);
  const auto depth = drawn<raster::Depth>(sphere, camera);
  const auto position = drawn<raster::SurfacePosition>(sphere, camera);
  const auto normals = drawn<raster::Normal>(sphere, camera);
  const double half = std::tan(0.25);
  std::size_t compared = 0;
  for (std::size_t row = 0; row < side; ++row)
    for (std::size_t column = 0; column < side; ++column) {
      const double x = half * ((static_cast<double>(column) + 0.5) / 8 - 1);
      const double y = half * ((static_cast<double>(row) + 0.5) / 8 - 1);
      const Vector3 ray = geometry::normalised({x, 1, -y});
      const double b = -geometry::dot(ray, eye), c = 15;
      if (b * b - c < 0.5) continue;  // n·ray above 0.7
      const Vector3 hit = geometry::add(eye, geometry::scale(ray, b - std::sqrt(b * b - c)));
      ++compared;
      CHECK(std::abs(depth(row, column) - (hit[1] + 4)) <= 0.004);
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(std::abs(position(row, column, k) - hit[k]) <= 0.004);
        CHECK(std::abs(normals(row, column, k) - hit[k]) <= 0.05);
      }
    }
  CHECK(compared > 80);
}

TEMPLATE_TEST_CASE("off edges the gradients of pictures of geometry agree with central differences",
                   "[raster][geometry_picture][gradient]", raster::Depth, raster::SurfacePosition,
                   raster::Normal) {
  const Mesh mesh = box(true);
  for (const Camera& camera : {Camera{}, sheared_camera()})
    check_differences<TestType>(mesh, weights_off_edges<TestType>(mesh, camera), camera);
}

TEST_CASE("a half plane that moves takes its depth along, and its edge",
          "[raster][geometry_picture][gradient]") {
  // At depth 2 a unit of the world spans 4 pixels; the edge stands at column 9.3, samples see 0.25 of it.
  const double x = 2 * (9.3 / 8 - 1);
  const auto mesh = test::triangle_soup({{Vector3{x, -60, 2}, Vector3{x, 60, 2}, Vector3{-120, 0, 2}}});
  auto weights = tapestry::zeros<double, 2>({side, side});
  for (std::size_t row = 0; row < side; ++row) weights(row, 9) = static_cast<double>(row);  // Σ = 120
  const auto gradient = gradient_of<raster::Depth>(mesh, weights);
  const auto all = [](const Vector3& way) { return std::vector<Vector3>(3, way); };
  CHECK(along(gradient, all({1, 0, 0})) == Approx(2 * 4 * 120).epsilon(1e-12));
  CHECK(std::abs(along(gradient, all({0, 1, 0}))) <= 1e-9);
  // Farther by dz, the covered part is deeper, and the edge comes in by 8·x/z²·dz columns.
  CHECK(along(gradient, all({0, 0, 1})) == Approx(120 * (0.25 - 2 * 8 * x / 4)).epsilon(1e-12));
}

TEMPLATE_TEST_CASE("pictures of geometry and their gradients have the same bits for any number of threads",
                   "[raster][geometry_picture]", raster::Depth, raster::SurfacePosition, raster::Normal) {
  const auto mesh = test::random_triangles(200, 3, 0.9);
  const std::vector<Vector3> zeros(mesh.positions.size(), Vector3{0, 0, 0});
  const auto drawn_with_gradient = same_by_threads({1, 2, 3}, [&] {
    const auto picture = raster::geometry_picture<TestType, double>(mesh, Camera{}, 90, 70);
    auto gradient = zeros;
    raster::geometry_picture_adjoint<TestType>(mesh, Camera{}, picture, gradient);
    return std::pair(picture, gradient);
  });
  CHECK(drawn_with_gradient.second != zeros);
}

TEMPLATE_TEST_CASE("pictures of geometry in hard cases", "[raster][geometry_picture][bad_input]",
                   raster::Depth, raster::SurfacePosition, raster::Normal) {
  const auto weights = random_weights<TestType>();
  const auto is_finite = [](const Mesh& mesh, const auto& picture, const auto& gradient) {
    return std::all_of(picture.begin(), picture.end(), [](double x) { return std::isfinite(x); }) &&
           std::all_of(gradient.begin(), gradient.end(),
                       [](const auto& x) { return geometry::is_finite(x); }) &&
           gradient.size() == mesh.positions.size();
  };
  const Vector3 none{0, 0, 0};
  SECTION("an empty mesh shows nothing") {
    const auto picture = drawn<TestType>(Mesh{});
    CHECK(std::all_of(picture.begin(), picture.end(), [](double x) { return x == 0; }));
    CHECK(gradient_of<TestType>(Mesh{}, weights).empty());
  }
  SECTION("a face edge-on shows nothing and moves nothing by much") {
    const auto mesh = test::triangle_soup({{Vector3{0, -1, 2}, Vector3{0, 1, 2}, Vector3{0, 0, 5}}});
    const auto picture = drawn<TestType>(mesh);
    CHECK(std::all_of(picture.begin(), picture.end(), [](double x) { return x == 0; }));
    CHECK(is_finite(mesh, picture, gradient_of<TestType>(mesh, weights)));
  }
  SECTION("a face without area beside one with it") {
    const auto mesh = test::triangle_soup({{Vector3{0, 0, 1}, Vector3{0, 0, 1}, Vector3{0, 0, 1}},
                                           {Vector3{-1, -1, 2}, Vector3{1, -1, 2}, Vector3{0, 1, 2}}});
    const auto gradient = gradient_of<TestType>(mesh, weights);
    CHECK(is_finite(mesh, drawn<TestType>(mesh), gradient));
    CHECK(gradient[0] == none);
    CHECK(gradient[3] != none);
  }
  SECTION("a mesh behind the near plane shows nothing") {
    const auto mesh = test::triangle_soup({{Vector3{-1, -1, 0.05}, Vector3{1, -1, 0.05}, Vector3{0, 1, -2}}});
    const auto picture = drawn<TestType>(mesh);
    CHECK(std::all_of(picture.begin(), picture.end(), [](double x) { return x == 0; }));
    CHECK(gradient_of<TestType>(mesh, weights) == std::vector<Vector3>(3, none));
  }
  SECTION("a floor that passes under the camera is cut, and what is left is right") {
    const auto mesh = test::triangle_soup({{Vector3{-90, 1, -9}, Vector3{90, 1, -9}, Vector3{0, 1, 300}}});
    const auto depth = drawn<raster::Depth>(mesh);
    CHECK(depth(side - 1, side / 2) == Approx(16.0 / 15).epsilon(1e-12));  // y = 15/16 of z
    CHECK(is_finite(mesh, drawn<TestType>(mesh), gradient_of<TestType>(mesh, weights)));
  }
  SECTION("a picture of one pixel") {
    const Mesh mesh = box(true);
    const auto picture = raster::geometry_picture<TestType, double>(mesh, Camera{}, 1, 1, 1);
    CHECK(picture.size() == TestType::channel_count);
    auto seed = picture;
    seed.fill(1);
    CHECK(is_finite(mesh, picture, gradient_of<TestType>(mesh, seed, {}, 1)));
  }
  SECTION("a vertex that is not a number leaves out its faces alone") {
    Mesh mesh = box(true);
    mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 1});
    mesh.faces.push_back({0, 1, 8});
    const auto picture = drawn<TestType>(mesh);
    CHECK((picture == drawn<TestType>(box(true))));
    const auto gradient = gradient_of<TestType>(mesh, weights);
    CHECK(is_finite(mesh, picture, gradient));
    CHECK(gradient[8] == none);
  }
}

TEST_CASE("pictures of geometry refuse what does not fit", "[raster][geometry_picture][bad_input]") {
  std::vector<Vector3> gradient(7);
  CHECK_THROWS_WITH(raster::geometry_picture_adjoint<raster::Depth>(
                        box(true), Camera{}, random_weights<raster::Depth>(), gradient),
                    "geometry_picture_adjoint: positions_adjoint is [7], expected [8], one entry a position");
  gradient.resize(8);
  CHECK_THROWS_WITH(raster::geometry_picture_adjoint<raster::Normal>(
                        box(true), Camera{}, tapestry::zeros<double, 3>({4, 4, 2}), gradient),
                    "geometry_picture_adjoint: picture_adjoint is [4, 4, 2], expected [4, 4, 3]");
  CHECK_THROWS_AS((raster::geometry_picture<raster::Depth, double>(box(true), Camera{}, 0, 4)), DomainError);
}
