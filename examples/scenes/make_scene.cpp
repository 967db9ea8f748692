#include "make_scene.hpp"

#include "car.hpp"
#include "scene_parts.hpp"
#include "shadow.hpp"
#include "street.hpp"

namespace tapestry::scenes {
namespace {
BodyStyle any_style(Random& random, double van_chance) {
  static constexpr std::array<BodyStyle, 3> cars{BodyStyle::sedan, BodyStyle::hatchback, BodyStyle::suv};
  return random.chance(van_chance) ? BodyStyle::van : cars[random.index(cars.size())];
}

/// Width of a mesh in the picture, in shares of the picture.
/// \param nearest smallest depth that a point counts with
double width_in_picture(const geometry::Mesh& mesh, const geometry::Camera& camera, double nearest) {
  double low = 1e9, high = -1e9;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 5) {
    const Point q = geometry::view_from_world(camera, mesh.positions[i]);
    const double column = q[0] / (std::max(q[2], nearest) * camera.tan_half_fov_x) / 2;
    low = std::min(low, column);
    high = std::max(high, column);
  }
  return high - low;
}

/// Looks at the car from around it, so far away that it has the wished width in the picture.
geometry::Camera any_camera(Random& random, const SceneOptions& options, const geometry::Mesh& car) {
  const double azimuth = draw(random, options.azimuth_rad);
  const double elevation = draw(random, options.elevation_deg) * std::numbers::pi / 180;
  const double fov = draw(random, options.fov_deg) * std::numbers::pi / 180;
  const double fill = draw(random, options.fill);
  const std::array<double, 2> jitter{random.uniform(-1, 1) * options.aim_jitter,
                                     random.uniform(-1, 1) * options.aim_jitter};
  double distance = options.distance_m ? draw(random, *options.distance_m) : 8;
  geometry::Camera camera;
  for (int pass = 0; pass < 4 && !options.distance_m; ++pass) {
    camera = geometry::orbit_camera(azimuth, elevation, distance, {0, 0, options.aim_height_m}, fov);
    const double width = width_in_picture(car, camera, std::min(0.3, options.nearest_m / 4));
    distance = std::clamp(distance * width / fill, options.nearest_m, 40.0);
  }
  const double reach = distance * camera.tan_half_fov_x;
  const Point target{-std::sin(azimuth) * jitter[0] * reach, std::cos(azimuth) * jitter[0] * reach,
                     options.aim_height_m + 0.6 * jitter[1] * reach};
  camera = geometry::orbit_camera(azimuth, elevation, distance, target, fov);
  camera.tan_half_fov_y = camera.tan_half_fov_x / options.aspect;
  return camera;
}

/// Points whose shadow stands for a vehicle's.
std::vector<Point> shadow_solid(const CarShape& shape, const std::array<double, 3>& stretch) {
  std::vector<Point> points;
  const auto ring = [&](double x, double y, double z) {
    for (const double side : {-y, y}) points.push_back({x * stretch[0], side * stretch[1], z * stretch[2]});
  };
  for (const double z : {0.05, 0.6}) {
    ring(shape.front - 0.1, 0.6, z);
    ring(shape.front - 0.5, 0.82, z);
    ring(shape.rear + 0.4, 0.84, z);
    ring(shape.rear + 0.05, 0.65, z);
  }
  const double roof_front = shape.windscreen.first - 0.1, roof_rear = shape.rear_window.second + 0.1;
  for (const double x : {roof_front, roof_rear}) ring(x, shape.top_half_width(x), shape.top(x));
  return points;
}

void add_main_car(SceneBuilder& builder, Scene& scene, const SceneOptions& options, const CarOptions& car,
                  Random& random) {
  const PaintKind kind = options.paint.value_or(any_paint(random));
  std::vector<Colour> colours = paint_faces(random, scene.car, kind);
  if (options.colour)
    for (std::size_t face = 0; face < colours.size(); ++face)
      if (scene.car.face_materials[face] == 0) colours[face] = *options.colour;
  if (kind == PaintKind::texel_noise) {
    const std::size_t height = std::size_t{32} << random.index(4);
    scene.texture = std::make_shared<const CarTexture>(
        CarTexture{geometry::faces_by_material(scene.car, {"body"}),
                   raster::atlas_layout(height, 2 * height, 2), random_texels(random, height, 2 * height)});
  }
  scene.car_object = scene.objects.size();
  builder.label(car.style == BodyStyle::van ? class_van : class_car,
                builder.add(scene.car, colours, {0, 0, scene.heading_rad}));
  cast_shadows(builder, shadow_solid(car_shape(car.style), car.stretch), {0, 0, scene.heading_rad}, 0.6);
}

void place_vehicle(SceneBuilder& builder, const Pose& pose, Random& random) {
  CarOptions car;
  car.style = any_style(random, 0.35);
  car.spacing = 0.26;
  const geometry::Mesh mesh = make_car(car);
  const PaintKind kind = random.chance(0.7) ? PaintKind::realistic : any_paint(random);
  const std::size_t first = builder.add(mesh, paint_faces(random, mesh, kind), pose);
  builder.label(car.style == BodyStyle::van ? class_van : class_car, first);
  cast_shadows(builder, shadow_solid(car_shape(car.style), car.stretch), pose, 0.6);
  builder.take(pose.x, pose.y, 2.4);
}

/// Other vehicles, along the lanes or, in a car park, across.
void add_vehicles(SceneBuilder& builder, const StreetPlan& plan, const SceneOptions& options,
                  Random& random) {
  const std::size_t count = random.index(options.most_vehicles + 1);
  for (std::size_t vehicle = 0; vehicle < count; ++vehicle)
    for (int attempt = 0; attempt < 12; ++attempt) {
      const double along = random.uniform(-28, 28);
      const double across = random.uniform(-1, 1) * (plan.half_width - 1.1);
      const Point place = plan.pose({along, across, 0});
      double heading = 0.06 * random.normal();
      if (random.chance(0.5)) heading += std::numbers::pi;
      if (plan.half_width > 8 && random.chance(0.5)) heading += std::numbers::pi / 2;
      if (!builder.in_view(place[0], place[1], 0) || !builder.is_free(place[0], place[1], 2.4)) continue;
      place_vehicle(builder, {place[0], place[1], plan.pose.yaw_rad + heading}, random);
      break;
    }
}

void place_prop(SceneBuilder& builder, const Prop& prop, const Pose& pose) {
  const std::size_t first = builder.add(prop.mesh, pose);
  if (prop.is_clutter) builder.label(class_clutter, first);
  builder.take(pose.x, pose.y, prop.radius + 0.1);
  if (!(prop.shadow_height > 0)) return;
  const double r = 0.8 * prop.radius;
  std::vector<Point> solid;
  for (const double z : {0.0, prop.shadow_height})
    for (const double x : {-r, r})
      for (const double y : {-r, r}) solid.push_back({x * (z > 0 ? 0.6 : 1), y * (z > 0 ? 0.6 : 1), z});
  cast_shadows(builder, solid, pose, 0.35);
}

void add_props(SceneBuilder& builder, const StreetPlan& plan, const SceneOptions& options, Random& random) {
  const std::size_t count = random.index(options.most_props + 1);
  const Point eye = builder.eye();
  const double towards = std::atan2(-eye[1], -eye[0]);
  const double spread = std::atan(builder.scene().camera.tan_half_fov_x);
  for (std::size_t i = 0; i < count; ++i)
    for (int attempt = 0; attempt < 6; ++attempt) {
      const double angle = towards + random.uniform(-1, 1) * spread,
                   range = 3 + 27 * std::pow(random.uniform(), 1.3);
      const double x = eye[0] + range * std::cos(angle), y = eye[1] + range * std::sin(angle);
      const bool on_road = std::abs(plan.pose.inverse({x, y, 0})[1]) < plan.half_width;
      if (!builder.is_free(x, y, 0.7)) continue;
      const Prop prop = any_prop(random, !on_road);
      if (!builder.is_free(x, y, prop.radius)) continue;
      place_prop(builder, prop, {x, y, random.uniform(0, 2 * std::numbers::pi)});
      break;
    }
}

/// Something narrow between the camera and the car.
void add_occluder(SceneBuilder& builder, Random& random) {
  const Point eye = builder.eye();
  const double length = std::hypot(eye[0], eye[1]);
  const double range = 2.9 + random.uniform(0, 0.45) * std::max(0.0, length - 4.5);
  const double side = random.uniform(-1.7, 1.7) * (1 - range / length);
  const Pose pose{(eye[0] * range - eye[1] * side) / length, (eye[1] * range + eye[0] * side) / length,
                  random.uniform(0, 2 * std::numbers::pi)};
  for (int attempt = 0; attempt < 20; ++attempt) {
    const Prop prop = any_prop(random, random.chance(0.15));
    if (prop.radius * length / (length - range) > 0.8) continue;  // its width as seen at the car
    return place_prop(builder, prop, pose);
  }
}

/// A vehicle between the camera and the car, along it or across.
void add_blocker(SceneBuilder& builder, const geometry::Mesh& car, Random& random) {
  constexpr double half_length_m = 2.3, half_width_m = 1, gap_m = 0.4;  // of the blocker
  const auto bounds = geometry::bounds_of(car.positions);
  const Point eye = builder.eye();
  const double away = std::hypot(eye[0], eye[1]);
  for (int attempt = 0; attempt < 100; ++attempt) {
    const double range = random.uniform(2 * half_width_m, away - half_width_m);
    const double side = random.uniform(-2, 2) * half_length_m * (1 - range / away);
    const std::size_t quarter = random.index(4);
    const Pose pose{(eye[0] * range - eye[1] * side) / away, (eye[1] * range + eye[0] * side) / away,
                    std::numbers::pi / 2 * static_cast<double>(quarter) + 0.06 * random.normal()};
    const bool is_along = quarter % 2 == 0;
    const double apart_x = bounds.high[0] + (is_along ? half_length_m : half_width_m) + gap_m;
    const double apart_y = bounds.high[1] + (is_along ? half_width_m : half_length_m) + gap_m;
    const Point seen = pose.inverse(eye);
    const bool is_clear =
        std::abs(seen[0]) > half_length_m + gap_m || std::abs(seen[1]) > half_width_m + gap_m;
    if (is_clear && (std::abs(pose.x) > apart_x || std::abs(pose.y) > apart_y))
      return place_vehicle(builder, pose, random);
  }
}

void set_sky(Scene& scene, Random& random) {
  const double level = (scene.light.ambient + scene.light.directional) * 0.85;
  const bool overcast = random.chance(0.4);
  scene.zenith = overcast ? Colour{0.70F, 0.72F, 0.75F} : varied(random, {0.36F, 0.55F, 0.85F}, 0.1);
  scene.horizon = overcast ? Colour{0.82F, 0.83F, 0.84F} : varied(random, {0.78F, 0.85F, 0.92F}, 0.06);
  if (!overcast && random.chance(0.15)) scene.horizon = varied(random, {0.92F, 0.70F, 0.50F}, 0.08);
  scene.zenith = scaled(scene.zenith, level);
  scene.horizon = scaled(scene.horizon, level);
}
}  // namespace

