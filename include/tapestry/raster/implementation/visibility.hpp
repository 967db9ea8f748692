#pragma once
#include <tapestry/raster/deferred.hpp>
#include <tapestry/raster/detail/tiled_triangles.hpp>
#include <tapestry/raster/visibility.hpp>

namespace tapestry::raster {
PixelFaces pixel_faces(std::shared_ptr<const geometry::Mesh> mesh, const geometry::Camera& camera,
                       std::size_t height, std::size_t width, std::shared_ptr<const MeshEdges> edges) {
  PixelFaces pixels{std::move(mesh), camera, height, width, {}, {}};
  pixels.face = visibility(*pixels.mesh, camera, height, width, 1).face;
  pixels.edges = detail::edges_of("pixel_faces", *pixels.mesh, std::move(edges));
  return pixels;
}

namespace detail {
void require_view(const char* operation, const geometry::Camera& camera, std::size_t height,
                  std::size_t width, std::size_t samples_per_axis) {
  const std::string name = operation;
  if (samples_per_axis != 1 && samples_per_axis != 2 && samples_per_axis != 4 && samples_per_axis != 8)
    throw DomainError({name, ": samples_per_axis is ", samples_per_axis, ", expected 1, 2, 4 or 8"});
  const std::size_t limit = sample_limit / samples_per_axis;
  if (height == 0 || width == 0 || height > limit || width > limit)
    throw DomainError({name, ": picture is [", height, ", ", width, "], expected 1 to ", limit,
                       " pixels an axis at ", samples_per_axis, " samples an axis"});
  bool finite = geometry::is_finite(camera.translation);
  for (const auto& row : camera.rotation) finite = finite && geometry::is_finite(row);
  if (!finite || !(camera.near > 0) || !(camera.far > camera.near) || !(camera.far <= 1e30) ||
      !(camera.tan_half_fov_x > 0 && camera.tan_half_fov_x <= 1e6) ||
      !(camera.tan_half_fov_y > 0 && camera.tan_half_fov_y <= 1e6)) {
    throw DomainError(
        {name, ": the camera needs a finite pose, 0 < near < far ≤ 1e30 and tangents in (0, 1e6]"});
  }
}
}  // namespace detail

std::vector<geometry::Vector3> positions_in_view(const geometry::Mesh& mesh, const geometry::Camera& camera) {
  std::vector<geometry::Vector3> positions(mesh.positions.size());
  constexpr std::size_t block = 8192;
  parallel_for_blocks(positions.size(), block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) positions[i] = view_from_world(camera, mesh.positions[i]);
  });
  return positions;
}

VisibilityBuffer visibility(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height,
                            std::size_t width, std::size_t samples_per_axis, FaceCulling culling,
                            const RasterKernels& kernels) {
  detail::require_view("visibility", camera, height, width, samples_per_axis);
  const std::size_t rows = height * samples_per_axis, columns = width * samples_per_axis;
  const TiledTriangles triangles("visibility", mesh, camera, rows, columns, culling, kernels);
  VisibilityBuffer buffer{height, width, samples_per_axis, {}, triangles.non_finite_faces()};
  buffer.face.assign(rows * columns, -1);
  parallel_for(triangles.tile_rows() * triangles.tile_columns(), [&](std::size_t index) {
    const std::size_t row = index / triangles.tile_columns(), column = index % triangles.tile_columns();
    triangles.draw(row, column, buffer.face.data() + tile_height * row * columns + tile_width * column,
                   columns);
  });
  return buffer;
}

double median_edge_px(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height,
                      std::size_t width) {
  const PixelRays rays(camera, height, width);
  const ViewClip clip(camera, height, width);
  constexpr std::size_t most = 4096;
  const std::size_t step = std::max<std::size_t>(1, (mesh.faces.size() + most - 1) / most);
  std::vector<double> lengths;
  lengths.reserve(3 * most);
  for (std::size_t face = 0; face < mesh.faces.size(); face += step) {
    std::array<std::array<double, 2>, 3> point;
    bool is_inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(mesh.faces[face][k]);
      const geometry::Vector3 view = view_from_world(camera, mesh.positions[corner]);
      is_inside = is_inside && detail::usable(view) && clip.outside(view) == 0;
      point[k] = rays.picture_point(view);
    }
    for (std::size_t k = 0; is_inside && k < 3; ++k)
      lengths.push_back(std::hypot(point[k][0] - point[(k + 1) % 3][0], point[k][1] - point[(k + 1) % 3][1]));
  }
  if (lengths.empty()) return 0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

std::size_t automatic_samples_per_axis(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                       std::size_t height, std::size_t width) {
  detail::require_view("automatic_samples_per_axis", camera, height, width, 1);
  require_corners("automatic_samples_per_axis", mesh);
  const double edge = median_edge_px(mesh, camera, height, width);
  std::size_t samples = 1;
  while (samples < 8 && edge > 0 && edge * static_cast<double>(samples) < 4 &&
         2 * samples * std::max(height, width) <= detail::sample_limit)
    samples *= 2;
  return samples;
}
}  // namespace tapestry::raster

namespace tapestry::raster::detail {
void require_positions_adjoint(const char* operation, const geometry::Mesh& mesh,
                               const std::vector<geometry::Vector3>& positions_adjoint) {
  if (positions_adjoint.size() != mesh.positions.size())
    throw ShapeError({operation, ": positions_adjoint is [", positions_adjoint.size(), "], expected [",
                      mesh.positions.size(), "], one entry a position"});
}

std::shared_ptr<const MeshEdges> edges_of(const char* operation, const geometry::Mesh& mesh,
                                          std::shared_ptr<const MeshEdges> kept) {
  if (kept == nullptr) return std::make_shared<const MeshEdges>(mesh_edges(mesh));
  if (kept->welded.size() == mesh.positions.size() && kept->face_count == mesh.faces.size()) return kept;
  const auto size = [](std::size_t positions, std::size_t faces) {
    return std::to_string(positions) + " positions and " + std::to_string(faces) + " faces";
  };
  throw ShapeError({operation, ": edges are those of a mesh of ", size(kept->welded.size(), kept->face_count),
                    ", expected ", size(mesh.positions.size(), mesh.faces.size())});
}

void leave_out_inner_sides(const MeshEdges& edges, const SeenFaces& seen,
                           const std::vector<geometry::Vector3>& positions_view,
                           const geometry::Camera& camera, FacesInView& faces) {
  if (!edges.is_closed) return;
  std::array<bool, 3> has{};  // faces of winding −1, 0 and 1
  seen.for_each_face(
      [&](std::int32_t face) { has[static_cast<std::size_t>(faces.winding(face) + 1)] = true; });
  if (has[1] || has[0] == has[2] ||
      std::any_of(positions_view.begin(), positions_view.end(),
                  [&](const geometry::Vector3& position) { return !(position[2] > camera.near); }))
    return;
  faces.leave_out(has[0] ? 1 : -1);
}
}  // namespace tapestry::raster::detail
