#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/face_boxes.hpp>
#include <tapestry/raster/pixel_rays.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster {

/// Every face of a view as functions of the picture: with the ray r = Σ w_k·q_k, w_k ≥ 0 on the face,
/// Σ w_k = 1/z there, and w_k·z are the barycentric coordinates. Unlike the visibility buffer it answers for
/// any point, without snapping; faces are found through a grid of cells about as large as they are, nearest
/// first.
class FaceField {
 public:
  /// What a ray meets.
  struct Hit {
    std::int32_t face = -1;
    double inverse_depth = 0;
  };

  /// A face in a cell, with the greatest and the least 1/z it may have there.
  struct Entry {
    double inverse_depth_max;
    double inverse_depth_min;
    std::int32_t face;
  };

  FaceField(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view,
            const geometry::Camera& camera, std::size_t height, std::size_t width)
      : rays_(camera, height, width),
        limits_{1 / camera.far, 1 / camera.near},
        weights_(mesh.faces.size()),
        winding_(mesh.faces.size(), 0),
        boxes_(face_boxes(mesh, positions_view, camera, height, width)) {
    choose_cells();
    fill_cells(mesh, positions_view);
  }

  [[nodiscard]] const PixelRays& rays() const { return rays_; }

  /// w of a face; all 0 for one that is not drawn.
  [[nodiscard]] const std::array<Affine, 3>& weights(std::int32_t face) const {
    return weights_[static_cast<std::size_t>(face)];
  }

  /// 1/z of a face's plane.
  [[nodiscard]] Affine inverse_depth(std::int32_t face) const {
    const auto& w = weights(face);
    return {w[0].a + w[1].a + w[2].a, w[0].b + w[1].b + w[2].b, w[0].c + w[1].c + w[2].c};
  }

