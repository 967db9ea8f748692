#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/core/compiled.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/raster/detail/cell_grid.hpp>
#include <tapestry/raster/detail/crossing_faces.hpp>
#include <tapestry/raster/detail/face_weights.hpp>
#include <tapestry/raster/detail/pixel_rays.hpp>
#include <tapestry/raster/faces_in_view.hpp>
#include <vector>

namespace tapestry::raster {

/// The faces that a ray through a point of a picture meets, without the visibility buffer's snapping, but
/// only along marked lines: mark() them, then fill(). Faces are found through a grid of cells about as large
/// as they are, nearest first; cells without marks take no work.
class FaceField {
 public:
  /// The face that a ray meets.
  struct Hit {
    std::int32_t face = -1;
    double inverse_depth = 0;
  };

  /// \param faces  must outlive this, as must seen
  /// \param seen   faces that are known to be seen, which are tested first
  FaceField(const FacesInView& faces, const SeenFaces& seen, const geometry::Camera& camera);

  /// Marks a line of the picture and up to 1e-5 px beside it. Several threads may mark at once.
  void mark(const std::array<double, 2>& from, const std::array<double, 2>& to);

  /// Lists the faces of all cells with marks.
  void fill();

  [[nodiscard]] const PixelRays& rays() const { return faces_.frame().rays; }
  [[nodiscard]] const FacesInView& faces() const { return faces_; }
  /// 1/z of far and near.
  [[nodiscard]] const std::array<double, 2>& limits() const { return limits_; }

  /// Weights of a face that is seen or touches a cell with marks; all 0 for one that is not drawn.
  [[nodiscard]] const FaceWeights& weights(std::int32_t face) const {
    return listed_[slot_[static_cast<std::size_t>(face)]].weights;
  }
  /// 1/z of a face's plane.
  [[nodiscard]] Affine inverse_depth(std::int32_t face) const { return weights(face).inverse_depth(); }

  /// 1/z where the ray meets the face between near and far, else 0.
  [[nodiscard]] double hit(std::int32_t face, double column, double row) const {
    return weights(face).hit(column, row, limits_);
  }

  /// The faces that rays meet at a point of a line and just beside it.
  struct Sides {
    std::int32_t hider = -1;  ///< a face that hides the point; `seen` is then not set
    std::array<Hit, 2> seen;  ///< at point − step and point + step: the nearest face, of equals the lowest
  };

  /// Side of a cell, in pixels.
  [[nodiscard]] double cell_side() const { return grid_.side(); }
  [[nodiscard]] std::uint32_t cell_of(const std::array<double, 2>& point) const {
    return place_[grid_.cell_of(point[0], point[1])];
  }
  /// The faces of a cell, nearest first.
  [[nodiscard]] std::span<const CellEntry> faces_in(std::uint32_t cell) const {
    return {entries_.data() + begin_[cell], begin_[cell + 1] - begin_[cell]};
  }

  /// Calls visit(face, weights) for the faces of the cells along a marked line, some more than once; not for
  /// those whose 1/z there is certainly less than a given one.
  template <class Visit>
  void for_each_face_along(const std::array<double, 2>& from, const std::array<double, 2>& to,
                           double inverse_depth, Visit visit) const {
    grid_.for_each_cell_along(from, to, 0, [&](std::size_t cell) {
      for (const CellEntry entry : faces_in(place_[cell])) {
        if (entry.inverse_depth_max() < inverse_depth * (1 - hiding_margin)) return;
        const Listed& listed = listed_[entry.slot()];
        visit(listed.face, listed.weights);
      }
    });
  }

  /// Keeps those of some faces that rays between two points of a line, or up to `step` beside it, may meet.
  void keep_near(const std::array<double, 2>& from, const std::array<double, 2>& to,
                 const std::array<double, 2>& step, std::span<const CellEntry> faces,
                 std::vector<CellEntry>& kept) const;

