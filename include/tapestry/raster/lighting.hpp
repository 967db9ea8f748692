#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/raster/light.hpp>

namespace tapestry::raster {
/// Nine numbers, one for each real spherical harmonic up to order 2, in the order (l, m) = (0, 0), (1, −1),
/// (1, 0), (1, 1), (2, −2) … (2, 2).
using Harmonics = std::array<double, 9>;

/// The spherical harmonics Y_lm at a direction of length 1, orthonormal over the sphere; z is the axis.
[[nodiscard]] inline Harmonics spherical_harmonics(const geometry::Vector3& direction) {
  const auto& [x, y, z] = direction;
  const double pi = std::numbers::pi;
  const double first = std::sqrt(3 / (4 * pi)), second = std::sqrt(15 / (4 * pi));
  return {std::sqrt(1 / (4 * pi)),
          first * y,
          first * z,
          first * x,
          second * x * y,
          second * y * z,
          second / std::sqrt(12.0) * (3 * z * z - 1),
          second * x * z,
          second / 2 * (x * x - y * y)};
}

/// Light of a distant sky on white paint with the normal n, by the sky's coefficients: ⟨result, sky⟩ =
/// E(n)/π, E being the irradiance of the radiance Σ sky_lm · Y_lm. So a sky of radiance 1 all around gives 1.
///
/// E = Σ A_l · sky_lm · Y_lm(n) with A = π, 2π/3, π/4, which is exact for skies of order 2, and for any other
/// within 3 % on average. Source: Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance
/// Environment Maps (SIGGRAPH 2001), eqs. 8 and 9.
[[nodiscard]] inline Harmonics sky_transfer(const geometry::Vector3& normal) {
  Harmonics transfer = spherical_harmonics(normal);
  for (std::size_t i = 1; i < 9; ++i) transfer[i] *= i < 4 ? 2.0 / 3 : 1.0 / 4;
  return transfer;
}

/// Σ a·b
[[nodiscard]] inline double dot(const Harmonics& a, const Harmonics& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 9; ++i) sum += a[i] * b[i];
  return sum;
}

/// A sky of the same radiance all around.
[[nodiscard]] inline Harmonics uniform_sky(double radiance) {
  return {radiance * std::sqrt(4 * std::numbers::pi), 0, 0, 0, 0, 0, 0, 0, 0};
}

/// Direction `index` of `count` that are spread evenly over the sphere, from above to below, along a spiral
/// of golden angles.
[[nodiscard]] inline geometry::Vector3 spiral_direction(std::size_t index, std::size_t count) {
  const double z = 1 - (2 * static_cast<double>(index) + 1) / static_cast<double>(count);
  const double across = std::sqrt(1 - z * z);
  const double turn = static_cast<double>(index) * std::numbers::pi * (3 - std::sqrt(5.0));
  return {across * std::cos(turn), across * std::sin(turn), z};
}

/// No light: colours are shown unchanged. Generates no code and takes no memory.
struct Unlit {};

/// Like Light, with normals interpolated over each face: the mesh's normals, or at a corner without one the
/// mean of the normals of the faces around it, weighted by area.
struct SmoothLight : Light {};

/// Photograph shown by faces without paint.
struct KeptPhotograph {
  /// [H, W, 3], of the drawn picture and in its colour space; null: faces without paint show their materials.
  std::shared_ptr<const Array<float, 3>> photograph{};

  /// The photograph's pixel, if faces without paint show it.
  [[nodiscard]] const float* unpainted(std::size_t pixel) const {
    return photograph ? photograph->data() + 3 * pixel : nullptr;
  }

  /// \throws ShapeError unless the photograph, if there is one, is [height, width, 3]
  void require_size(std::size_t height, std::size_t width) const {
    if (photograph) require_shape("light", "photograph", *photograph, {height, width, std::size_t{3}});
  }
};

/// Light on paint; faces without paint show the photograph that the picture is laid over.
struct LightOverPhotograph : Light, KeptPhotograph {};

