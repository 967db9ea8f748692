#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/surface.hpp>
#include <tapestry/raster/vertex_gradient/shares.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// What one band of rows finds out about a face.
struct FaceAdjoint {
  std::int32_t face;
  double light;                                   ///< derivative with respect to its light
  std::array<geometry::Vector3, 3> corners_view;  ///< and to its corners
};

/// ∂(colour seen at a fixed point of the picture)/∂(corners of the face), times an adjoint.
///
/// A displacement d of the surface at the point that the ray r meets shifts what is seen there by
/// e = r·(n·d)/(n·r) − d within the face, so with G = Σ_k ∂colour/∂b_k · ∇b_k the change is G·e, and as
/// d = Σ b_k·dq_k each corner receives b_k · (n·(G·r)/(n·r) − G).
///
/// \param slope  ∂colour/∂b_k times the adjoint of the colour, summed over channels
inline std::array<geometry::Vector3, 3> moving_texture_adjoint(
    const std::array<geometry::Vector3, 3>& corners, const std::array<double, 3>& b,
    const std::array<double, 3>& slope) {
  const geometry::Vector3 normal =
      geometry::cross(geometry::subtract(corners[1], corners[0]), geometry::subtract(corners[2], corners[0]));
  const double squared = geometry::dot(normal, normal);
  geometry::Vector3 point{}, gradient{};
  for (std::size_t k = 0; k < 3; ++k) {
    point = geometry::add(point, geometry::scale(corners[k], b[k]));
    const auto opposite = geometry::subtract(corners[(k + 2) % 3], corners[(k + 1) % 3]);
    gradient =
        geometry::add(gradient, geometry::scale(geometry::cross(normal, opposite), slope[k] / squared));
  }
  const double along = geometry::dot(gradient, point) / geometry::dot(normal, point);
  const geometry::Vector3 shift = geometry::subtract(geometry::scale(normal, along), gradient);
  std::array<geometry::Vector3, 3> result{};
  if (!geometry::is_finite(shift)) return result;  // a face without area, or edge-on
  for (std::size_t k = 0; k < 3; ++k) result[k] = geometry::scale(shift, b[k]);
  return result;
}

/// Flat light turns with the face: adds light_adjoint · ∂(ambient + directional · max(0, n·L))/∂positions.
inline void add_light_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera, const Light& light,
                              std::int32_t face, double light_adjoint,
                              std::vector<geometry::Vector3>& positions_adjoint) {
  const auto& corners = mesh.faces[static_cast<std::size_t>(face)];
  const auto position = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(corners[k])]; };
  const geometry::Vector3 first = geometry::subtract(position(1), position(0));
  const geometry::Vector3 second = geometry::subtract(position(2), position(0));
  const geometry::Vector3 cross = geometry::cross(first, second);
  const double size = geometry::length(cross);
  const geometry::Vector3 normal = geometry::scale(cross, 1 / size);
  const double side =
      geometry::dot(cross, geometry::subtract(geometry::eye_of(camera), position(0))) < 0 ? -1 : 1;
  const geometry::Vector3 towards = geometry::normalised(light.direction);
  const double cosine = geometry::dot(normal, towards);
  if (!(side * cosine > 0) || !(size > 0)) return;
  const geometry::Vector3 gradient =
      geometry::scale(geometry::subtract(towards, geometry::scale(normal, cosine)),
                      light_adjoint * light.directional * side / size);
  const geometry::Vector3 at_first = geometry::cross(second, gradient);
  const geometry::Vector3 at_second = geometry::cross(gradient, first);
  const auto add = [&](std::size_t k, const geometry::Vector3& value) {
    auto& sum = positions_adjoint[static_cast<std::size_t>(corners[k])];
    sum = geometry::add(sum, value);
  };
  add(1, at_first);
  add(2, at_second);
  add(0, geometry::scale(geometry::add(at_first, at_second), -1));
}

/// Without a light, or with normals that are taken as they are, nothing turns.
template <class OtherLight>
requires(!std::same_as<OtherLight, Light>) void add_light_adjoint(const geometry::Mesh&,
                                                                  const geometry::Camera&, const OtherLight&,
                                                                  std::int32_t, double,
                                                                  std::vector<geometry::Vector3>&) {}

