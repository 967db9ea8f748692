#include "scene_parts.hpp"

#include <map>

#include "paint.hpp"
#include "shadow.hpp"

namespace tapestry::scenes {
double draw(Random& random, const std::pair<double, double>& range) {
  return random.uniform(range.first, range.second);
}

raster::Light any_light(Random& random) {
  const double height = random.uniform(25, 75) * std::numbers::pi / 180;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  raster::Light light;
  light.direction = {std::cos(height) * std::cos(azimuth), std::cos(height) * std::sin(azimuth),
                     std::sin(height)};
  const double exposure = random.uniform(0.75, 1.15), share = random.uniform(0.15, 0.6);
  light.directional = exposure * share / light.direction[2];
  light.ambient = exposure * (1 - share);
  const double warmth = 0.06 * random.normal();
  light.colour = {1 + std::clamp(warmth, -0.12, 0.12), 1 + random.uniform(-0.02, 0.02),
                  1 - std::clamp(warmth, -0.12, 0.12)};
  return light;
}

namespace {
/// Makes these the colours of the mesh's materials, one entry a face.
void set_materials(geometry::Mesh& mesh, const std::vector<Colour>& colours) {
  std::map<Colour, std::int32_t> places;
  mesh.materials.clear();
  mesh.face_materials.clear();
  for (const Colour& colour : colours) {
    const auto place = static_cast<std::int32_t>(mesh.materials.size());
    const auto [known, is_new] = places.try_emplace(colour, place);
    if (is_new) mesh.materials.push_back({"", colour});
    mesh.face_materials.push_back(known->second);
  }
}
}  // namespace

void add_vehicle(SceneBuilder& builder, Scene& scene, const SceneOptions& options, Random& random) {
  const Vehicle& vehicle = *options.vehicle;
  const Colour colour = options.colour.value_or(car_colour(random));
  std::vector<Colour> colours;
  for (std::size_t face = 0; face < vehicle.painted.size(); ++face)
    colours.push_back(vehicle.painted[face] != 0 ? colour : geometry::material_colour(vehicle.mesh, face));
  scene.pictures = vehicle.pictures;
  if (scene.pictures) set_materials(scene.car, colours);
  scene.car_object = scene.objects.size();
  const Pose pose{0, 0, scene.heading_rad};
  builder.label(class_car, builder.add(scene.car, colours, pose));
  cast_shadows(builder, scene.car.positions, pose, 0.6);
}

void fill_attributes(geometry::Mesh& mesh) {
  mesh.face_uvs.assign(mesh.faces.size(), {-1, -1, -1});
  mesh.face_normals.assign(mesh.faces.size(), {-1, -1, -1});
  mesh.face_materials.assign(mesh.faces.size(), -1);
  mesh.face_groups.assign(mesh.faces.size(), -1);
}
}  // namespace tapestry::scenes
