// Random meshes and cameras against plain loops in double, a transpose and a finer grid.
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/differential.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Mesh, geometry::Vector3;

namespace {
struct RandomView {
  Mesh mesh;
  Camera camera;
  std::size_t height = 1, width = 1, samples = 1;
};

Vector3 random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// A triangle of one of the kinds that go wrong, around a point.
std::array<Vector3, 3> random_triangle(Random& random, const Vector3& eye, const Vector3& centre) {
  constexpr std::array<double, 8> sizes{1e-6, 1e-3, 0.1, 0.3, 0.5, 1, 10, 1e4};
  const double size = sizes[static_cast<std::size_t>(random.uniform(0, 8))];
  std::array<Vector3, 3> corner;
  for (Vector3& point : corner) point = geometry::add(centre, random_vector(random, size));
  const double kind = random.uniform(0, 10);
  const auto between = [](const Vector3& a, const Vector3& b, double t) {
    return geometry::add(geometry::scale(a, 1 - t), geometry::scale(b, t));
  };
  constexpr std::array<double, 5> offs{0, 1e-12, 1e-9, 1e-6, 1e-4};
  const double off = offs[static_cast<std::size_t>(random.uniform(0, 5))];
  if (kind < 1) corner[2] = corner[static_cast<std::size_t>(random.uniform(0, 2))];  // without area
  if (kind >= 1 && kind < 3)  // a needle, or on one line
    corner[2] =
        geometry::add(between(corner[0], corner[1], random.uniform(-1, 2)), random_vector(random, off));
  if (kind >= 3 && kind < 6)  // edge-on: the third corner in the plane of the eye and the others
    corner[2] = geometry::add(
        between(between(corner[0], corner[1], random.uniform(0, 1)), eye, random.uniform(-0.5, 0.5)),
        random_vector(random, off));
  return corner;
}

/// Loose triangles, or a closed mesh with some among them; a few faces twice.
Mesh random_mesh(Random& random, const Vector3& eye) {
  const bool is_closed = random.uniform(0, 1) < 0.4;
  std::vector<std::array<Vector3, 3>> triangles;
  const auto count = static_cast<std::size_t>(random.uniform(1, is_closed ? 6 : 40));
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 centre = random_vector(random, 1);
    triangles.push_back(random_triangle(random, eye, centre));
  }
  if (random.uniform(0, 1) < 0.2) triangles.push_back(triangles.front());
  Mesh mesh = test::triangle_soup(triangles);
  if (!is_closed) return mesh;
  Mesh closed = random.uniform(0, 1) < 0.5
                    ? test::bumpy_sphere(static_cast<std::size_t>(random.uniform(0, 4)), 0.2,
                                         static_cast<std::uint64_t>(random.uniform(0, 1000)))
                    : test::needle_tube(static_cast<std::int32_t>(random.uniform(3, 60)),
                                        static_cast<std::int32_t>(random.uniform(1, 30)), 0.5);
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), closed.positions.begin(), closed.positions.end());
  for (const geometry::Corners& face : closed.faces) {
    mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
    mesh.face_uvs.push_back(mesh.face_uvs.front());
    mesh.face_materials.push_back(-1);
  }
  return mesh;
}

RandomView random_view(std::uint64_t seed) {
  Random random(seed);
  RandomView view;
  const double azimuth = random.uniform(-3, 3), elevation = random.uniform(-1.5, 1.5);
  const double distance = random.uniform(0.3, 6), fov = random.uniform(0.2, 2.4);
  view.camera = geometry::orbit_camera(azimuth, elevation, distance, {0, 0, 0}, fov);
  view.height = static_cast<std::size_t>(random.uniform(4, 40));
  view.width = static_cast<std::size_t>(random.uniform(4, 40));
  view.samples = std::size_t{1} << static_cast<unsigned>(random.uniform(0, 4));
  view.camera.tan_half_fov_y =
      view.camera.tan_half_fov_x * static_cast<double>(view.height) / static_cast<double>(view.width);
  view.mesh = random_mesh(random, geometry::eye_of(view.camera));
  return view;
}

