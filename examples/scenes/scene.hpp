#pragma once
#include "car_shape.hpp"
#include "vehicle.hpp"

namespace tapestry::scenes {
/// Classes of the bundled detector.
inline constexpr std::size_t class_car = 0;
inline constexpr std::size_t class_van = 1;
inline constexpr std::size_t class_clutter = 2;  ///< cones, crates, bins

enum class PaintKind { realistic, solid, two_tone, stripes, patches, texel_noise };

/// Options of make_scene(). Ranges are {low, high}, uniform.
struct SceneOptions {
  std::optional<BodyStyle> style;  ///< of the main car; none: any, a van with van_chance
  double van_chance = 0.2;
  std::optional<PaintKind> paint;  ///< of the main car; none: any
  std::optional<Colour> colour;    ///< of the main car's paint, with PaintKind::realistic or solid
  bool varied_shape = true;        ///< stretches the main car by up to 5 %
  std::pair<double, double> azimuth_rad{0, 6.283185307179586};
  double heading_rad = 0;  ///< of the main car in its place, to its left; the camera stays
  std::pair<double, double> elevation_deg{3, 35};
  std::pair<double, double> fov_deg{50, 60};            ///< horizontal
  std::pair<double, double> fill{0.25, 0.75};           ///< width of the main car in the picture
  std::optional<std::pair<double, double>> distance_m;  ///< of the camera, instead of `fill`
  double nearest_m = 4.3;                               ///< least distance by `fill`
  double aim_height_m = 0.7;                            ///< of the point that the camera looks at
  const Vehicle* vehicle = nullptr;                     ///< drawn instead of a car of our own; not owned
  double aspect = 1;                                    ///< width by height of the picture
  double aim_jitter = 0.1;                              ///< of the picture's half width
  double occluder_chance = 0.3;                         ///< of something in front of the main car
  std::size_t most_vehicles = 3;                        ///< beside the main car
  bool has_blocker = false;       ///< whether another vehicle stands between the camera and the main car
  std::size_t most_props = 10;    ///< cones, crates, bins, poles, signs, trees, walls, billboards
  double ground_contrast = 0.08;  ///< of the ground's grain, relative
  double sensor_noise = 0.01;     ///< standard deviation
};

/// Something with a label: a vehicle or a piece of clutter.
struct SceneObject {
  std::size_t class_index;
  std::size_t face_begin, face_end;
};

/// A convex shape on the ground that darkens it. Metres.
struct Shadow {
  struct Side {
    double normal_x, normal_y, offset;  ///< normal·p − offset: how far p lies outside; unit normal
  };
  std::vector<Side> sides;
  std::array<double, 2> centre;
  double reach;     ///< distance from the centre to the shadow's end
  double softness;  ///< distance from the outline to full light
  double depth;     ///< share of the light that is missing inside
};

/// A street with a vehicle at the origin, seen by one camera.
struct Scene {
  geometry::Mesh mesh;               ///< positions and faces only; the main car comes first
  std::vector<Colour> face_colours;  ///< one entry a face
  raster::Light light;
  geometry::Camera camera;
  std::vector<SceneObject> objects;
  std::size_t car_object = 0;  ///< the main car's place in objects
  double heading_rad = 0;      ///< from the world's axes to those of the main car's own frame, about z
  geometry::Mesh car;          ///< the main car alone, with materials and uv
  std::vector<Shadow> shadows;
  std::size_t ground_begin = 0, ground_end = 0;  ///< faces that take shadows and grain
  std::uint32_t grain_seed = 0;
  double ground_contrast = 0;
  Colour zenith{}, horizon{};  ///< of the sky
  Array<float, 3>
      photograph;  ///< [H, W, 3] behind everything instead of the sky, of the picture's extents; or empty
  double sensor_noise = 0;
  std::uint64_t noise_seed = 0;
  std::shared_ptr<const raster::MeshPictures> pictures{};  ///< of the main car's faces; or null
  std::shared_ptr<const CarTexture> texture{};  ///< of the main car; its other faces have their materials'
                                                ///< colours; or null
};

/// A scene's camera and light in the main car's own frame.
struct CarView {
  geometry::Camera camera;
  raster::Light light;

  explicit CarView(const Scene& scene) : camera(scene.camera), light(scene.light) {
    if (scene.heading_rad == 0) return;
    const double c = std::cos(scene.heading_rad), s = std::sin(scene.heading_rad);
    const auto turn = [&](auto& x, auto& y) { std::tie(x, y) = std::pair(c * x + s * y, c * y - s * x); };
    for (auto& row : camera.rotation) turn(row[0], row[1]);
    turn(light.direction[0], light.direction[1]);
  }
};
}  // namespace tapestry::scenes
