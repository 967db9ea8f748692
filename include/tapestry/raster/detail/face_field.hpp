#pragma once
#include <tapestry/raster/detail/crossing_faces.hpp>
#include <tapestry/raster/detail/face_weights.hpp>
#include <tapestry/raster/detail/raster_kernels.hpp>

namespace tapestry::raster {
/// Square cells over the part of a picture that a mesh covers.
class CellGrid {
 public:
  /// A range of cells, ends included.
  struct Range {
    std::array<std::int32_t, 2> first, last;
  };

  /// Makes a cell for eight faces, as if the faces were spread evenly; fewer where they lie in more than
  /// about 16 layers, so that the lists of all cells together stay a few times as long as the number of
  /// faces.
  explicit CellGrid(const FacesInView::Extent& extent) {
    std::array<double, 2> low{0, 0}, size{0, 0};
    for (std::size_t axis = 0; extent.count > 0 && axis < 2; ++axis) {
      low[axis] = static_cast<double>(extent.box.low[axis]);
      size[axis] = static_cast<double>(extent.box.high[axis]) - low[axis];
    }
    const double margin = 2e-3;  // so that points just beside an edge have a cell
    const double across = size[0] + 2 * margin, down = size[1] + 2 * margin;
    const auto count = static_cast<double>(std::max<std::size_t>(extent.count, 1));
    const double least = std::max(8 * across * down, extent.area / 2) / count;  // px²
    side_ = std::max(std::sqrt(least), 1e-3 * std::max(across, down));
    cells_per_px_ = 1 / side_;
    origin_ = {low[0] - margin, low[1] - margin};
    columns_ = static_cast<std::int32_t>(across / side_) + 1;
    rows_ = static_cast<std::int32_t>(down / side_) + 1;
  }

  [[nodiscard]] std::size_t size() const { return index(0, rows_); }
  /// Side of a cell, in pixels.
  [[nodiscard]] double side() const { return side_; }

  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }

  /// {column, row} of a cell's middle.
  [[nodiscard]] std::array<double, 2> middle(std::int32_t x, std::int32_t y) const {
    return {origin_[0] + (static_cast<double>(x) + 0.5) * side_,
            origin_[1] + (static_cast<double>(y) + 0.5) * side_};
  }

  /// The cells that a box touches; for a box outside all cells the nearest ones.
  [[nodiscard]] Range cells_of(const std::array<double, 2>& low, const std::array<double, 2>& high) const {
    const auto cell = [&](double value, std::size_t axis, std::int32_t count) {
      const double place = (value - origin_[axis]) * cells_per_px_;
      return static_cast<std::int32_t>(std::clamp(place, 0.0, static_cast<double>(count - 1)));
    };
    return {{cell(low[0], 0, columns_), cell(low[1], 1, rows_)},
            {cell(high[0], 0, columns_), cell(high[1], 1, rows_)}};
  }

  /// Cuts a line at the borders of cells: calls visit(index, from, to) for each segment, in order. Points
  /// outside the grid are in the nearest cells.
  template <class Visit>
  void cut(const std::array<double, 2>& from, const std::array<double, 2>& to, Visit visit) const {
    std::array<std::int32_t, 2> cell = cells_of(from, from).first;
    const std::array<std::int32_t, 2> last = cells_of(to, to).first;
    std::array<double, 2> begin = from;
    while (cell != last) {
      std::array<double, 2> share{2, 2};  // of the line, up to the next cell along each axis
      for (std::size_t axis = 0; axis < 2; ++axis)
        if (cell[axis] != last[axis])
          share[axis] =
              (origin_[axis] + side_ * (cell[axis] + (cell[axis] < last[axis] ? 1 : 0)) - from[axis]) /
              (to[axis] - from[axis]);
      const std::size_t across = share[0] < share[1] ? 0 : 1;
      const double reached = std::clamp(share[across], 0.0, 1.0);
      const std::array<double, 2> end{from[0] + reached * (to[0] - from[0]),
                                      from[1] + reached * (to[1] - from[1])};
      visit(index(cell[0], cell[1]), begin, end);
      cell[across] += cell[across] < last[across] ? 1 : -1;
      begin = end;
    }
    visit(index(cell[0], cell[1]), begin, to);
  }

 private:
  std::array<double, 2> origin_{0, 0};
  double side_ = 1;
  double cells_per_px_ = 1;
  std::int32_t columns_ = 1;
  std::int32_t rows_ = 1;
};

/// The faces that rays through points of a picture meet, without the visibility buffer's snapping, but only
/// along marked lines: mark() them, then fill(). A grid of cells, each for about eight faces, cuts the lines;
/// each face is tested against the segments in its cells, and each segment lists the faces near it.
class FaceField {
 public:
  /// \param faces  must outlive this, as must seen
  /// \param seen   faces known to be seen: they are tested first
  FaceField(const FacesInView& faces, const SeenFaces& seen, const geometry::Camera& camera);

  /// Marks a line of the picture and up to 1e-5 px beside it; returns its index, which counts from 0.
  std::size_t mark(const std::array<double, 2>& from, const std::array<double, 2>& to) {
    lines_.push_back({from, to});
    return lines_.size() - 1;
  }
  [[nodiscard]] std::size_t mark_count() const { return lines_.size(); }

  /// Lists the faces near all marked lines.
  void fill();

  [[nodiscard]] const PixelRays& rays() const { return faces_.frame().rays; }
  [[nodiscard]] const FacesInView& faces() const { return faces_; }
  /// 1/z of far and near.
  [[nodiscard]] const std::array<double, 2>& limits() const { return limits_; }