/// A face over the grid of samples, not snapped. Snapping to 1/256 of a sample moves each corner by at most
/// √2/512 = .0028 of one, so that within .01 of an edge a sample may go either way.
class PlainFace {
 public:
  static constexpr double doubtful = 0.01;

  PlainFace(const RandomView& view, std::size_t face) {
    std::array<Vector3, 3> q;
    for (std::size_t k = 0; k < 3; ++k)
      q[k] = view_from_world(view.camera,
                             view.mesh.positions[static_cast<std::size_t>(view.mesh.faces[face][k])]);
    has_no_area_ = q[0] == q[1] || q[1] == q[2] || q[2] == q[0];
    const double step_x = 2 * view.camera.tan_half_fov_x / static_cast<double>(view.width * view.samples);
    const double step_y = 2 * view.camera.tan_half_fov_y / static_cast<double>(view.height * view.samples);
    const double volume = geometry::dot(q[0], geometry::cross(q[1], q[2]));
    double size = 1;
    for (const Vector3& corner : q) size *= geometry::length(corner);
    is_edge_on_ = std::abs(volume) <= 1e-9 * size;
    const auto affine = [&](const Vector3& n) {  // n·ray over samples, from the first one's centre
      return raster::Affine{n[0] * step_x, n[1] * step_y,
                            n[2] + n[0] * (step_x / 2 - view.camera.tan_half_fov_x) +
                                n[1] * (step_y / 2 - view.camera.tan_half_fov_y)};
    };
    Vector3 sum{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 n = geometry::scale(geometry::cross(q[(k + 1) % 3], q[(k + 2) % 3]), volume < 0 ? -1 : 1);
      sum = geometry::add(sum, n);
      edge_[k] = affine(n);
    }
    inverse_depth_ = affine(geometry::scale(sum, 1 / std::abs(volume)));
    limits_ = {1 / view.camera.far, 1 / view.camera.near};
    least_ = most_ = 1 / q[0][2];
    bool is_before = true;
    for (const Vector3& corner : q) {
      is_before = is_before && corner[2] > 0;
      least_ = std::min(least_, 1 / corner[2]);
      most_ = std::max(most_, 1 / corner[2]);
    }
    if (!is_before) {
      least_ = limits_[0];
      most_ = limits_[1];
    }
  }

  [[nodiscard]] bool has_no_area() const { return has_no_area_; }

  /// Least distance to an edge, positive inside, samples.
  [[nodiscard]] double inside(double column, double row) const {
    double least = std::numeric_limits<double>::infinity();
    for (const raster::Affine& edge : edge_) {
      const double steepness = std::hypot(edge.a, edge.b), value = edge.at(column, row);
      if (steepness == 0) continue;
      least = std::min(least, (is_edge_on_ ? -std::abs(value) : value) / steepness);
    }
    return least;
  }

  /// Least and largest 1/z near a sample, as far as rounding and snapping may take it.
  [[nodiscard]] std::array<double, 2> inverse_depths(double column, double row) const {
    if (is_edge_on_) return {least_ * (1 - 1e-5), most_ * (1 + 1e-5)};
    const double value = inverse_depth_.at(column, row);
    const double doubt = doubtful * std::hypot(inverse_depth_.a, inverse_depth_.b) + 1e-5 * std::abs(value);
    return {std::clamp(value - doubt, least_ * (1 - 1e-5), most_),
            std::clamp(value + doubt, least_, most_ * (1 + 1e-5))};
  }

  /// Whether it is there in spite of every doubt.
  [[nodiscard]] bool is_certain(double column, double row) const {
    if (is_edge_on_ || inside(column, row) < doubtful) return false;
    const double value = inverse_depth_.at(column, row);
    const double doubt = doubtful * std::hypot(inverse_depth_.a, inverse_depth_.b) + 1e-5 * std::abs(value);
    return value - doubt > limits_[0] && value + doubt < limits_[1];
  }

