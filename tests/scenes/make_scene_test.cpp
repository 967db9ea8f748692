#include <tapestry/raster/texture_operator.hpp>

#include "../../examples/scenes/car.hpp"
#include "../../examples/scenes/make_scene.hpp"
#include "../../examples/scenes/picture.hpp"
#include "../support/catch.hpp"

namespace scenes = tapestry::scenes;
using scenes::BodyStyle;

namespace {
tapestry::geometry::Mesh car_of(BodyStyle style) {
  scenes::CarOptions options;
  options.style = style;
  return scenes::make_car(options);
}

/// Twice the signed area of a face in the atlas.
double doubled_area(const tapestry::geometry::Mesh& mesh, std::size_t face, std::array<double, 4>& bounds,
                    std::array<scenes::Uv, 3>& corners) {
  for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
  const auto [left, right] = std::minmax({corners[0][0], corners[1][0], corners[2][0]});
  const auto [low, high] = std::minmax({corners[0][1], corners[1][1], corners[2][1]});
  bounds = {left, right, low, high};
  return (corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
         (corners[1][1] - corners[0][1]) * (corners[2][0] - corners[0][0]);
}

/// How many painted faces lie over each cell's centre of a 2×1 atlas.
std::vector<int> faces_over_atlas(const tapestry::geometry::Mesh& mesh, std::size_t rows) {
  std::vector<int> count(rows * 2 * rows, 0);
  const auto scale = static_cast<double>(rows);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (mesh.face_materials[face] != 0) continue;
    std::array<double, 4> bounds{};
    std::array<scenes::Uv, 3> p{};
    CHECK(doubled_area(mesh, face, bounds, p) > 0);
    for (auto row = static_cast<std::size_t>(bounds[2] * scale); static_cast<double>(row) < bounds[3] * scale;
         ++row)
      for (auto column = static_cast<std::size_t>(bounds[0] * scale);
           static_cast<double>(column) < bounds[1] * scale; ++column) {
        const double u = (static_cast<double>(column) + 0.5017) / scale,
                     v = (static_cast<double>(row) + 0.5031) / scale;
        bool inside = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const auto& a = p[k];
          const auto& b = p[(k + 1) % 3];
          inside = inside && (b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0]) > 0;
        }
        count[row * 2 * rows + column] += inside ? 1 : 0;
      }
  }
  return count;
}
}  // namespace

TEST_CASE("painted faces of every body lie one to one in the 2x1 atlas", "[scenes]") {
  for (const BodyStyle style : {BodyStyle::sedan, BodyStyle::hatchback, BodyStyle::suv, BodyStyle::van}) {
    const auto mesh = car_of(style);
    CHECK(mesh.faces.size() >= 2000);
    CHECK(mesh.faces.size() <= 6000);
    for (const auto& [u, v] : mesh.uvs) CHECK((u >= 0 && u < 2 && v >= 0 && v <= 1));
    const auto count = faces_over_atlas(mesh, 400);
    CHECK(*std::max_element(count.begin(), count.end()) == 1);
    CHECK(std::count(count.begin(), count.end(), 1) > static_cast<std::ptrdiff_t>(count.size() * 2 / 5));
  }
}

TEST_CASE("a body encloses a volume: its faces look outwards", "[scenes]") {
  for (const BodyStyle style : {BodyStyle::sedan, BodyStyle::hatchback, BodyStyle::suv, BodyStyle::van}) {
    const auto mesh = car_of(style);
    double volume = 0;  // divergence theorem
    for (const auto& face : mesh.faces) {
      const auto& a = mesh.positions[static_cast<std::size_t>(face[0])];
      const auto& b = mesh.positions[static_cast<std::size_t>(face[1])];
      const auto& c = mesh.positions[static_cast<std::size_t>(face[2])];
      volume += tapestry::geometry::dot(a, tapestry::geometry::cross(b, c)) / 6;
    }
    CHECK(volume > 4);  // m³
    CHECK(volume < 18);
  }
}

TEST_CASE("a scene follows from its seed and keeps its vehicle at the origin", "[scenes]") {
  scenes::SceneOptions options;
  options.occluder_chance = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    tapestry::Random first(seed), second(seed);
    const auto scene = scenes::make_scene(first, options);
    const auto picture = scenes::draw_scene(scene, 64, 64);
    CHECK(picture.image == scenes::draw_scene(scenes::make_scene(second, options), 64, 64).image);
    CHECK(scene.objects[scene.car_object].face_end == scene.car.faces.size());
    CHECK(scene.face_colours.size() == scene.mesh.faces.size());
    REQUIRE(!picture.boxes.empty());
    CHECK(picture.boxes[0].object == scene.car_object);
    CHECK(picture.boxes[0].visible_share > 0.5);
  }
}

TEST_CASE("a car that is turned in its place leaves the street as it is", "[scenes]") {
  using namespace tapestry::geometry;
  scenes::SceneOptions options;
  tapestry::Random first(4), second(4);
  const auto still = scenes::make_scene(first, options);
  options.heading_rad = 0.7;
  const auto turned = scenes::make_scene(second, options);
  const scenes::CarView seen(turned);
  for (std::size_t i = 0; i < still.mesh.positions.size(); ++i) {
    const auto& place = turned.mesh.positions[i];
    const bool is_car = i < turned.car.positions.size();
    const auto& own = is_car ? turned.car.positions[i] : still.mesh.positions[i];
    const auto& [camera, light] = is_car ? seen : scenes::CarView(still);
    CHECK(length(subtract(view_from_world(camera, own), view_from_world(turned.camera, place))) < 1e-12);
    CHECK(std::abs(dot(light.direction, own) - dot(turned.light.direction, place)) < 1e-12);
  }
}

TEST_CASE("the car rendered into a scene in its own colour is the scene", "[scenes]") {
  scenes::SceneOptions options;
  options.paint = scenes::PaintKind::solid;
  options.colour = scenes::Colour{0.2F, 0.4F, 0.6F};
  options.sensor_noise = 0;
  tapestry::Random random(5);
  const auto scene = scenes::make_scene(random, options);
  const auto picture = scenes::draw_scene(scene, 96, 96);
  const tapestry::raster::TextureLayout layout{tapestry::raster::TextureKind::atlas, 16, 32, 2, 0};
  const auto map = tapestry::raster::texture_operator<float>(
      {scene.car, tapestry::geometry::faces_by_material(scene.car, {"body"}), layout}, scene.camera, 96, 96,
      scene.light);
  tapestry::Array<float, 2> texels(tapestry::Extents<2>{layout.height * layout.width, 3});
  for (std::size_t i = 0; i < texels.size(); ++i) texels.data()[i] = (*options.colour)[i % 3];
  const auto render = tapestry::raster::render(map, texels);
  std::size_t compared = 0;
  for (std::size_t pixel = 0; pixel < picture.car_mask.size(); ++pixel) {
    if (picture.car_mask.data()[pixel] < 1) continue;
    for (std::size_t c = 0; c < 3; ++c)  // a dozen roundings of numbers near 1
      CHECK(std::abs(std::min(render.data()[3 * pixel + c], 1.0F) - picture.image.data()[3 * pixel + c]) <
            1e-5F);
    ++compared;
  }
  CHECK(compared > 100);
}
