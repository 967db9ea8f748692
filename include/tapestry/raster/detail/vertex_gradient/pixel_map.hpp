#pragma once
#include <tapestry/raster/detail/vertex_gradient/interior.hpp>

namespace tapestry::raster::detail {
/// Neural Mesh Renderer's gradient of positions; it is not the derivative of any picture. Every edge of every
/// face is followed along each row and column that crosses it. Each pixel there adds its gain, the fall of
/// the loss if the edge moved to it, divided by its distance from the edge. Source: Kato, Ushiku, Harada,
/// "Neural 3D Mesh Renderer" (CVPR 2018), section 3, and its program's rules: pixels outside the face count
/// up to the border of the picture, only where the pixel inside the edge shows the face; pixels inside count
/// up to the face's other side; only gains count.
class PixelMap {
 public:
  /// \param colours   [rows · columns] of the samples; `buffer` has one sample a pixel
  /// \param adjoints  derivatives with respect to them
  PixelMap(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view,
           const geometry::Camera& camera, const VisibilityBuffer& buffer,
           const std::vector<std::array<double, 3>>& colours,
           const std::vector<std::array<double, 3>>& adjoints)
      : mesh_(mesh),
        positions_view_(positions_view),
        camera_(camera),
        faces_(buffer.face),
        size_{static_cast<long>(buffer.width * buffer.samples_per_axis),
              static_cast<long>(buffer.height * buffer.samples_per_axis)},
        colours_(colours),
        adjoints_(adjoints) {}

