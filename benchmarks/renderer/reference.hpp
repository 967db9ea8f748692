#pragma once
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::benchmarks {
/// A view in double precision without snapping: every face is tested at every sample of its box by
/// homogeneous barycentrics, the nearest wins, on a tie the lowest index. Shares no code with the library's
/// rasteriser. All of the mesh must lie before the camera.
class ReferenceView {
 public:
  struct Hit {
    double depth = 1e300;
    std::int32_t face = -1;
    std::array<double, 3> barycentric{};
  };

  /// \param samples  along an axis of the picture
  ReferenceView(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t samples)
      : mesh_(mesh), camera_(camera), samples_(samples) {
    for (const auto& position : mesh.positions) {
      corners_.push_back(geometry::view_from_world(camera, position));
      if (!(corners_.back()[2] > camera.near))
        throw Error(ErrorKind::numeric, "the car reaches behind the camera");
      picture_.push_back(geometry::picture_from_view(camera, corners_.back(), static_cast<double>(samples),
                                                     static_cast<double>(samples)));
    }
  }

  /// Calls visit(row, hits of the row's samples) for all rows, from several threads.
  template <class Visit>
  void for_each_row(Visit visit) const {
    constexpr std::size_t band = 64;
    parallel_for(block_count(samples_, band), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, samples_, band);
      std::vector<Hit> hits((end - begin) * samples_);
      for (std::size_t face = 0; face < mesh_.faces.size(); ++face) draw(face, begin, end, hits);
      for (std::size_t row = begin; row < end; ++row) visit(row, hits.data() + (row - begin) * samples_);
    });
  }

 private:
  void draw(std::size_t face, std::size_t row_begin, std::size_t row_end, std::vector<Hit>& hits) const {
    std::array<std::size_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) corner[k] = static_cast<std::size_t>(mesh_.faces[face][k]);
    std::array<std::size_t, 2> first{}, last{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto [low, high] =
          std::minmax({picture_[corner[0]][axis], picture_[corner[1]][axis], picture_[corner[2]][axis]});
      const auto cut = [&](double v) {
        return static_cast<std::size_t>(std::clamp(v, 0.0, static_cast<double>(samples_)));
      };
      first[axis] = cut(std::floor(low - 0.5));
      last[axis] = cut(std::ceil(high + 0.5));
    }
    std::array<geometry::Vector3, 3> side;
    for (std::size_t k = 0; k < 3; ++k)
      side[k] = geometry::cross(corners_[corner[(k + 1) % 3]], corners_[corner[(k + 2) % 3]]);
    const double volume = geometry::dot(corners_[corner[0]], side[0]);
    for (std::size_t row = std::max(first[0], row_begin); row < std::min(last[0], row_end); ++row)
      for (std::size_t column = first[1]; column < last[1]; ++column)
        test(static_cast<std::int32_t>(face), side, volume, row, column,
             hits[(row - row_begin) * samples_ + column]);
  }

  void test(std::int32_t face, const std::array<geometry::Vector3, 3>& side, double volume, std::size_t row,
            std::size_t column, Hit& hit) const {
    const double scale = 2 / static_cast<double>(samples_);
    const geometry::Vector3 ray{(scale * (static_cast<double>(column) + 0.5) - 1) * camera_.tan_half_fov_x,
                                (scale * (static_cast<double>(row) + 0.5) - 1) * camera_.tan_half_fov_y, 1};
    const std::array<double, 3> b{geometry::dot(ray, side[0]), geometry::dot(ray, side[1]),
                                  geometry::dot(ray, side[2])};
    const double sum = b[0] + b[1] + b[2];
    if (sum == 0 || std::min({b[0] / sum, b[1] / sum, b[2] / sum}) < 0) return;
    const double depth = volume / sum;
    if (depth < hit.depth) hit = {depth, face, {b[0] / sum, b[1] / sum, b[2] / sum}};
  }

  const geometry::Mesh& mesh_;
  const geometry::Camera& camera_;
  std::size_t samples_;
  std::vector<geometry::Vector3> corners_;
  std::vector<std::array<double, 2>> picture_;  // row and column
};
}  // namespace tapestry::benchmarks