  /// Barycentric coordinates of a face at a point, brought to its rim where the point lies beside it.
  [[nodiscard]] std::array<double, 3> barycentric(std::int32_t face, double column, double row) const {
    std::array<double, 3> b{};
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      b[k] = std::max(weights(face)[k].at(column, row), 0.0);
      sum += b[k];
    }
    if (!(sum > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    for (double& value : b) value /= sum;
    return b;
  }

  /// 1/z where the ray meets the face between near and far, else 0.
  [[nodiscard]] double hit(std::int32_t face, double column, double row) const {
    const auto& w = weights(face);
    const double w0 = w[0].at(column, row), w1 = w[1].at(column, row), w2 = w[2].at(column, row);
    if (!(w0 >= 0 && w1 >= 0 && w2 >= 0)) return 0;
    const double inverse_depth = w0 + w1 + w2;
    return inverse_depth >= limits_[0] && inverse_depth <= limits_[1] ? inverse_depth : 0;
  }

  /// The nearest face at a point other than those that `is_left_out`, if nearer than `least`; of equals the
  /// lowest.
  template <class Predicate>
  [[nodiscard]] Hit nearest(double column, double row, double least, Predicate is_left_out) const {
    Hit best{-1, least};
    const std::size_t cell = cell_of(column, row);
    if (cell == no_cell) return best;
    for (std::size_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
      const Entry& entry = entries_[i];
      if (entry.inverse_depth_max < best.inverse_depth) break;
      const double inverse_depth = hit(entry.face, column, row);
      if (inverse_depth == 0 || inverse_depth < best.inverse_depth) continue;
      const bool is_tie = inverse_depth == best.inverse_depth;
      if (is_tie && (best.face < 0 || entry.face > best.face)) continue;
      if (!is_left_out(entry.face)) best = {entry.face, inverse_depth};
    }
    return best;
  }

  /// Whether a face is nearer at a point than 1 / inverse_depth, by more than rounding may cause.
  [[nodiscard]] bool hides(std::int32_t face, double column, double row, double inverse_depth) const {
    return hit(face, column, row) > inverse_depth * (1 + 1e-9);
  }

  /// A face, other than those that `is_left_out`, that hides a point; −1 if there is none.
  template <class Predicate>
  [[nodiscard]] std::int32_t hider(double column, double row, double inverse_depth,
                                   Predicate is_left_out) const {
    const std::size_t cell = cell_of(column, row);
    if (cell == no_cell) return -1;
    for (std::size_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
      if (entries_[i].inverse_depth_max <= inverse_depth) return -1;
      const std::int32_t face = entries_[i].face;
      if (hides(face, column, row, inverse_depth) && !is_left_out(face)) return face;
    }
    return -1;
  }

  /// 1 or −1 for the two ways in which the corners of a face may run in the picture, 0 for one that is not
  /// drawn.
  [[nodiscard]] int winding(std::int32_t face) const { return winding_[static_cast<std::size_t>(face)]; }

  [[nodiscard]] const FaceBox& box(std::int32_t face) const { return boxes_[static_cast<std::size_t>(face)]; }

  /// A cell of the grid.
  struct Cell {
    std::array<double, 2> low;
    std::array<double, 2> high;
    const Entry* begin;
    const Entry* end;
  };
  [[nodiscard]] std::size_t cell_count() const { return begin_.size() - 1; }
  [[nodiscard]] Cell cell(std::size_t index) const {
    const auto x = static_cast<double>(index % columns_), y = static_cast<double>(index / columns_);
    return {{origin_[0] + x * side_, origin_[1] + y * side_},
            {origin_[0] + (x + 1) * side_, origin_[1] + (y + 1) * side_},
            entries_.data() + begin_[index],
            entries_.data() + begin_[index + 1]};
  }

 private:
  static constexpr std::size_t no_cell = std::numeric_limits<std::size_t>::max();

  /// False, and all 0, if they are not finite.
  [[nodiscard]] bool set_weights(const geometry::Mesh& mesh,
                                 const std::vector<geometry::Vector3>& positions_view, std::size_t face) {
    std::array<geometry::Vector3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = positions_view[static_cast<std::size_t>(mesh.faces[face][k])];
    std::array<Affine, 3>& weights = weights_[face];
    const double volume = geometry::dot(corners[0], geometry::cross(corners[1], corners[2]));
    const double inverse = 1 / volume;
    bool is_finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const geometry::Vector3 c = geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]);
      weights[k] = {c[0] * inverse * rays_.step[0], c[1] * inverse * rays_.step[1],
                    (c[2] + c[0] * rays_.first[0] + c[1] * rays_.first[1]) * inverse};
      is_finite = is_finite && geometry::is_finite({weights[k].a, weights[k].b, weights[k].c});
    }
    if (!is_finite)
      weights = {};
    else
      winding_[face] = volume > 0 ? 1 : -1;
    return is_finite;
  }

  /// Half a cell a face, were the faces spread evenly over what the mesh covers.
  void choose_cells() {
    std::array<double, 2> low{1e30, 1e30}, high{-1e30, -1e30};
    double count = 0;
    for (const FaceBox& box : boxes_) {
      if (box.is_empty()) continue;
      ++count;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], box.low[axis]);
        high[axis] = std::max(high[axis], box.high[axis]);
      }
    }
    if (count == 0) low = high = {0, 0};
    const double margin = 1e-3;  // so that points just beside an edge have a cell
    const double across = high[0] - low[0] + 2 * margin, down = high[1] - low[1] + 2 * margin;
    side_ = std::max(std::sqrt(2 * across * down / std::max(count, 1.0)), 1e-3 * std::max(across, down));
    origin_ = {low[0] - margin, low[1] - margin};
    columns_ = static_cast<std::size_t>(across / side_) + 1;
    rows_ = static_cast<std::size_t>(down / side_) + 1;
  }

  [[nodiscard]] std::size_t cell_of(double column, double row) const {
    const double x = (column - origin_[0]) / side_, y = (row - origin_[1]) / side_;
    if (!(x >= 0 && y >= 0 && x < static_cast<double>(columns_) && y < static_cast<double>(rows_)))
      return no_cell;
    return static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x);
  }

  struct Found {
    std::uint32_t cell;
    Entry entry;
  };

  /// Lists the cells that a face may touch.
  void list_face(std::size_t face, const FaceBox& box, std::vector<Found>& found) const {
    const auto index = [&](double value, std::size_t axis, std::size_t count) {
      const double cell = std::max((value - origin_[axis]) / side_, 0.0);
      return std::min(static_cast<std::size_t>(cell), count - 1);
    };
    constexpr double pad = 1e-4;
    const std::size_t first_x = index(box.low[0] - pad, 0, columns_);
    const std::size_t last_x = index(box.high[0] + pad, 0, columns_);
    const std::size_t last_y = index(box.high[1] + pad, 1, rows_);
    const auto& w = weights_[face];
    const double reach = side_ / 2 + pad;
    std::array<double, 3> change;  // of each weight between a cell's middle and its corners
    for (std::size_t k = 0; k < 3; ++k) change[k] = reach * (std::abs(w[k].a) + std::abs(w[k].b));
    const Affine inverse_depth = this->inverse_depth(static_cast<std::int32_t>(face));
    const double depth_change = reach * (std::abs(inverse_depth.a) + std::abs(inverse_depth.b));
    for (std::size_t y = index(box.low[1] - pad, 1, rows_); y <= last_y; ++y) {
      for (std::size_t x = first_x; x <= last_x; ++x) {
        const double column = origin_[0] + (static_cast<double>(x) + 0.5) * side_;
        const double row = origin_[1] + (static_cast<double>(y) + 0.5) * side_;
        const double w0 = w[0].at(column, row), w1 = w[1].at(column, row), w2 = w[2].at(column, row);
        if (w0 < -change[0] || w1 < -change[1] || w2 < -change[2]) continue;
        const double middle = w0 + w1 + w2;
        found.push_back(
            {static_cast<std::uint32_t>(y * columns_ + x),
             {std::min(middle + depth_change, box.inverse_depth_max),
              std::max(middle - depth_change, box.inverse_depth_min), static_cast<std::int32_t>(face)}});
      }
    }
  }

  /// Lists each cell's faces.
  void fill_cells(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view) {
    constexpr std::size_t block = 1024;
    std::vector<std::vector<Found>> found(block_count(boxes_.size(), block));
    parallel_for(found.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, boxes_.size(), block);
      for (std::size_t face = begin; face < end; ++face)
        if (!boxes_[face].is_empty() && set_weights(mesh, positions_view, face))
          list_face(face, boxes_[face], found[index]);
    });
    begin_.assign(columns_ * rows_ + 1, 0);
    for (const auto& part : found)
      for (const Found& one : part) ++begin_[one.cell + 1];
    for (std::size_t cell = 0; cell + 1 < begin_.size(); ++cell) begin_[cell + 1] += begin_[cell];
    entries_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (const auto& part : found)
      for (const Found& one : part) entries_[next[one.cell]++] = one.entry;
    sort_cells();
  }

  void sort_cells() {
    constexpr std::size_t block = 1024;
    parallel_for(block_count(cell_count(), block), [&](std::size_t index) {
      const auto [first, last] = block_range(index, cell_count(), block);
      for (std::size_t cell = first; cell < last; ++cell) {
        const auto at = [&](std::size_t i) { return entries_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::sort(at(begin_[cell]), at(begin_[cell + 1]), [](const Entry& a, const Entry& b) {
          return a.inverse_depth_max != b.inverse_depth_max ? a.inverse_depth_max > b.inverse_depth_max
                                                            : a.face < b.face;
        });
      }
    });
  }

  PixelRays rays_;
  std::array<double, 2> limits_;
  std::vector<std::array<Affine, 3>> weights_;
  std::vector<std::int8_t> winding_;
  std::vector<FaceBox> boxes_;
  std::array<double, 2> origin_{0, 0};
  double side_ = 1;
  std::size_t columns_ = 1;
  std::size_t rows_ = 1;
  std::vector<std::size_t> begin_;
  std::vector<Entry> entries_;
};

}  // namespace tapestry::raster