  void add_to(std::vector<geometry::Vector3>& positions_adjoint) const {
    constexpr std::size_t block = 256;
    std::vector<std::vector<VertexShare>> shares(block_count(mesh_.faces.size(), block));
    parallel_for(shares.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, mesh_.faces.size(), block);
      for (std::size_t face = begin; face < end; ++face)
        add_face(static_cast<std::int32_t>(face), shares[index]);
    });
    add_shares(shares, camera_, positions_adjoint);
  }

 private:
  static constexpr double least_distance = 1e-3;  // added to distances, as in the source

  /// A face in units of samples, with the first sample's centre at 0, and its sums: ∂L/∂(x, y) of its
  /// corners, both in [−1, 1] across the picture.
  struct FlatFace {
    std::int32_t face;
    std::array<std::array<double, 2>, 3> corners;
    std::array<std::array<double, 2>, 3> adjoint{};
  };

  /// An edge and one axis to walk along; positions along that axis come first.
  struct Walk {
    std::size_t axis, from, to, opposite;
    [[nodiscard]] std::array<double, 2> point(const FlatFace& flat, std::size_t corner) const {
      return {flat.corners[corner][axis], flat.corners[corner][1 - axis]};
    }
  };

  template <class Values>
  [[nodiscard]] const typename Values::value_type& sample(const Walk& walk, long along, long across,
                                                          const Values& values) const {
    const long column = walk.axis == 0 ? along : across, row = walk.axis == 0 ? across : along;
    return values[static_cast<std::size_t>(row * size_[0] + column)];
  }

  void add_face(std::int32_t face, std::vector<VertexShare>& shares) const {
    FlatFace flat{face, {}, {}};
    const auto corners = corners_in_view(mesh_, positions_view_, face);
    const std::array<double, 2> tangent{camera_.tan_half_fov_x, camera_.tan_half_fov_y};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!usable(corners[k]) || corners[k][2] < camera_.near) return;  // it does not clip
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double across = corners[k][axis] / (corners[k][2] * tangent[axis]);
        flat.corners[k][axis] =
            (across * static_cast<double>(size_[axis]) + static_cast<double>(size_[axis]) - 1) / 2;
      }
    }
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 2; ++axis) add_edge(flat, {axis, k, (k + 1) % 3, (k + 2) % 3});
    for (std::size_t k = 0; k < 3; ++k) {
      if (flat.adjoint[k][0] == 0 && flat.adjoint[k][1] == 0) continue;
      const geometry::Vector3& q = corners[k];
      const double x = flat.adjoint[k][0] / (q[2] * tangent[0]), y = flat.adjoint[k][1] / (q[2] * tangent[1]);
      shares.push_back(
          {corner_of(mesh_, face, static_cast<std::int32_t>(k)), {x, y, -(x * q[0] + y * q[1]) / q[2]}});
    }
  }

  void add_edge(FlatFace& flat, const Walk& walk) const {
    const auto from = walk.point(flat, walk.from), to = walk.point(flat, walk.to),
               opposite = walk.point(flat, walk.opposite);
    if (from[0] == to[0]) return;
    const long first = static_cast<long>(
        std::clamp(std::ceil(std::min(from[0], to[0])), 0.0, static_cast<double>(size_[walk.axis])));
    const long last = static_cast<long>(
        std::min(std::floor(std::max(from[0], to[0])), static_cast<double>(size_[walk.axis] - 1)));
    const auto line = [](const auto& a, const auto& b, double at) {
      return a[1] + (b[1] - a[1]) / (b[0] - a[0]) * (at - a[0]);
    };
    // Outwards is away from the third corner.
    const bool grows_outwards = opposite[1] < line(from, to, opposite[0]);
    for (long along = first; along <= last; ++along) {
      const auto at = static_cast<double>(along);
      const double crossing = line(from, to, at);
      if (!(std::abs(crossing) < 1e9)) continue;
      const long inner = static_cast<long>(grows_outwards ? std::floor(crossing) : std::ceil(crossing));
      const long outer = inner + (grows_outwards ? 1 : -1);
      const long limit = size_[1 - walk.axis];
      if (inner < 0 || inner >= limit || outer < 0 || outer >= limit) continue;
      if (sample(walk, along, inner, faces_) == flat.face)
        pull(flat, walk, along, crossing, outer, grows_outwards ? limit - 1 : 0, inner, false);
      const bool ends_before = (at - from[0]) * (at - opposite[0]) < 0;
      const double far = ends_before ? line(from, opposite, at) : line(to, opposite, at);
      const double end =
          std::clamp(grows_outwards ? std::ceil(far) : std::floor(far), 0.0, static_cast<double>(limit - 1));
      if (std::isfinite(end)) pull(flat, walk, along, crossing, inner, static_cast<long>(end), outer, true);
    }
  }

  /// Adds the gradient from the samples `begin` to `end`. The gain of a sample is, to first order, the
  /// decrease of the loss if it takes the colour of `reference`; only gains above 0 count.
  void pull(FlatFace& flat, const Walk& walk, long along, double crossing, long begin, long end,
            long reference, bool is_inside) const {
    const auto& wanted = sample(walk, along, reference, colours_);
    const auto from = walk.point(flat, walk.from), to = walk.point(flat, walk.to);
    const double at = static_cast<double>(along), length = to[0] - from[0];
    const double scale = 2 / static_cast<double>(size_[1 - walk.axis]);
    for (long across = std::min(begin, end); across <= std::max(begin, end); ++across) {
      if (is_inside && sample(walk, along, across, faces_) != flat.face) continue;
      const auto& colour = sample(walk, along, across, colours_);
      const auto& adjoint = sample(walk, along, across, adjoints_);
      double gain = 0;
      for (std::size_t c = 0; c < 3; ++c) gain += (colour[c] - wanted[c]) * adjoint[c];
      if (!(gain > 0)) continue;
      const double distance = (static_cast<double>(across) - crossing) * scale;
      const auto add = [&](std::size_t corner, double lever) {
        if (lever == 0) return;
        const double far = length / lever * distance;
        flat.adjoint[corner][1 - walk.axis] -= gain / (far + (far > 0 ? least_distance : -least_distance));
      };
      add(walk.from, to[0] - at);
      add(walk.to, at - from[0]);
    }
  }

  const geometry::Mesh& mesh_;
  const std::vector<geometry::Vector3>& positions_view_;
  const geometry::Camera& camera_;
  const std::vector<std::int32_t>& faces_;
  std::array<long, 2> size_;  // columns, rows
  const std::vector<std::array<double, 3>>& colours_;
  const std::vector<std::array<double, 3>>& adjoints_;
};

/// Colours of all samples, 0 where nothing is seen.
template <class Colour>
std::vector<std::array<double, 3>> sample_colours(const geometry::Mesh& mesh,
                                                  const std::vector<geometry::Vector3>& positions_view,
                                                  const geometry::Camera& camera,
                                                  const VisibilityBuffer& buffer, const Colour& colour) {
  const std::size_t rows = buffer.height * buffer.samples_per_axis;
  const std::size_t columns = buffer.width * buffer.samples_per_axis;
  std::vector<std::array<double, 3>> colours(buffer.face.size(), std::array<double, 3>{0, 0, 0});
  parallel_for(rows, [&](std::size_t row) {
    Barycentric barycentric(camera, rows, columns);
    for (std::size_t column = 0; column < columns; ++column) {
      const std::int32_t face = buffer.face[row * columns + column];
      if (face < 0) continue;
      barycentric.select(mesh, positions_view, face);
      colours[row * columns + column] =
          colour.at(face, barycentric.at(static_cast<double>(row), static_cast<double>(column)));
    }
  });
  return colours;
}
}  // namespace tapestry::raster::detail
