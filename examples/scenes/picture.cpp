#include "picture.hpp"

#include <tapestry/core/random.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "shadow.hpp"

namespace tapestry::scenes {
namespace detail {
/// A well mixed value in [0, 1) for one corner of the integer lattice.
[[nodiscard]] inline float lattice_value(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^
                    static_cast<std::uint32_t>(y) * 0xD8163841U ^ seed * 0x9E3779B9U;
  h = (h ^ (h >> 16U)) * 0x7FEB352DU;
  h = (h ^ (h >> 15U)) * 0x846CA68BU;
  return static_cast<float>((h ^ (h >> 16U)) >> 8U) * 0x1.0p-24F;
}

[[nodiscard]] inline float eased(double t) { return static_cast<float>(t * t * (3 - 2 * t)); }
}  // namespace detail

/// Smooth noise in the plane, in [0, 1], one lattice cell a unit of x and y.
[[nodiscard]] inline float lattice_noise(double x, double y, std::uint32_t seed) {
  const double floor_x = std::floor(x), floor_y = std::floor(y);
  const auto ix = static_cast<std::int32_t>(floor_x), iy = static_cast<std::int32_t>(floor_y);
  const float u = detail::eased(x - floor_x), v = detail::eased(y - floor_y);
  const auto along_x = [&](std::int32_t row) {
    const float left = detail::lattice_value(ix, row, seed);
    return left + (detail::lattice_value(ix + 1, row, seed) - left) * u;
  };
  const float low = along_x(iy);
  return low + (along_x(iy + 1) - low) * v;
}

namespace {
Colour sky_colour(const Scene& scene, const Point& ray) {
  const double up = std::clamp(ray[2] / geometry::length(ray) * 2.2, 0.0, 1.0);
  const double t = std::sqrt(up);
  Colour colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = scene.horizon[c] + (scene.zenith[c] - scene.horizon[c]) * static_cast<float>(t);
  return colour;
}

/// Factor of the ground's colour where a ray meets z = 0: shadows times grain. Grain finer than a
/// pixel is faded out.
float ground_factor(const Scene& scene, const Point& eye, const Point& ray, double pixel_angle) {
  const double distance = ray[2] < -1e-4 ? -eye[2] / ray[2] : 1e4;
  if (distance > 150) return 1;
  const double x = eye[0] + distance * ray[0], y = eye[1] + distance * ray[1];
  const double footprint = distance * pixel_angle;
  double grain = 0;
  for (const double cell : {0.12, 0.6, 3.5}) {
    const double weight = std::clamp(cell / footprint - 0.8, 0.0, 1.0);
    if (weight > 0)
      grain += weight * (static_cast<double>(lattice_noise(x / cell, y / cell, scene.grain_seed)) - 0.5);
  }
  return static_cast<float>(light_share(scene.shadows, x, y) * (1 + 2 * scene.ground_contrast * grain));
}

/// Colours of a picture's parts before composition.
class Shader {
 public:
  Shader(const Scene& scene, std::size_t height, std::size_t width)
      : scene_(scene), height_(height), width_(width), eye_(geometry::eye_of(scene.camera)) {
    const std::vector<double> lights = raster::face_light(scene.mesh, scene.camera, scene.light);
    lit_ = scene.face_colours;
    for (std::size_t face = 0; face < lit_.size(); ++face)
      for (std::size_t c = 0; c < 3; ++c)
        lit_[face][c] *= static_cast<float>(lights[face] * scene.light.colour[c]);
    pixel_angle_ = 2 * scene.camera.tan_half_fov_x / static_cast<double>(width);
    if (scene.texture || scene.pictures) paint_car();
  }

  /// Sum of the colours of one pixel's samples.
  /// \param samples  the faces of the pixel's samples
  [[nodiscard]] Colour operator()(const std::array<std::int32_t, 4>& samples, std::size_t row,
                                  std::size_t column) const {
    Colour sum{};
    float ground = -1;
    Colour sky{-1, 0, 0};
    for (const std::int32_t sample : samples) {
      const auto face = static_cast<std::size_t>(sample);
      Colour colour{};
      if (sample < 0) {
        if (sky[0] < 0) sky = background(row, column);
        colour = sky;
      } else if (face < textured_faces_) {
        colour = texture_colour(row, column, face);
      } else {
        colour = lit_[face];
        if (face >= scene_.ground_begin && face < scene_.ground_end) {
          if (ground < 0) ground = ground_factor(scene_, eye_, ray(row, column), pixel_angle_);
          for (float& channel : colour) channel *= ground;
        }
      }
      for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c];
    }
    return sum;
  }

 private:
  [[nodiscard]] Colour background(std::size_t row, std::size_t column) const {
    const Point direction = ray(row, column);
    if (scene_.photograph.size() == 0) return sky_colour(scene_, direction);
    const float share = ground_factor(scene_, eye_, direction, pixel_angle_);  // a shadow on its ground
    Colour colour{};
    for (std::size_t c = 0; c < 3; ++c) colour[c] = scene_.photograph(row, column, c) * share;
    return colour;
  }

  /// Direction of the ray through a pixel's centre, in the world, z of view space being 1.
  [[nodiscard]] Point ray(std::size_t row, std::size_t column) const {
    const auto place = [](std::size_t pixel, std::size_t count) {
      return 2 * (static_cast<double>(pixel) + 0.5) / static_cast<double>(count) - 1;
    };
    const geometry::Camera& camera = scene_.camera;
    return geometry::multiply_transposed(camera.rotation, {place(column, width_) * camera.tan_half_fov_x,
                                                           place(row, height_) * camera.tan_half_fov_y, 1});
  }