  /// Weights of a face that is seen or near a line; all 0 for one that is not drawn.
  [[nodiscard]] const FaceWeights& weights(std::int32_t face) const {
    return listed_[slot_[static_cast<std::size_t>(face)]].weights;
  }
  /// 1/z of a face's plane.
  [[nodiscard]] Affine inverse_depth(std::int32_t face) const { return weights(face).inverse_depth(); }

  /// 1/z where the ray meets the face between near and far, else 0.
  [[nodiscard]] double hit(std::int32_t face, double column, double row) const {
    return weights(face).hit(column, row, limits_);
  }

  /// The first segment of a line; the others follow, up to the next line's first.
  [[nodiscard]] std::size_t first_segment(std::size_t line) const { return first_[line]; }

  /// The segment of a line that holds a point, searched from a given one on.
  /// \param place  its distance from the line's first end
  [[nodiscard]] std::size_t segment_at(std::size_t line, std::size_t segment, double place) const {
    while (segment + 1 < first_[line + 1] && place > end_[segment]) ++segment;
    return segment;
  }

  /// Calls visit(face, weights) for the faces near a line, some more than once.
  template <class Visit>
  void for_each_face_near(std::size_t line, Visit visit) const {
    for (std::size_t segment = first_[line]; segment < first_[line + 1]; ++segment)
      for (const std::uint32_t slot : near(segment)) visit(listed_[slot].face, listed_[slot].weights);
  }

  /// 1/z from which a face hides a point: the point's own and the largest rounding error.
  [[nodiscard]] static double hidden_from(double inverse_depth) {
    constexpr double rounding = 1e-9;
    return inverse_depth * (1 + rounding);
  }

  /// Finds the faces that hide points of a segment, and those seen beside them.
  /// \param step      to the points beside them, which lie at point − step and point + step
  /// \param left_out  the faces of these are ignored
  /// \param points    their place, hidden_from and the 1/z of known faces are set
  /// \param found     memory for faces
  void look(std::size_t segment, const std::array<double, 2>& step, std::span<const HalfEdge> left_out,
            LinePoints& points, std::vector<LineFace>& found) const;

  /// Whether a face is nearer at a point than 1 / inverse_depth, by more than rounding may cause.
  [[nodiscard]] bool hides(std::int32_t face, double column, double row, double inverse_depth) const {
    return hides(weights(face), column, row, inverse_depth);
  }

  [[nodiscard]] std::span<const std::int32_t> seen_in(std::size_t pixel) const { return seen_.at(pixel); }

  /// Like hider(), but tests only the faces known to be seen in the point's pixel and the four around
  /// it, and needs no mark.
  template <class Predicate>
  [[nodiscard]] std::int32_t seen_hider(double column, double row, double inverse_depth,
                                        Predicate is_left_out) const {
    constexpr std::array<std::array<double, 2>, 5> around{{{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (const auto& [right, down] : around)
      for (const std::int32_t face : seen_.at(column + right, row + down))
        if (hides(face, column, row, inverse_depth) && !is_left_out(face)) return face;
    return -1;
  }

  /// A face that hides a point of a segment and is not `is_left_out`; −1 if there is none.
  template <class Predicate>
  [[nodiscard]] std::int32_t hider(std::size_t segment, double column, double row, double inverse_depth,
                                   Predicate is_left_out) const {
    for (const std::uint32_t slot : near(segment)) {
      const auto& [weights, face] = listed_[slot];
      if (hides(weights, column, row, inverse_depth) && !is_left_out(face)) return face;
    }
    return -1;
  }

 private:
  static constexpr double margin = 1e-4;  // px; largest distance of a face near a line

  struct Line {
    std::array<double, 2> from, to;
  };
  struct Found {
    std::int32_t face;
    std::uint32_t count;  // of segments
  };
  struct Listed {
    FaceWeights weights;
    std::int32_t face = -1;
  };
  /// Results of one run of faces.
  struct Block {
    std::vector<Found> found;
    std::vector<std::uint32_t> places;  // segments among those of all cells
    std::vector<Listed> listed;
  };

  /// Slots of the faces near a segment.
  [[nodiscard]] std::span<const std::uint32_t> near(std::size_t segment) const {
    const std::uint32_t place = place_[segment];
    return {near_.data() + begin_[place], begin_[place + 1] - begin_[place]};
  }
  [[nodiscard]] bool hides(const FaceWeights& w, double column, double row, double inverse_depth) const {
    return w.hit(column, row, limits_) > hidden_from(inverse_depth);
  }

  void cut_lines();
  void deal_out(const std::vector<std::uint32_t>& cell_of_segment, const std::vector<Line>& segments);
  [[nodiscard]] std::array<std::int32_t, 2> touched(const FaceWeights& weights, std::int32_t first,
                                                    std::int32_t last, std::int32_t row) const;
  void list_face(std::size_t face, Block& block) const;
  void list_faces();
  void keep(const Listed& listed);

  const FacesInView& faces_;
  const SeenFaces& seen_;
  std::array<double, 2> limits_;
  CellGrid grid_;
  std::vector<Line> lines_;
  std::vector<std::size_t> first_;           // segment of each line, and the end
  std::vector<double> end_;                  // of each segment, from its line's first end
  std::vector<std::uint32_t> place_;         // of each segment among those of all cells
  std::vector<std::uint32_t> cell_begin_;    // first place of each cell, and the end
  std::array<std::vector<double>, 4> ends_;  // columns and rows of the segments
  std::vector<std::uint32_t> begin_;         // first near face of each place, and the end
  std::vector<std::uint32_t> near_;          // slots
  std::vector<Listed> listed_;               // the first stands for all faces that are not listed
  std::vector<std::uint32_t> slot_;          // place in listed_ of each face
};
}  // namespace tapestry::raster
