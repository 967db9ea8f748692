#pragma once
#include <cassert>
#include <tapestry/raster/detail/fragment_scan.hpp>
#include <tapestry/raster/detail/tiled_triangles.hpp>
#include <tapestry/raster/visibility.hpp>

namespace tapestry::raster {
/// The fragments of a view whose samples are kept: pixels in order, and within a pixel faces in the order of
/// their first samples.
[[nodiscard]] inline std::vector<Fragment> fragments(const VisibilityBuffer& buffer,
                                                     const geometry::Mesh& mesh,
                                                     const geometry::Camera& camera,
                                                     FragmentGrain grain = FragmentGrain::face) {
  const auto positions_view = positions_in_view(mesh, camera);
  const std::size_t width = buffer.width, axis = buffer.samples_per_axis;
  detail::FragmentScan scan(mesh, positions_view, camera, buffer.height, width, axis);
  std::vector<Fragment> result;
  const auto add = [&](const Fragment& fragment) { result.push_back(fragment); };
  for (std::size_t row = 0; row < buffer.height; ++row)
    scan.scan(buffer.face.data() + row * width * axis * axis, row, 0, width, grain).visit(row * width, add);
  return result;
}

/// The fragments of a view without its samples. They are drawn a band of pixel rows at a time and forgotten,
/// so that memory grows with pixels and faces only; or drawn at once and kept, for a picture and its
/// derivatives. The mesh must outlive this.
class FragmentBands {
 public:
  /// \param kept  grain of the fragments to keep from the start, 48 bytes each; none: drawn when visited
  /// \throws as visibility()
  FragmentBands(const char* operation, const geometry::Mesh& mesh, const geometry::Camera& camera,
                std::size_t height, std::size_t width, std::size_t samples_per_axis,
                std::optional<FragmentGrain> kept = {})
      : mesh_(mesh),
        camera_(camera),
        height_(height),
        width_(width),
        axis_((detail::require_view(operation, camera, height, width, samples_per_axis), samples_per_axis)),
        triangles_(operation, mesh, camera, height * axis_, width * axis_, FaceCulling::none),
        scan_(mesh, triangles_.positions_view(), camera, height, width, axis_) {
    if (kept) keep(*kept);
  }
  FragmentBands(const FragmentBands&) = delete;
  FragmentBands& operator=(const FragmentBands&) = delete;

  [[nodiscard]] const geometry::Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const geometry::Camera& camera() const { return camera_; }
  [[nodiscard]] std::size_t height() const { return height_; }
  [[nodiscard]] std::size_t width() const { return width_; }
  [[nodiscard]] std::size_t samples_per_axis() const { return axis_; }
  /// Grain of the kept fragments, if there are any.
  [[nodiscard]] const std::optional<FragmentGrain>& kept_grain() const { return kept_grain_; }

  /// Bands of band_rows() pixel rows, the last one maybe of fewer.
  [[nodiscard]] std::size_t band_count() const { return triangles_.tile_rows(); }
  /// Pixel rows of a band; the last one may have fewer.
  [[nodiscard]] std::size_t band_rows() const { return tile_height / axis_; }
  /// How many faces were left out for a corner that is not finite.
  [[nodiscard]] std::size_t non_finite_faces() const { return triangles_.non_finite_faces(); }
  [[nodiscard]] const std::vector<geometry::Vector3>& positions_view() const {
    return triangles_.positions_view();
  }

  /// Calls visit(fragment) for the fragments of a band in the order of fragments(). Different bands may be
  /// visited at the same time.
  /// \pre fragments that are kept are of this grain
  template <class Visit>
  void visit_band(std::size_t band, FragmentGrain grain, Visit visit) const {
    if (kept_grain_) {
      assert(*kept_grain_ == grain);
      const auto [begin, end] = block_range(band, height_, band_rows());
      for (std::size_t row = begin; row < end; ++row)
        for (const Fragment& fragment : kept_[row]) visit(fragment);
      return;
    }
    for_each_row(band, grain, [&](std::size_t row, const detail::FragmentRow& fragments) {
      fragments.visit(row * width_, visit);
    });
  }