/// A light prepared for one view. at(face, barycentric) is the factor of a colour, before light_colour;
/// slope() its derivative with respect to the barycentric coordinates; agrees() whether two faces are known
/// to have the same light along an edge of both.
struct PreparedUnlit {
  std::array<double, 3> light_colour{1, 1, 1};
  [[nodiscard]] static constexpr double at(std::size_t, const std::array<double, 3>&) { return 1; }
  [[nodiscard]] static constexpr std::array<double, 3> slope(std::size_t, const std::array<double, 3>&) {
    return {0, 0, 0};
  }
  [[nodiscard]] static constexpr bool agrees(std::size_t, std::size_t) { return true; }
};

/// Light of one view, computed once for every face.
struct PreparedLight {
  std::array<double, 3> light_colour;
  std::vector<double> face;  ///< see face_light()
  [[nodiscard]] double at(std::size_t index, const std::array<double, 3>&) const { return face[index]; }
  [[nodiscard]] static constexpr std::array<double, 3> slope(std::size_t, const std::array<double, 3>&) {
    return {0, 0, 0};
  }
  [[nodiscard]] bool agrees(std::size_t a, std::size_t b) const { return face[a] == face[b]; }
};

/// LightOverPhotograph of one view.
struct PreparedLightOverPhotograph : PreparedLight, KeptPhotograph {};

/// SmoothLight of one view, computed once for every corner.
struct PreparedSmoothLight {
  std::array<double, 3> light_colour;
  double ambient;
  double directional;
  geometry::Vector3 towards;  ///< the light, of length 1
  std::vector<std::array<geometry::Vector3, 3>>
      normals;  ///< normals of each face's corners, on the visible side

  [[nodiscard]] static constexpr bool agrees(std::size_t, std::size_t) { return false; }

  /// Σ b·n of the corners' normals.
  [[nodiscard]] geometry::Vector3 blended(std::size_t index, const std::array<double, 3>& b) const {
    geometry::Vector3 sum{};
    for (std::size_t k = 0; k < 3; ++k) sum = geometry::add(sum, geometry::scale(normals[index][k], b[k]));
    return sum;
  }

  [[nodiscard]] geometry::Vector3 normal(std::size_t index, const std::array<double, 3>& b) const {
    return geometry::normalised(blended(index, b));
  }

  [[nodiscard]] double at(std::size_t index, const std::array<double, 3>& b) const {
    return ambient + directional * std::max(0.0, geometry::dot(normal(index, b), towards));
  }

  /// directional · (n_k·L − (n·L)(n·n_k)) / |Σ b·n|; 0 where the light does not reach.
  [[nodiscard]] std::array<double, 3> slope(std::size_t index, const std::array<double, 3>& b) const {
    const geometry::Vector3 sum = blended(index, b);
    const double size = geometry::length(sum), cosine = geometry::dot(sum, towards) / size;
    if (!(cosine > 0)) return {0, 0, 0};
    std::array<double, 3> result{};
    for (std::size_t k = 0; k < 3; ++k) {
      const geometry::Vector3& normal = normals[index][k];
      result[k] =
          directional / size * (geometry::dot(normal, towards) - cosine * geometry::dot(sum, normal) / size);
    }
    return result;
  }
};

/// (p₁ − p₀) × (p₂ − p₀): a face's normal in the world, as long as twice its area.
[[nodiscard]] inline geometry::Vector3 face_normal(const geometry::Mesh& mesh,
                                                   const geometry::Corners& face) {
  const auto& origin = mesh.positions[static_cast<std::size_t>(face[0])];
  return geometry::cross(geometry::subtract(mesh.positions[static_cast<std::size_t>(face[1])], origin),
                         geometry::subtract(mesh.positions[static_cast<std::size_t>(face[2])], origin));
}