  void paint_car() {
    raster::PaintedMesh body{scene_.car, std::vector<std::uint8_t>(scene_.car.faces.size(), 0),
                             raster::solid_layout};
    body.pictures = scene_.pictures;
    auto texels = zeros<float, 2>({1, 3});
    if (const auto& texture = scene_.texture) {
      body.painted = texture->faces;
      body.layout = texture->layout;
      texels = texture->texels;
    }
    const CarView seen(scene_);
    const auto map = raster::texture_operator<float>(body, seen.camera, height_, width_, seen.light);
    texture_ = raster::render(map, texels);
    texture_coverage_ = map.coverage;
    textured_faces_ = scene_.car.faces.size();  // the main car comes first
  }

  /// The textured car's mean colour in a pixel.
  [[nodiscard]] Colour texture_colour(std::size_t row, std::size_t column, std::size_t face) const {
    const float coverage = texture_coverage_(row, column);
    if (!(coverage > 0)) return lit_[face];
    return {texture_(row, column, 0) / coverage, texture_(row, column, 1) / coverage,
            texture_(row, column, 2) / coverage};
  }

  const Scene& scene_;
  std::size_t height_, width_;
  Point eye_;
  std::vector<Colour> lit_;
  double pixel_angle_ = 0;
  Array<float, 3> texture_;
  Array<float, 2> texture_coverage_;
  std::size_t textured_faces_ = 0;
};

/// Mean 0, variance 1: the sum of four uniform numbers of 16 bits each.
double nearly_normal(Random& random) {
  const std::uint64_t bits = random.bits();
  const std::uint64_t sum =
      (bits & 0xFFFFU) + (bits >> 16U & 0xFFFFU) + (bits >> 32U & 0xFFFFU) + (bits >> 48U);
  return (static_cast<double>(sum) * 0x1.0p-16 - 2) * 1.7320508;
}

/// Area in the picture of the faces turned to the camera; pixels².
double turned_area(const Scene& scene, const SceneObject& object, double height, double width) {
  double area = 0;
  for (std::size_t face = object.face_begin; face < object.face_end; ++face) {
    std::array<std::array<double, 2>, 3> p{};
    bool in_front = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(scene.mesh.faces[face][k]);
      const Point q = geometry::view_from_world(scene.camera, scene.mesh.positions[corner]);
      in_front = in_front && q[2] > scene.camera.near;
      p[k] = geometry::picture_from_view(scene.camera, q, height, width);
    }
    // Rows grow downwards: counter-clockwise outside is negative here.
    const double doubled =
        (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]) - (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]);
    if (in_front && doubled > 0) area += doubled / 2;
  }
  return area;
}

std::vector<PictureBox> find_boxes(const Scene& scene, const raster::VisibilityBuffer& buffer) {
  std::vector<std::int32_t> object_of(scene.mesh.faces.size(), -1);
  constexpr double far = std::numeric_limits<double>::max();
  std::vector<PictureBox> found(scene.objects.size());
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    const SceneObject& source = scene.objects[object];
    std::fill(object_of.begin() + static_cast<std::ptrdiff_t>(source.face_begin),
              object_of.begin() + static_cast<std::ptrdiff_t>(source.face_end),
              static_cast<std::int32_t>(object));
    found[object] = {source.class_index, object, far, far, 0, 0, 0, 0};
  }
  const std::size_t axis = buffer.samples_per_axis, columns = buffer.width * axis;
  for (std::size_t sample = 0; sample < buffer.face.size(); ++sample) {
    if (buffer.face[sample] < 0) continue;
    const std::int32_t object = object_of[static_cast<std::size_t>(buffer.face[sample])];
    if (object < 0) continue;
    PictureBox& box = found[static_cast<std::size_t>(object)];
    const auto row = static_cast<double>(sample / columns / axis),
               column = static_cast<double>(sample % columns / axis);
    box.left = std::min(box.left, column);
    box.right = std::max(box.right, column + 1);
    box.top = std::min(box.top, row);
    box.bottom = std::max(box.bottom, row + 1);
    ++box.visible_samples;
  }
  std::erase_if(found, [](const PictureBox& box) { return box.visible_samples == 0; });
  for (PictureBox& box : found) {
    const double area = turned_area(scene, scene.objects[box.object], static_cast<double>(buffer.height),
                                    static_cast<double>(buffer.width));
    box.visible_share = std::min(1.0, static_cast<double>(box.visible_samples) /
                                          static_cast<double>(axis * axis) / std::max(area, 1e-9));
  }
  return found;
}
}  // namespace

Picture draw_scene(const Scene& scene, std::size_t height, std::size_t width) {
  const raster::VisibilityBuffer buffer = raster::visibility(scene.mesh, scene.camera, height, width, 2);
  const Shader shader(scene, height, width);
  Picture picture;
  picture.image = Array<float, 3>(Extents<3>{height, width, 3});
  Random noise(scene.noise_seed);
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column) {
      const std::int32_t* const first = buffer.face.data() + 4 * row * width + 2 * column;
      const std::array<std::int32_t, 4> samples{first[0], first[1], first[2 * width], first[2 * width + 1]};
      const Colour sum = shader(samples, row, column);
      for (std::size_t c = 0; c < 3; ++c) {
        float value = sum[c] / 4;
        if (scene.sensor_noise > 0) value += static_cast<float>(scene.sensor_noise * nearly_normal(noise));
        picture.image(row, column, c) = std::clamp(value, 0.0F, 1.0F);
      }
    }
  const SceneObject& car = scene.objects[scene.car_object];
  picture.car_mask = raster::coverage_of(buffer, [&](std::int32_t face) {
    return static_cast<std::size_t>(face) >= car.face_begin && static_cast<std::size_t>(face) < car.face_end;
  });
  picture.boxes = find_boxes(scene, buffer);
  return picture;
}
}  // namespace tapestry::scenes