Scene make_scene(Random& random, const SceneOptions& options) {
  Scene scene;
  CarOptions car;
  car.style = options.style.value_or(any_style(random, options.van_chance));
  if (options.varied_shape)
    for (double& stretch : car.stretch) stretch = random.uniform(0.95, 1.05);
  scene.car = options.vehicle != nullptr ? options.vehicle->mesh : make_car(car);
  scene.light = any_light(random);
  scene.camera = any_camera(random, options, scene.car);
  scene.heading_rad = options.heading_rad;
  scene.ground_contrast = options.ground_contrast * random.uniform(0.3, 1);
  scene.sensor_noise = options.sensor_noise;
  scene.grain_seed = static_cast<std::uint32_t>(random.bits());
  scene.noise_seed = random.bits();
  set_sky(scene, random);

  SceneBuilder builder(scene);
  if (options.vehicle != nullptr)
    add_vehicle(builder, scene, options, random);
  else
    add_main_car(builder, scene, options, car, random);
  const StreetPlan plan = make_street(random);
  add_ground(builder, plan, random, scene.ground_begin, scene.ground_end);
  if (options.has_blocker) add_blocker(builder, scene.car, random);
  add_vehicles(builder, plan, options, random);
  if (random.chance(options.occluder_chance)) add_occluder(builder, random);
  add_props(builder, plan, options, random);
  if (random.chance(0.8)) add_buildings(builder, plan, random);
  if (random.chance(0.8)) add_skyline(builder, scene.horizon, random);
  fill_attributes(scene.mesh);
  return scene;
}
}  // namespace tapestry::scenes
