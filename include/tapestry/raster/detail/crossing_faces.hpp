#pragma once
#include <compare>
#include <tapestry/raster/faces_in_view.hpp>

namespace tapestry::raster {
/// The faces that samples of a picture show, pixel by pixel: 4 bytes a pixel, and where a pixel shows several
/// faces, 4 more and 4 for each. A face smaller than the distance of samples may be missing.
class SeenFaces {
 public:
  static constexpr std::int32_t none = -1;

  /// A band of rows, whose pixels come in order.
  class Band {
   public:
    /// Pixels without faces may be left out.
    void add(std::size_t pixel, std::int32_t face) {
      const std::size_t own = pixel - first_;
      if (own >= shown_.size()) {
        if (shown_.empty() || shown_.back() != face) list(face);
        shown_.resize(own, none);
        shown_.push_back(face);
      } else if (shown_[own] != face) {
        add_another(shown_[own], face);
      }
    }

    /// The only face of each pixel, or `none`, or for several faces a number below it that no other pixel
    /// has; trailing pixels without faces may be missing.
    [[nodiscard]] const std::vector<std::int32_t>& shown() const { return shown_; }

    /// The faces of a pixel; none if it is not in the band.
    [[nodiscard]] std::span<const std::int32_t> at(std::size_t pixel) const {
      const std::size_t own = pixel - first_;
      if (own >= shown_.size() || shown_[own] == none) return {};
      if (shown_[own] >= 0) return {shown_.data() + own, 1};
      const std::int32_t* const count = several_.data() + (several - shown_[own]);
      return {count + 1, static_cast<std::size_t>(*count)};
    }

    [[nodiscard]] std::size_t first_pixel() const { return first_; }

    /// All faces, a few more than once.
    [[nodiscard]] const std::vector<std::int32_t>& faces() const { return faces_; }

   private:
    friend class SeenFaces;
    static constexpr std::int32_t several = none - 1;  // less the place in several_

    void add_another(std::int32_t& shown, std::int32_t face) {
      if (shown < none) {
        if (several_.back() == face) return;
        list(face);
        ++several_[static_cast<std::size_t>(several - shown)];
        several_.push_back(face);
        return;
      }
      list(face);
      const auto place = static_cast<std::int32_t>(several_.size());
      several_.insert(several_.end(), {2, shown, face});
      shown = several - place;
    }

    /// Adds a face to the list unless it was one of the last.
    void list(std::int32_t face) {
      std::int32_t& last = last_[static_cast<std::size_t>(face) % last_.size()];
      if (std::exchange(last, face + 1) != face + 1) faces_.push_back(face);
    }

    std::size_t first_ = 0;
    std::vector<std::int32_t> faces_;
    std::array<std::int32_t, 256> last_{};  // faces plus 1, by their last bits
    std::vector<std::int32_t> shown_;
    std::vector<std::int32_t> several_;  // the number of a pixel's faces, then the faces
  };

  /// No seen faces: an unknown picture.
  SeenFaces() = default;

  /// \param width      of the picture
  /// \param band_rows  of each band, the last one maybe of fewer
  SeenFaces(std::size_t width, std::size_t band_rows, std::size_t band_count)
      : width_(width), band_rows_(band_rows), bands_(band_count) {
    for (std::size_t i = 0; i < band_count; ++i) bands_[i].first_ = i * band_rows * width;
  }

  [[nodiscard]] Band& band(std::size_t index) { return bands_[index]; }
  [[nodiscard]] const std::vector<Band>& bands() const { return bands_; }

  /// Calls visit(face) for all faces, some more than once.
  template <class Visit>
  void for_each_face(Visit visit) const {
    for (const Band& band : bands_)
      for (const std::int32_t face : band.faces()) visit(face);
  }

  /// The pixels of a row; the last ones may be missing.
  struct Row {
    const Band* band = nullptr;
    std::size_t first_pixel = 0;
    std::span<const std::int32_t> shown{};  ///< see Band::shown()

    /// What a pixel shows.
    [[nodiscard]] std::int32_t at(std::size_t column) const {
      return column < shown.size() ? shown[column] : none;
    }
    [[nodiscard]] std::span<const std::int32_t> faces(std::size_t column) const {
      return band->at(first_pixel + column);
    }
  };
  [[nodiscard]] Row row(std::size_t index) const {
    if (index / band_rows_ >= bands_.size()) return {};
    const Band& band = bands_[index / band_rows_];
    const std::span<const std::int32_t> shown = band.shown();
    const std::size_t begin = std::min(index % band_rows_ * width_, shown.size());
    return {&band, index * width_, shown.subspan(begin, std::min(width_, shown.size() - begin))};
  }

  /// Rows of a band, the last one maybe of fewer.
  [[nodiscard]] std::size_t band_rows() const { return band_rows_; }

  /// Width of the picture, pixels.
  [[nodiscard]] std::size_t width() const { return width_; }

  /// The faces of the pixel around a point of the picture.
  [[nodiscard]] std::span<const std::int32_t> at(double column, double row) const {
    if (!(column >= 0 && row >= 0 && column < static_cast<double>(width_))) return {};
    return at(static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column));
  }

  /// The faces of a pixel, row · width + column; none for one beyond the picture.
  [[nodiscard]] std::span<const std::int32_t> at(std::size_t pixel) const {
    const std::size_t band = width_ == 0 ? 0 : pixel / (band_rows_ * width_);
    if (band >= bands_.size()) return {};
    return bands_[band].at(pixel);
  }

 private:
  std::size_t width_ = 0;
  std::size_t band_rows_ = 1;
  std::vector<Band> bands_;
};

/// Two faces, the lower index first.
struct FacePair {
  std::int32_t first;
  std::int32_t second;
  auto operator<=>(const FacePair&) const = default;
};

/// The pairs of faces that may cut through each other, in order: faces without a common corner, each with
/// points on both sides of the other's plane. Only visible pairs are tested: both in one pixel, or one in a
/// pixel and one in its neighbour. Samples on the two sides of a visible line of intersection show the two
/// faces, unless the line is shorter than the distance of samples. If these samples lie in two pixels, the
/// pair is tested only where both pixels show at most two faces; elsewhere faces are small, and a missed line
/// is short. The result is the same for any number of threads, and wherever the mesh lies, within the
/// accuracy of doubles there.
/// \param edges  of the same mesh
[[nodiscard]] std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                                   const SeenFaces& seen);
}  // namespace tapestry::raster