inline void add_part(FaceAdjoint& sum, const FaceAdjoint& part) {
  sum.light += part.light;
  for (std::size_t k = 0; k < 3; ++k)
    sum.corners_view[k] = geometry::add(sum.corners_view[k], part.corners_view[k]);
}

/// Leaves one entry a face, in order of faces.
inline void merge_faces(std::vector<FaceAdjoint>& faces) {
  std::stable_sort(faces.begin(), faces.end(),
                   [](const FaceAdjoint& a, const FaceAdjoint& b) { return a.face < b.face; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (kept > 0 && faces[kept - 1].face == faces[i].face)
      add_part(faces[kept - 1], faces[i]);
    else
      faces[kept++] = faces[i];
  }
  faces.resize(kept);
}

/// What one fragment finds out; of its light only if the face turns in it.
/// \param adjoint  of the pixel's three values
template <std::floating_point T, class Colour>
[[nodiscard]] FaceAdjoint fragment_adjoint(const Colour& colour,
                                           const std::array<geometry::Vector3, 3>& corners_view,
                                           const Fragment& fragment, const T* adjoint, bool is_turning) {
  const auto slope = colour.slope(fragment.face, fragment.barycentric);
  std::array<double, 3> tinted{};
  if (is_turning) tinted = colour.tinted(fragment.face, fragment.barycentric);
  FaceAdjoint part{fragment.face, 0, {}};
  std::array<double, 3> sum{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double weight = fragment.coverage * static_cast<double>(adjoint[c]);
    part.light += weight * tinted[c];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * slope[c][k];
  }
  part.corners_view = moving_texture_adjoint(corners_view, fragment.barycentric, sum);
  return part;
}

/// Where the derivative with respect to positions goes: by what moves in the picture, and by light that turns
/// with its face, which is left out if null. Both may be one.
struct MotionAdjoint {
  std::vector<geometry::Vector3>* moving;
  std::vector<geometry::Vector3>* turning;
};

/// The part of the gradient that comes from what faces show, their outlines held still, sampled a band of
/// rows at a time.
template <std::floating_point T, class Model, class Colour>
void add_interior(const Surface<T, Model>& surface, const Colour& colour, const geometry::Camera& camera,
                  const std::vector<geometry::Vector3>& positions_view, const Array<T, 3>& render_adjoint,
                  std::size_t samples_per_axis, const MotionAdjoint& positions_adjoint) {
  const FragmentBands fragments("vertex_adjoint", surface.body.mesh, camera, render_adjoint.shape(0),
                                render_adjoint.shape(1), samples_per_axis);
  std::vector<std::vector<FaceAdjoint>> bands(fragments.band_count());
  parallel_for(bands.size(), [&](std::size_t index) {
    fragments.visit_band(index, grain_of(surface.body.layout), [&](const Fragment& fragment) {
      const T* const adjoint = render_adjoint.data() + 3 * fragment.pixel;
      if (adjoint[0] == 0 && adjoint[1] == 0 && adjoint[2] == 0) return;
      const auto part = fragment_adjoint(
          colour, corners_in_view(surface.body.mesh, positions_view, fragment.face), fragment, adjoint,
          std::same_as<Model, Light> && positions_adjoint.turning != nullptr);
      auto& band = bands[index];
      if (!band.empty() && band.back().face == part.face)
        add_part(band.back(), part);
      else
        band.push_back(part);
    });
    merge_faces(bands[index]);
  });
  std::vector<std::vector<VertexShare>> shares(1);
  for (const auto& band : bands) {
    for (const FaceAdjoint& part : band) {
      for (std::int32_t k = 0; k < 3; ++k)
        shares[0].push_back(
            {corner_of(surface.body.mesh, part.face, k), part.corners_view[static_cast<std::size_t>(k)]});
      if (positions_adjoint.turning != nullptr)
        add_light_adjoint(surface.body.mesh, camera, surface.light, part.face, part.light,
                          *positions_adjoint.turning);
    }
  }
  add_shares(shares, camera, *positions_adjoint.moving);
}

}  // namespace tapestry::raster::detail
