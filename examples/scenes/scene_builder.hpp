#pragma once
#include "scene.hpp"

namespace tapestry::scenes {
/// A place on the ground and a heading.
struct Pose {
  double x = 0, y = 0, yaw_rad = 0;

  [[nodiscard]] Point operator()(const Point& local) const {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    return {x + c * local[0] - s * local[1], y + s * local[0] + c * local[1], local[2]};
  }

  [[nodiscard]] Point inverse(const Point& world) const {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    const double dx = world[0] - x, dy = world[1] - y;
    return {c * dx + s * dy, -s * dx + c * dy, world[2]};
  }
};

/// Adds things to a scene and knows which ground is still free and out of the camera's way.
class SceneBuilder {
 public:
  explicit SceneBuilder(Scene& scene) : scene_(scene), eye_(geometry::eye_of(scene.camera)) {}

  [[nodiscard]] const Point& eye() const { return eye_; }

  /// Appends a mesh; returns its first face.
  std::size_t add(const geometry::Mesh& mesh, const std::vector<Colour>& colours, const Pose& pose) {
    const std::size_t first = scene_.mesh.faces.size();
    const auto offset = static_cast<std::int32_t>(scene_.mesh.positions.size());
    for (const Point& position : mesh.positions) scene_.mesh.positions.push_back(pose(position));
    for (const geometry::Corners& face : mesh.faces)
      scene_.mesh.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
    scene_.face_colours.insert(scene_.face_colours.end(), colours.begin(), colours.end());
    return first;
  }

  std::size_t add(const geometry::Mesh& mesh, const Pose& pose) {
    std::vector<Colour> colours;
    colours.reserve(mesh.faces.size());
    for (const std::int32_t material : mesh.face_materials)
      colours.push_back(mesh.materials[static_cast<std::size_t>(material)].colour);
    return add(mesh, colours, pose);
  }

  void label(std::size_t class_index, std::size_t first_face) {
    scene_.objects.push_back({class_index, first_face, scene_.mesh.faces.size()});
  }

  /// True when the ground lies in front of the camera and within its field of view, roughly.
  [[nodiscard]] bool in_view(double x, double y, double radius) const {
    const Point q = geometry::view_from_world(scene_.camera, {x, y, 0.5});
    return q[2] > 1 && std::abs(q[0]) < q[2] * scene_.camera.tan_half_fov_x + radius;
  }

  /// True when a disc touches no object and does not hide the car at the origin.
  [[nodiscard]] bool is_free(double x, double y, double radius) const {
    const double length = std::hypot(eye_[0], eye_[1]);
    const double along = (x * eye_[0] + y * eye_[1]) / (length * length);  // 0 at the car, 1 at the eye
    const double across = std::abs(x * eye_[1] - y * eye_[0]) / length;
    const double ahead = std::clamp(1 - along, 0.0, 1.0);
    if (std::hypot(x, y) < 2.9 + radius) return false;
    if (std::hypot(x - eye_[0], y - eye_[1]) < 1.2 + radius) return false;
    if (along > 0 && along < 1.1 && across < radius + 0.3 + 2.5 * ahead) return false;
    return std::none_of(taken_.begin(), taken_.end(), [&](const std::array<double, 3>& disc) {
      return std::hypot(x - disc[0], y - disc[1]) < radius + disc[2];
    });
  }

  void take(double x, double y, double radius) { taken_.push_back({x, y, radius}); }

  void cast_shadow(Shadow shadow) { scene_.shadows.push_back(std::move(shadow)); }

  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  Scene& scene_;
  Point eye_;
  std::vector<std::array<double, 3>> taken_;  ///< x, y, radius
};
}  // namespace tapestry::scenes