  /// The fragments of a band, one for each face in each pixel.
  /// \pre none are kept
  [[nodiscard]] std::vector<PackedFragment> pack_band(std::size_t band) const {
    std::vector<PackedFragment> packed;
    packed.reserve(band_rows() * width_);
    for_each_row(band, FragmentGrain::face, [&](std::size_t row, const detail::FragmentRow& fragments) {
      fragments.pack(row * width_, packed);
    });
    return packed;
  }

 private:
  void keep(FragmentGrain grain) {
    kept_.resize(height_);
    parallel_for(band_count(), [&](std::size_t band) {
      for_each_row(band, grain, [&](std::size_t row, const detail::FragmentRow& fragments) {
        const auto add = [&](const Fragment& fragment) { kept_[row].push_back(fragment); };
        kept_[row].reserve(fragments.size());
        fragments.visit(row * width_, add);
      });
    });
    kept_grain_ = grain;
    triangles_.free_triangles();
  }

  /// Draws the samples of a band, then calls use(row, fragments) for its pixel rows.
  template <class Use>
  void for_each_row(std::size_t band, FragmentGrain grain, Use use) const {
    const std::size_t tile_columns = triangles_.tile_columns(), columns = width_ * axis_;
    std::size_t first = tile_columns, last = 0;  // tiles that show something
    for (std::size_t tile = 0; tile < tile_columns; ++tile) {
      if (triangles_.is_empty(band, tile)) continue;
      first = std::min(first, tile);
      last = tile + 1;
    }
    if (first >= last) return;
    const auto [row_begin, row_end] = block_range(band, height_, band_rows());
    const std::size_t sample_rows = (row_end - row_begin) * axis_;
    const std::unique_ptr<std::int32_t[]> faces(new std::int32_t[sample_rows * columns]);
    const std::size_t begin = first * tile_width, end = std::min(last * tile_width, columns);
    for (std::size_t row = 0; row < sample_rows; ++row)
      std::fill(faces.get() + row * columns + begin, faces.get() + row * columns + end, -1);
    for (std::size_t tile = first; tile < last; ++tile)
      triangles_.draw(band, tile, faces.get() + tile * tile_width, columns);
    detail::FragmentScan scan = scan_;
    for (std::size_t row = row_begin; row < row_end; ++row)
      use(row, scan.scan(faces.get() + (row - row_begin) * axis_ * columns, row, begin / axis_, end / axis_,
                         grain));
  }

  const geometry::Mesh& mesh_;
  geometry::Camera camera_;
  std::size_t height_;
  std::size_t width_;
  std::size_t axis_;
  TiledTriangles triangles_;
  detail::FragmentScan scan_;
  std::optional<FragmentGrain> kept_grain_;
  std::vector<std::vector<Fragment>> kept_;  // of each pixel row
};

/// The fragments of a view in bands of pixel rows, within each in the order of fragments().
struct FragmentList {
  std::size_t height = 0;
  std::size_t width = 0;
  std::vector<std::vector<PackedFragment>> bands;
  std::size_t non_finite_faces = 0;  ///< faces left out since a corner is not finite
};

/// Rasterises a view and keeps one fragment for each face in each pixel, 20 bytes each.
///
/// The result has the same bits for any number of threads.
/// \throws as visibility()
[[nodiscard]] inline FragmentList list_fragments(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                 std::size_t height, std::size_t width,
                                                 std::size_t samples_per_axis = 4) {
  const FragmentBands bands("list_fragments", mesh, camera, height, width, samples_per_axis);
  FragmentList list{height, width, {}, bands.non_finite_faces()};
  list.bands.resize(bands.band_count());
  parallel_for(bands.band_count(), [&](std::size_t index) { list.bands[index] = bands.pack_band(index); });
  return list;
}
}  // namespace tapestry::raster
