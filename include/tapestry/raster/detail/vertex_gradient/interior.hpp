#pragma once
#include <tapestry/raster/detail/surface.hpp>
#include <tapestry/raster/detail/vertex_gradient/face_moments.hpp>
#include <tapestry/raster/detail/vertex_gradient/grazing_faces.hpp>
#include <tapestry/raster/detail/vertex_gradient/sliver.hpp>

namespace tapestry::raster::detail {
/// A part of the derivative with respect to one position, in view space.
struct VertexShare {
  std::int32_t vertex;
  geometry::Vector3 adjoint_view;
};

/// Adds shares to the derivatives with respect to positions of the world.
inline void add_shares(const std::vector<VertexShare>& shares, const geometry::Camera& camera,
                       std::vector<geometry::Vector3>& positions_adjoint) {
  for (const VertexShare& share : shares) {
    geometry::Vector3& sum = positions_adjoint[static_cast<std::size_t>(share.vertex)];
    sum = geometry::add(sum, geometry::multiply_transposed(camera.rotation, share.adjoint_view));
  }
}

/// Adds them block by block, so that the sums do not depend on the threads that made the blocks.
inline void add_shares(const std::vector<std::vector<VertexShare>>& blocks, const geometry::Camera& camera,
                       std::vector<geometry::Vector3>& positions_adjoint) {
  for (const auto& block : blocks) add_shares(block, camera, positions_adjoint);
}

inline std::array<geometry::Vector3, 3> corners_in_view(const geometry::Mesh& mesh,
                                                        const std::vector<geometry::Vector3>& positions_view,
                                                        std::int32_t face) {
  std::array<geometry::Vector3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = positions_view[static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(face)][k])];
  return corners;
}

/// Corner k of a face, k also 3 or 4.
inline std::int32_t corner_of(const geometry::Mesh& mesh, std::int32_t face, std::int32_t k) {
  return mesh.faces[static_cast<std::size_t>(face)][static_cast<std::size_t>(k % 3)];
}

/// Cuts a segment of the picture at the borders of pixels, and each part into equal pieces of at most
/// `longest` pixels: calls visit(column, row, length) with the middle of each.
template <class Visit>
void for_each_piece(const std::array<double, 2>& from, const std::array<double, 2>& to, double longest,
                    Visit visit) {
  const std::array<double, 2> way{to[0] - from[0], to[1] - from[1]};
  const double length = distance(from, to);
  if (!(length > 0)) return;
  std::array<double, 2> border;  // the next one along each axis
  for (std::size_t axis = 0; axis < 2; ++axis)
    border[axis] = way[axis] > 0 ? std::floor(from[axis]) + 1 : std::ceil(from[axis]) - 1;
  double begin = 0;
  while (begin < 1) {
    std::array<double, 2> reached{1, 1};
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (way[axis] != 0) reached[axis] = (border[axis] - from[axis]) / way[axis];
    const double end = std::min({reached[0], reached[1], 1.0});
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (reached[axis] <= end) border[axis] += way[axis] > 0 ? 1 : -1;
    const double part = (end - begin) * length;
    if (!(part > 0)) continue;
    const double count = std::max(std::ceil(part / longest), 1.0);
    for (double i = 0; i < count; ++i) {
      const double t = begin + (end - begin) * (i + 0.5) / count;
      visit(from[0] + t * way[0], from[1] + t * way[1], part / count);
    }
    begin = end;
  }
}

