#pragma once
#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/faces_in_view.hpp>
#include <vector>

namespace tapestry::raster {

/// The faces that samples of a picture show, pixel by pixel: 4 bytes a pixel and 4 for each face in each
/// pixel. A face smaller than the distance of samples may be missing.
class SeenFaces {
 public:
  /// A band of rows, whose pixels come in order.
  class Band {
   public:
    /// Pixels without faces may be left out.
    void add(std::size_t pixel, std::int32_t face) {
      const std::size_t own = pixel - first_;
      if (own + 1 == begin_.size() && face == faces_.back()) return;  // a sample of the same face
      while (begin_.size() <= own) begin_.push_back(static_cast<std::uint32_t>(faces_.size()));
      faces_.push_back(face);
    }

    /// The faces of all pixels; a face is there once for each pixel.
    [[nodiscard]] const std::vector<std::int32_t>& faces() const { return faces_; }

    /// The faces of a pixel; none if it is not in the band.
    [[nodiscard]] std::span<const std::int32_t> at(std::size_t pixel) const {
      const std::size_t own = pixel - first_;
      if (own >= begin_.size()) return {};
      const std::size_t end = own + 1 < begin_.size() ? begin_[own + 1] : faces_.size();
      return {faces_.data() + begin_[own], end - begin_[own]};
    }

    [[nodiscard]] std::size_t first_pixel() const { return first_; }
    [[nodiscard]] std::size_t end_pixel() const { return first_ + begin_.size(); }

   private:
    friend class SeenFaces;
    std::size_t first_ = 0;
    std::vector<std::uint32_t> begin_;
    std::vector<std::int32_t> faces_;
  };

  /// No seen faces: a picture of which nothing is known.
  SeenFaces() = default;

  /// \param width      of the picture
  /// \param band_rows  of each band, the last one maybe of fewer
  SeenFaces(std::size_t width, std::size_t band_rows, std::size_t band_count)
      : width_(width), band_rows_(band_rows), bands_(band_count) {
    for (std::size_t i = 0; i < band_count; ++i) bands_[i].first_ = i * band_rows * width;
  }

  [[nodiscard]] Band& band(std::size_t index) { return bands_[index]; }
  [[nodiscard]] const std::vector<Band>& bands() const { return bands_; }

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

/// The pairs of faces that may cut through each other, in order: faces without a common corner of which each
/// has points on both sides of the other one's plane. Only visible pairs are tested: both in one pixel, or
/// one in a pixel and one in its neighbour. Samples on the two sides of a visible line of intersection show
/// the two faces, unless the line is shorter than the distance of samples. If these samples lie in two
/// pixels, the pair is tested only where both pixels show at most two faces; elsewhere faces are small, and a
/// missed line is short. The result is the same for any number of threads, and wherever the mesh lies, within
/// the accuracy of doubles there.
/// \param edges  of the same mesh
[[nodiscard]] std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                                   const SeenFaces& seen);

}  // namespace tapestry::raster