 private:
  std::array<raster::Affine, 3> edge_{};  // in order of the opposite corner, ≥ 0 inside
  raster::Affine inverse_depth_{};
  std::array<double, 2> limits_{};
  double least_ = 0, most_ = 0;  // 1/z of the corners
  bool is_edge_on_ = false, has_no_area_ = false;
};

/// Compares the visibility of a view with plain rays; returns the error, or empty text.
std::string wrong_visibility(const RandomView& view) {
  const auto buffer = raster::visibility(view.mesh, view.camera, view.height, view.width, view.samples);
  std::vector<PlainFace> faces;
  for (std::size_t face = 0; face < view.mesh.faces.size(); ++face) faces.emplace_back(view, face);
  const std::size_t columns = view.width * view.samples;
  for (std::size_t i = 0; i < buffer.face.size(); ++i) {
    const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
    double nearest = 0;  // 1/z that something has for certain
    for (const PlainFace& face : faces)
      if (face.is_certain(column, row)) nearest = std::max(nearest, face.inverse_depths(column, row)[0]);
    const std::int32_t shown = buffer.face[i];
    const auto where = [&](const std::string& what) {
      return "visibility: sample (" + std::to_string(i / columns) + ", " + std::to_string(i % columns) +
             ") shows face " + std::to_string(shown) + ", " + what;
    };
    if (shown < 0) {
      if (nearest > 0) return where("a face lies there");
      continue;
    }
    const PlainFace& face = faces[static_cast<std::size_t>(shown)];
    if (face.has_no_area()) return where("which has no area");
    if (face.inside(column, row) < -PlainFace::doubtful) return where("which lies beside it");
    if (face.inverse_depths(column, row)[1] < nearest) return where("which another hides");
  }
  return {};
}

/// ⟨y, A·x⟩ = ⟨Aᵀ·y, x⟩ to rounding, of the picture by its texels.
std::string wrong_transpose(const RandomView& view, std::uint64_t seed) {
  const std::array layouts{test::atlas, test::trilinear, test::anisotropic, test::cube, test::vertex};
  const raster::PaintedMesh body{view.mesh, test::every_face(view.mesh), layouts[seed % layouts.size()]};
  const auto A =
      raster::texture_operator<double>(body, view.camera, view.height, view.width, test::warm, view.samples);
  const auto x = random_array<double>({A.texel_count, 3}, seed);
  const auto y = random_array<double>({view.height, view.width, 3}, seed + 1);
  const auto picture = raster::render(A, x);
  auto gradient = tapestry::zeros<double, 2>({A.texel_count, 3});
  raster::render_adjoint(A, y, gradient);
  double forward = 0, backward = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) forward += y.data()[i] * picture.data()[i];
  for (std::size_t i = 0; i < gradient.size(); ++i) backward += gradient.data()[i] * x.data()[i];
  if (std::abs(forward - backward) <= 1e-12 * (1 + forward)) return {};
  return "transpose: forward " + std::to_string(forward) + ", backward " + std::to_string(backward);
}

/// The view with the eye turned by up to a pixel: moves all samples over all faces.
RandomView turned(RandomView view, Random& random) {
  const double pixel = 2 * view.camera.tan_half_fov_x / static_cast<double>(view.width);
  const double up = random.uniform(-pixel, pixel), aside = random.uniform(-pixel, pixel);
  const std::array<Vector3, 3> turn{
      Vector3{std::cos(aside), 0, std::sin(aside)},
      {std::sin(aside) * std::sin(up), std::cos(up), -std::cos(aside) * std::sin(up)},
      {-std::sin(aside) * std::cos(up), std::sin(up), std::cos(aside) * std::cos(up)}};
  const Camera camera = view.camera;
  for (std::size_t i = 0; i < 3; ++i) {
    view.camera.translation[i] = geometry::dot(turn[i], camera.translation);
    for (std::size_t k = 0; k < 3; ++k)
      view.camera.rotation[i][k] =
          geometry::dot(turn[i], {camera.rotation[0][k], camera.rotation[1][k], camera.rotation[2][k]});
  }
  return view;
}