  /// Searches some faces, nearest first, for one that hides a point of a line, and for faces beside the point
  /// that are nearer than the known ones.
  /// \param inverse_depth  1/z of the line
  /// \param known          1/z of the known visible face on each side, 0 for none
  /// \param is_left_out    faces to ignore, as hiders and as seen
  template <class Predicate>
  [[nodiscard]] Sides look(std::span<const CellEntry> faces, const std::array<double, 2>& point,
                           double inverse_depth, const std::array<double, 2>& step,
                           const std::array<double, 2>& known, Predicate is_left_out) const {
    Sides sides{-1, {Hit{-1, known[0]}, Hit{-1, known[1]}}};
    const double hidden_from = inverse_depth * (1 + hiding_margin);
    for (const CellEntry entry : faces) {
      const double most = entry.inverse_depth_max();
      if (most < std::min({inverse_depth, sides.seen[0].inverse_depth, sides.seen[1].inverse_depth})) break;
      const auto& [weights, face] = listed_[entry.slot()];
      const std::array<Affine, 3>& w = weights.w;
      std::array<double, 3> at, change;
      bool is_beside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        at[k] = w[k].at(point[0], point[1]);
        change[k] = w[k].a * step[0] + w[k].b * step[1];
        is_beside = is_beside && at[k] + std::abs(change[k]) >= 0;
      }
      if (!is_beside) continue;
      if (FaceWeights::hit(at, limits_) > hidden_from && !is_left_out(face)) return {face, {}};
      for (std::size_t side = 0; side < 2; ++side) {
        const double sign = side == 0 ? -1 : 1;
        const double there = FaceWeights::hit(
            {at[0] + sign * change[0], at[1] + sign * change[1], at[2] + sign * change[2]}, limits_);
        Hit& best = sides.seen[side];
        if (there == 0 || there < best.inverse_depth) continue;
        if (there == best.inverse_depth && (best.face < 0 || face > best.face)) continue;
        if (!is_left_out(face)) best = {face, there};
      }
    }
    return sides;
  }

  /// Whether a face is nearer at a point than 1 / inverse_depth, by more than rounding may cause.
  [[nodiscard]] bool hides(std::int32_t face, double column, double row, double inverse_depth) const {
    return hides(weights(face), column, row, inverse_depth);
  }

  /// The faces known to be seen in a pixel.
  [[nodiscard]] std::span<const std::int32_t> seen_in(std::size_t pixel) const { return seen_.at(pixel); }

  /// Like hider(), but tests only the faces known to be seen in the point's pixel, and needs no mark.
  template <class Predicate>
  [[nodiscard]] std::int32_t seen_hider(double column, double row, double inverse_depth,
                                        Predicate is_left_out) const {
    for (const std::int32_t face : seen_.at(column, row))
      if (hides(face, column, row, inverse_depth) && !is_left_out(face)) return face;
    return -1;
  }

  /// A face, other than those that `is_left_out`, that hides a point; −1 if there is none.
  template <class Predicate>
  [[nodiscard]] std::int32_t hider(double column, double row, double inverse_depth,
                                   Predicate is_left_out) const {
    for (const CellEntry entry : faces_in(cell_of({column, row}))) {
      if (entry.inverse_depth_max() <= inverse_depth) return -1;
      const auto& [weights, face] = listed_[entry.slot()];
      if (hides(weights, column, row, inverse_depth) && !is_left_out(face)) return face;
    }
    return -1;
  }

 private:
  static constexpr double hiding_margin = 1e-9;  // relative error of 1/z that rounding may cause

  struct Found {
    std::uint32_t cell;
    std::uint32_t farness;  // see CellEntry
    std::int32_t face;
  };
  struct Listed {
    FaceWeights weights;
    std::int32_t face = -1;
  };
  /// Results of one run of faces.
  struct Block {
    std::vector<Found> found;
    std::vector<Listed> listed;
  };
  [[nodiscard]] bool hides(const FaceWeights& w, double column, double row, double inverse_depth) const {
    return w.hit(column, row, limits_) > inverse_depth * (1 + hiding_margin);
  }

  [[nodiscard]] bool has_marks(const CellGrid::Range& range) const;

  /// Lists the cells with marks that a face may touch.
  void list_face(std::size_t face, Block& block) const;

  /// \param cell_count  with marks
  void list_faces(std::size_t cell_count);

  void keep(const Listed& listed);

  void sort_cells();

  const FacesInView& faces_;
  const SeenFaces& seen_;
  std::array<double, 2> limits_;
  CellGrid grid_;
  std::vector<std::uint32_t> place_;  // by cell: 1 if it has marks, then its place in begin_; and a 0
  std::vector<std::uint32_t> begin_;
  std::vector<CellEntry> entries_;
  std::vector<Listed> listed_;       // the first stands for all faces that are not listed
  std::vector<std::uint32_t> slot_;  // place in listed_ of each face
};

}  // namespace tapestry::raster