/// Derivative of a face's colours at fixed points of the picture with respect to its corners, times an
/// adjoint.
///
/// A displacement d of the surface at the point p of the ray r shifts the visible point by e = r·(n·d)/(n·r)
/// − d within the face. So with G = Σ_j σ_j·∇b_j the change is G·e, and as d = Σ b_k·dq_k each corner
/// receives b_k · (n·(G·p)/(n·p) − G). On a plane n·p is constant, and ∇b_j·p = b_j + ∇b_j·q_{j+1}, since b_j
/// is 0 in the next corner: the sums over all p need no more than the moments.
inline std::array<geometry::Vector3, 3> moving_texture_adjoint(
    const std::array<geometry::Vector3, 3>& corners, const FaceMoments& moments) {
  const geometry::Vector3 normal =
      geometry::cross(geometry::subtract(corners[1], corners[0]), geometry::subtract(corners[2], corners[0]));
  const double squared = geometry::dot(normal, normal), distance = geometry::dot(normal, corners[0]);
  std::array<geometry::Vector3, 3> gradient, result{};  // ∇b_j
  for (std::size_t j = 0; j < 3; ++j) {
    const auto opposite = geometry::subtract(corners[(j + 2) % 3], corners[(j + 1) % 3]);
    gradient[j] = geometry::scale(geometry::cross(normal, opposite), 1 / squared);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    double along = moments.second[k];
    geometry::Vector3 within{};
    for (std::size_t j = 0; j < 3; ++j) {
      along += moments.first[k][j] * geometry::dot(gradient[j], corners[(j + 1) % 3]);
      within = geometry::add(within, geometry::scale(gradient[j], moments.first[k][j]));
    }
    result[k] = geometry::subtract(geometry::scale(normal, along / distance), within);
    if (!geometry::is_finite(result[k])) return {};  // a face without area, or edge-on
  }
  return result;
}

/// A face's unit normal in the world, on the visible side, and its derivative by the corners.
struct TurningNormal {
  TurningNormal(const geometry::Mesh& mesh, const geometry::Vector3& eye, std::int32_t face)
      : corners(mesh.faces[static_cast<std::size_t>(face)]) {
    const auto position = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(corners[k])]; };
    first = geometry::subtract(position(1), position(0));
    second = geometry::subtract(position(2), position(0));
    const geometry::Vector3 cross = geometry::cross(first, second);
    size = geometry::length(cross);
    normal = geometry::scale(cross, 1 / size);
    side = geometry::dot(cross, geometry::subtract(eye, position(0))) < 0 ? -1 : 1;
  }

  /// Adds factor · ∂(side · normal · direction)/∂positions; nothing for a face without area.
  void add_adjoint(const geometry::Vector3& direction, double factor,
                   std::vector<geometry::Vector3>& positions_adjoint) const {
    if (!(size > 0)) return;
    const double cosine = geometry::dot(normal, direction);
    const geometry::Vector3 gradient =
        geometry::scale(geometry::subtract(direction, geometry::scale(normal, cosine)), factor * side / size);
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

  const geometry::Corners& corners;
  geometry::Vector3 first{}, second{};  ///< from corner 0 to the others
  geometry::Vector3 normal{};           ///< normal by the winding; times `side`, that of the visible side
  double size = 0;                      ///< twice the area
  double side = 1;
};

/// Flat light turns with the face: adds light_adjoint · ∂(ambient + directional · max(0, n·L))/∂positions.
inline void add_light_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera, const Light& light,
                              std::int32_t face, double light_adjoint,
                              std::vector<geometry::Vector3>& positions_adjoint) {
  const TurningNormal turning(mesh, geometry::eye_of(camera), face);
  const geometry::Vector3 towards = geometry::normalised(light.direction);
  if (!(turning.side * geometry::dot(turning.normal, towards) > 0)) return;
  turning.add_adjoint(towards, light_adjoint * light.directional, positions_adjoint);
}

/// Without a light, or with constant normals, nothing turns.
template <class OtherLight>
requires(!std::same_as<OtherLight, Light>) void add_light_adjoint(const geometry::Mesh&,
                                                                  const geometry::Camera&, const OtherLight&,
                                                                  std::int32_t, double,
                                                                  std::vector<geometry::Vector3>&) {}

/// Destinations of the derivative with respect to positions: one for motion in the picture, and one for light
/// that turns with its face, which is left out if null. Both may be the same.
struct MotionAdjoint {
  std::vector<geometry::Vector3>* moving;
  std::vector<geometry::Vector3>* turning;
};

template <class Model>
[[nodiscard]] bool is_turning(const MotionAdjoint& positions_adjoint) {
  return std::same_as<Model, Light> && positions_adjoint.turning != nullptr;
}

struct BlockShares {
  /// The derivative with respect to a face's light.
  struct Turning {
    std::int32_t face;
    double light;
  };
  std::vector<VertexShare> moving;
  std::vector<Turning> turning;
};