/// No component of the vertex gradient exceeds three times the largest one of a grid of 8 x 8, or by
/// chance thirty times: a sample that hits a face a tenth of a sample thick counts ten times the face's
/// area, in place of faces that samples miss. Chance leaves the mean over views that differ by less than a
/// pixel; a wrong derivative stays.
std::string wrong_gradient(const RandomView& view, std::uint64_t seed) {
  const auto colours = random_array<double>({view.mesh.positions.size(), 3}, seed);
  const auto weights = random_array<double>({view.height, view.width, 3}, seed + 2, 0.5, 1);
  const raster::PaintedMesh body{view.mesh, test::every_face(view.mesh), test::vertex};
  const raster::Surface<double, raster::Light> surface{body, colours, test::warm};
  const auto add_gradient = [&](const Camera& camera, std::size_t samples, std::vector<Vector3>& sum) {
    raster::vertex_adjoint(surface, camera, weights, sum, raster::BoundaryIntegral{samples});
  };
  std::vector<Vector3> fine(view.mesh.positions.size(), Vector3{0, 0, 0}), coarse = fine;
  // If the fine grid sees only dust, the coarse one may see a pixel of it by chance.
  const double dust = 1e-3;
  Random random(seed);
  double finest = 0, found = 0;
  for (std::size_t views = 0, until = 1; until <= 256; until *= 4) {
    for (; views < until; ++views) {
      const Camera camera = views == 0 ? view.camera : turned(view, random).camera;
      add_gradient(camera, 8, fine);
      add_gradient(camera, view.samples, coarse);
    }
    finest = largest_component(fine) / static_cast<double>(views);
    found = largest_component(coarse) / static_cast<double>(views);
    if (found <= 3 * finest + dust) return {};
    if (!(found <= 30 * finest + dust)) break;
  }
  std::ostringstream text;
  text << "gradient: the largest component is " << found << ", of 8 x 8 samples " << finest;
  return text.str();
}

/// Writes the mesh, and returns how to draw it again.
std::string written(const RandomView& view, std::uint64_t seed) {
  const auto path =
      std::filesystem::temp_directory_path() / ("raster_differential_" + std::to_string(seed) + ".obj");
  io::write_obj(path.string(), view.mesh);
  std::ostringstream line;
  line.precision(17);
  line << "render --mesh " << path.string() << " --size " << view.width << ' ' << view.height << " --samples "
       << view.samples << " --fov " << 360 / std::numbers::pi * std::atan(view.camera.tan_half_fov_x)
       << " --pose";
  for (std::size_t i = 0; i < 3; ++i) {
    for (const double value : view.camera.rotation[i]) line << ' ' << value;
    line << ' ' << view.camera.translation[i];
  }
  return line.str();
}
}  // namespace

TEST_CASE("random views show what plain loops find, transpose, and have no gradient beyond a finer grid's",
          "[raster][hard_case][differential][long]") {
  test::DifferentialRun run("random meshes", 20);
  std::size_t failures = 0;
  while (failures < 5 && run.next()) {
    const RandomView view = random_view(run.seed());
    for (const std::string& problem :
         {wrong_visibility(view), wrong_transpose(view, run.seed()), wrong_gradient(view, run.seed())}) {
      if (problem.empty()) continue;
      ++failures;
      FAIL_CHECK(problem << "\nafter " << run.elapsed() << " s; repeat by " << run.repeat() << "\n"
                         << written(view, run.seed()));
    }
  }
}