/// Mean of the normals of the faces around each position, weighted by area; length 0 where there are none.
[[nodiscard]] inline std::vector<geometry::Vector3> vertex_normals(const geometry::Mesh& mesh) {
  std::vector<geometry::Vector3> sums(mesh.positions.size(), geometry::Vector3{0, 0, 0});
  for (const geometry::Corners& face : mesh.faces) {
    const geometry::Vector3 normal = face_normal(mesh, face);
    if (!geometry::is_finite(normal)) continue;
    for (const std::int32_t corner : face) {
      auto& sum = sums[static_cast<std::size_t>(corner)];
      sum = geometry::add(sum, normal);
    }
  }
  for (geometry::Vector3& sum : sums) sum = geometry::normalised(sum);
  return sums;
}

/// Prepares nothing: the surface is not lit.
[[nodiscard]] inline PreparedUnlit prepare(const geometry::Mesh&, const geometry::Camera&, const Unlit&) {
  return {};
}

/// \throws DomainError as face_light()
[[nodiscard]] inline PreparedLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                           const Light& light) {
  return {light.colour, face_light(mesh, camera, light)};
}

/// \throws DomainError as face_light()
[[nodiscard]] inline PreparedLightOverPhotograph prepare(const geometry::Mesh& mesh,
                                                         const geometry::Camera& camera,
                                                         const LightOverPhotograph& light) {
  return {prepare(mesh, camera, static_cast<const Light&>(light)), light};
}

/// Normals are turned to the side of the face that is seen, as face_light() does.
/// \throws DomainError as face_light()
[[nodiscard]] inline PreparedSmoothLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                 const SmoothLight& light) {
  require_light("smooth light", light);
  PreparedSmoothLight prepared{
      light.colour, light.ambient, light.directional, geometry::normalised(light.direction), {}};
  const auto averages = vertex_normals(mesh);
  const geometry::Vector3 eye = geometry::eye_of(camera);
  prepared.normals.resize(mesh.faces.size());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    geometry::Vector3 seen = face_normal(mesh, mesh.faces[face]);
    const auto& origin = mesh.positions[static_cast<std::size_t>(mesh.faces[face][0])];
    if (geometry::dot(seen, geometry::subtract(eye, origin)) < 0) seen = geometry::scale(seen, -1);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t own = face < mesh.face_normals.size() ? mesh.face_normals[face][k] : -1;
      const bool is_given = own >= 0 && static_cast<std::size_t>(own) < mesh.normals.size();
      const geometry::Vector3& normal = is_given ? mesh.normals[static_cast<std::size_t>(own)]
                                                 : averages[static_cast<std::size_t>(mesh.faces[face][k])];
      prepared.normals[face][k] = geometry::scale(normal, geometry::dot(normal, seen) < 0 ? -1 : 1);
    }
  }
  return prepared;
}

/// Unlit, Light, SmoothLight, or any light whose prepare() returns a type with at() and light_colour.
template <class Model>
concept LightModel = requires(const Model& light, const geometry::Mesh& mesh,
                              const geometry::Camera& camera) {
  { prepare(mesh, camera, light).at(std::size_t{}, std::array<double, 3>{}) } -> std::convertible_to<double>;
  { prepare(mesh, camera, light).light_colour } -> std::convertible_to<std::array<double, 3>>;
};

/// A prepared light that also adds something to every colour, whatever the texels: see ClearCoat.
template <class Lighting>
concept ReflectingLighting = requires(const Lighting& lighting) {
  { lighting.reflected(std::size_t{}, std::array<double, 3>{}) } -> std::same_as<std::array<double, 3>>;
};

/// A prepared light that returns the photograph's pixel for faces without paint, or null: see KeptPhotograph.
template <class Lighting>
concept PhotographedLighting = requires(const Lighting& lighting) {
  { lighting.unpainted(std::size_t{}) } -> std::same_as<const float*>;
  lighting.require_size(std::size_t{}, std::size_t{});
};
}  // namespace tapestry::raster