/// The derivatives of faces' moments.
/// \param step  see sliver_factor()
template <class Colour>
[[nodiscard]] BlockShares shares_of(const Colour& colour, const FragmentBands& fragments, MomentSums& sums,
                                    const std::array<double, 2>& step, bool is_turning) {
  BlockShares shares;
  shares.moving.reserve(3 * sums.face_count());
  sums.visit(colour, is_turning, [&](FaceMoments& face) {
    const auto corners = corners_in_view(fragments.mesh(), fragments.positions_view(), face.face);
    face.scale(sliver_factor(corners, face.place, step));
    const auto part = moving_texture_adjoint(corners, face);
    for (std::int32_t k = 0; k < 3; ++k)
      shares.moving.push_back({corner_of(fragments.mesh(), face.face, k), part[static_cast<std::size_t>(k)]});
    if (is_turning) shares.turning.push_back({face.face, face.light});
  });
  return shares;
}

/// Adds the derivatives block by block, so that the sums do not depend on the threads that made the blocks.
template <std::floating_point T, class Model>
void add_blocks(const Surface<T, Model>& surface, const FragmentBands& fragments,
                const std::vector<BlockShares>& blocks, const MotionAdjoint& positions_adjoint) {
  for (const BlockShares& block : blocks)
    add_shares(block.moving, fragments.camera(), *positions_adjoint.moving);
  for (const BlockShares& block : blocks)
    for (const auto& [face, light] : block.turning)
      add_light_adjoint(fragments.mesh(), fragments.camera(), surface.light, face, light,
                        *positions_adjoint.turning);
}

/// Memory for the moments of one block at a time.
[[nodiscard]] inline MomentSums& moment_sums() {
  static thread_local MomentSums sums;
  sums.clear();
  return sums;
}

/// The part of the gradient from inside the faces, with outlines held still, sampled a band of rows at a
/// time.
/// \param left_out  faces that add nothing, in order
/// \returns the faces that are seen where the adjoint is not 0
template <std::floating_point T, class Model, class Colour>
SeenFaces add_interior(const Surface<T, Model>& surface, const Colour& colour, const FragmentBands& fragments,
                       const Array<T, 3>& render_adjoint, const MotionAdjoint& positions_adjoint,
                       const std::vector<std::int32_t>& left_out) {
  std::vector<BlockShares> bands(fragments.band_count());
  SeenFaces seen(fragments.width(), fragments.band_rows(), bands.size());
  const bool turns = is_turning<Model>(positions_adjoint);
  parallel_for(bands.size(), [&](std::size_t index) {
    MomentSums& sums = moment_sums();
    SeenFaces::Band& band = seen.band(index);
    fragments.visit_band(index, grain_of(surface.body.layout), [&](const Fragment& fragment) {
      const T* const adjoint = render_adjoint.data() + 3 * fragment.pixel;
      if (adjoint[0] == 0 && adjoint[1] == 0 && adjoint[2] == 0) return;
      band.add(fragment.pixel, fragment.face);
      if (left_out.empty() || !std::binary_search(left_out.begin(), left_out.end(), fragment.face))
        sums.add(colour, fragment, adjoint, turns);
    });
    bands[index] = shares_of(colour, fragments, sums, sample_step(fragments), turns);
  });
  add_blocks(surface, fragments, bands, positions_adjoint);
  return seen;
}

/// The same from inside grazing faces, integrated over their visible parts.
/// \pre the field is filled after GrazingSpans::find()
template <std::floating_point T, class Model, class Colour>
void add_grazing_interior(const Surface<T, Model>& surface, const Colour& colour,
                          const FragmentBands& fragments, const Array<T, 3>& render_adjoint,
                          const MotionAdjoint& positions_adjoint, const GrazingSpans& spans,
                          const FaceField& field) {
  std::vector<BlockShares> blocks(spans.face_count());
  const bool turns = is_turning<Model>(positions_adjoint);
  parallel_for(blocks.size(), [&](std::size_t index) {
    MomentSums& sums = moment_sums();
    spans.visit(field, index, [&](const Fragment& fragment) {
      sums.add(colour, fragment, render_adjoint.data() + 3 * fragment.pixel, turns);
    });
    blocks[index] = shares_of(colour, fragments, sums, GrazingSpans::sliver_step(field), turns);
  });
  add_blocks(surface, fragments, blocks, positions_adjoint);
}
}  // namespace tapestry::raster::detail
