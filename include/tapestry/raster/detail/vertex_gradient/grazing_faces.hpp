#pragma once
#include <tapestry/raster/detail/face_field.hpp>
#include <tapestry/raster/detail/fragment_scan.hpp>

namespace tapestry::raster::detail {
/// The faces of large planes that are seen nearly edge-on, in order. A grid of samples owns whole lines of
/// such a plane or none, so that a sampled integral over it may be several times too large, or 0; and all
/// faces of one plane are off the same way. Faces of curved surfaces are off in all ways, which cancels.
///
/// A face belongs to such a plane if the cosine of its normal and its rays is below 0.1, and all those faces
/// in one plane together are large, as if they lay across their rays: at least 1/25 of the picture's part
/// that faces may touch. In the picture they are thinner than eight distances of samples or two pixels, the
/// greater of the two. Thickness: their area over the side of a square of their area across the rays.
///
/// \param faces            of the view
/// \param sample_distance  px
[[nodiscard]] std::vector<std::int32_t> grazing_faces(const FacesInView& faces, double sample_distance);

/// A row or column of the picture, or a line between two of them.
struct PictureLine {
  /// From begin to end, in pixels; empty unless begin < end.
  struct Range {
    double begin, end;
  };

  std::size_t axis;  ///< 0 for a row, 1 for a column
  double place;      ///< px, from the picture's corner

  [[nodiscard]] std::array<double, 2> at(double along) const {
    return axis == 0 ? std::array<double, 2>{along, place} : std::array<double, 2>{place, along};
  }

  /// Keeps the part of a range where a function is ≥ 0.
  void keep(const Affine& function, Range& range) const {
    const auto [from, to] = std::array{at(range.begin), at(range.end)};
    const double first = function.at(from[0], from[1]), last = function.at(to[0], to[1]);
    if (first >= 0 && last >= 0) return;
    const double cut = range.begin + (range.end - range.begin) * first / (first - last);
    if (first < 0) range.begin = last < 0 ? range.end : cut;
    if (last < 0) range.end = first < 0 ? range.begin : cut;
  }
};

/// The visible parts of grazing faces along lines that cross them: of each face two columns a
/// pixel, or rows, whichever crosses it more steeply. Along a line, parts begin and end exactly where faces
/// and pixels do. So no line misses a plane, and the parts' lengths change steadily from line to line.
class GrazingSpans {
 public:
  /// None.
  GrazingSpans() = default;
  explicit GrazingSpans(const std::vector<std::int32_t>& faces);

  [[nodiscard]] std::size_t face_count() const { return faces_.size(); }
  [[nodiscard]] std::int32_t face(std::size_t index) const { return faces_[index].face; }

  /// For sliver_factor(): only faces thinner than 1e-4 px, whose own place is uncertain, count less.
  [[nodiscard]] static std::array<double, 2> sliver_step(const FaceField& field) {
    return {1e-3 * field.rays().step[0], 1e-3 * field.rays().step[1]};
  }

  /// Finds and marks the parts that no sampled face hides.
  void find(FaceField& field);

  /// Calls visit(fragment) for points of the visible part of a face, with the share of a pixel that each
  /// stands for: Gauss's rule of three points in each part; parts end where 1/z changes by a tenth.
  /// \pre find(), and the field is filled
  template <class Visit>
  void visit(const FaceField& field, std::size_t index, Visit visit) const {
    const Face& own = faces_[index];
    std::vector<Range> parts;
    for (const Span& span : own.spans) {
      const PictureLine line{own.axis, span.place};
      find_visible(field, own, span, parts);
      for (const Range& part : parts)
        for_each_point(own, line, part, [&](double along, double length) {
          const auto [column, row] = line.at(along);
          visit(Fragment{span.pixel, own.face, length / lines_a_pixel, own.weights.barycentric(column, row)});
        });
    }
  }

 private:
  using Range = PictureLine::Range;
  static constexpr double lines_a_pixel = 2;

  /// A part of a line in one pixel.
  struct Span {
    std::size_t pixel;
    double place;
    Range range;
    std::size_t line = 0;  // of the field
  };
  struct Face {
    std::int32_t face;
    std::size_t axis = 0;  // along which its lines run
    FaceWeights weights{};
    std::vector<Span> spans{};
  };

  static void find_along(const FaceField& field, const PictureLine& line, Face& own);
  static void hide(const FaceField& field, const Face& own, std::int32_t hider, const FaceWeights& weights,
                   const PictureLine& line, std::vector<Range>& parts);
  static void find_visible(const FaceField& field, const Face& own, const Span& span,
                           std::vector<Range>& parts);

  template <class Visit>
  static void for_each_point(const Face& own, const PictureLine& line, const Range& part, Visit visit) {
    const Affine depth = own.weights.inverse_depth();
    const auto [from, to] = std::array{line.at(part.begin), line.at(part.end)};
    const double first = depth.at(from[0], from[1]), last = depth.at(to[0], to[1]);
    const double middle = (part.begin + part.end) / 2, half = (part.end - part.begin) / 2;
    if (!(half > 0)) return;
    if (std::max(first, last) > 1.1 * std::min(first, last) && half > 1e-12) {
      for_each_point(own, line, {part.begin, middle}, visit);
      for_each_point(own, line, {middle, part.end}, visit);
      return;
    }
    const double apart = half * std::sqrt(0.6);
    visit(middle, half * 8 / 9);
    for (const double place : {middle - apart, middle + apart}) visit(place, half * 5 / 9);
  }

  std::vector<Face> faces_;
};
}  // namespace tapestry::raster::detail
