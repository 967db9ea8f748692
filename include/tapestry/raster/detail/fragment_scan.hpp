#pragma once
#include <tapestry/raster/detail/raster_kernels.hpp>

namespace tapestry::raster {
/// The part of a pixel that shows one face.
struct Fragment {
  std::size_t pixel;  ///< row · width + column
  std::int32_t face;
  double coverage;                    ///< share of the pixel's samples, in (0, 1]
  std::array<double, 3> barycentric;  ///< perspective-correct, at the mean place of those samples
};

/// Whether all samples of one face in one pixel make one fragment, or each sample makes one.
enum class FragmentGrain { face, sample };

/// A fragment in its stored form.
struct PackedFragment {
  std::uint32_t pixel;  ///< row · width + column
  std::int32_t face;
  float coverage;       ///< in (0, 1]
  float barycentric_0;  ///< the third is 1 − barycentric_0 − barycentric_1
  float barycentric_1;
};

namespace detail {
/// The fragments of a pixel row before they are visited, in separate arrays.
class FragmentRow {
 public:
  static constexpr std::size_t most_of_pixel = 64;

  void clear() { size_ = 0; }
  [[nodiscard]] std::size_t size() const { return size_; }

  /// Makes room for the fragments of so many pixels, at most `each` in every one.
  void reserve(std::size_t pixels, std::size_t each) {
    constexpr std::size_t beyond = 8;  // elements that kernels access past the last one
    const std::size_t wanted = size_ + pixels * each + beyond;
    if (wanted <= face_.size()) return;
    column_.resize(2 * wanted);
    face_.resize(2 * wanted);
    coverage_.resize(2 * wanted);
    for (auto& place : place_) place.resize(2 * wanted);
    for (auto& weight : barycentric_) weight.resize(2 * wanted);
  }

  /// \param place  {column, row} in samples
  void add(std::size_t column, std::int32_t face, float coverage, const std::array<double, 2>& place) {
    column_[size_] = static_cast<std::uint32_t>(column);
    face_[size_] = face;
    coverage_[size_] = coverage;
    place_[0][size_] = place[0];
    place_[1][size_] = place[1];
    ++size_;
  }

  /// Adds the fragments of pixels that show one face each, from rows of one sample a pixel.
  void add_samples(const std::int32_t* faces, std::size_t row, std::size_t column_begin,
                   std::size_t column_end) {
    reserve(column_end - column_begin, 1);
    std::uint32_t* const columns = column_.data();
    std::int32_t* const own = face_.data();
    std::size_t size = size_;
    for (std::size_t column = column_begin; column < column_end; ++column) {
      own[size] = faces[column];
      columns[size] = static_cast<std::uint32_t>(column);
      size += faces[column] >= 0 ? 1 : 0;
    }
    for (std::size_t i = size_; i < size; ++i) {
      coverage_[i] = 1;
      place_[0][i] = static_cast<double>(columns[i]);
      place_[1][i] = static_cast<double>(row);
    }
    size_ = size;
  }

  /// Adds the fragments of pixels that show any number of faces, see RasterKernels::scan_pixels().
  void add_faces(const SampleRows& samples, std::size_t row, std::size_t column_begin,
                 std::size_t column_end) {
    constexpr std::size_t chunk = 16;  // pixels
    for (std::size_t column = column_begin; column < column_end; column += chunk) {
      reserve(chunk, samples.axis * samples.axis);
      size_ += raster_kernels().scan_pixels(
          samples, row, column, std::min(column + chunk, column_end),
          {column_.data() + size_, face_.data() + size_, coverage_.data() + size_, place_[0].data() + size_,
           place_[1].data() + size_});
    }
  }

  void set_barycentrics(const RayGrid& rays, const geometry::Mesh& mesh,
                        const std::vector<geometry::Vector3>& positions_view) {
    const std::array<double*, 3> b{barycentric_[0].data(), barycentric_[1].data(), barycentric_[2].data()};
    raster_kernels().barycentrics(rays, mesh.faces.data(), positions_view.data(), size_, face_.data(),
                                  place_[0].data(), place_[1].data(), b.data());
  }

  template <class Visit>
  void visit(std::size_t first_pixel, Visit& visit) const {
    for (std::size_t i = 0; i < size_; ++i) {
      visit(Fragment{first_pixel + column_[i],
                     face_[i],
                     static_cast<double>(coverage_[i]),
                     {barycentric_[0][i], barycentric_[1][i], barycentric_[2][i]}});
    }
  }

  /// Appends each.
  void pack(std::size_t first_pixel, std::vector<PackedFragment>& packed) const {
    const std::size_t before = packed.size();
    packed.resize(before + size_);
    PackedFragment* const out = packed.data() + before;
    const std::uint32_t* const column = column_.data();
    const std::int32_t* const face = face_.data();
    const float* const coverage = coverage_.data();
    const double *const first = barycentric_[0].data(), *const second = barycentric_[1].data();
    const auto pixel = static_cast<std::uint32_t>(first_pixel);
    for (std::size_t i = 0, size = size_; i < size; ++i) {
      out[i] = {pixel + column[i], face[i], coverage[i], static_cast<float>(first[i]),
                static_cast<float>(second[i])};
    }
  }

 private:
  std::size_t size_ = 0;
  std::vector<std::uint32_t> column_;
  std::vector<std::int32_t> face_;
  std::vector<float> coverage_;  // counts of at most 64 samples, over a power of two: exact
  std::array<std::vector<double>, 2> place_;
  std::array<std::vector<double>, 3> barycentric_;
};

/// Turns rows of samples into fragments, pixel by pixel.
class FragmentScan {
 public:
  FragmentScan(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view,
               const geometry::Camera& camera, std::size_t height, std::size_t width,
               std::size_t samples_per_axis)
      : mesh_(mesh),
        positions_view_(positions_view),
        rays_(camera, height * samples_per_axis, width * samples_per_axis),
        width_(width),
        axis_(samples_per_axis),
        share_(1 / static_cast<float>(axis_ * axis_)) {}

  /// Finds the fragments of columns column_begin … column_end − 1 of a pixel row.
  /// \param faces  the row's samples, [samples_per_axis, width · samples_per_axis]
  const FragmentRow& scan(const std::int32_t* faces, std::size_t row, std::size_t column_begin,
                          std::size_t column_end, FragmentGrain grain) {
    fragments_.clear();
    if (grain == FragmentGrain::sample) {
      for (std::size_t column = column_begin; column < column_end; ++column) add_samples(faces, row, column);
    } else if (axis_ == 1) {
      fragments_.add_samples(faces, row, column_begin, column_end);
    } else {
      fragments_.add_faces({faces, width_ * axis_, axis_}, row, column_begin, column_end);
    }
    fragments_.set_barycentrics(rays_, mesh_, positions_view_);
    return fragments_;
  }

 private:
  /// One fragment for each sample, those of a face one after the other.
  void add_samples(const std::int32_t* faces, std::size_t row, std::size_t column) {
    std::array<std::int32_t, 64> face;
    for (std::size_t s = 0; s < axis_ * axis_; ++s)
      face[s] = faces[(s / axis_ * width_ + column) * axis_ + s % axis_];
    fragments_.reserve(1, FragmentRow::most_of_pixel);
    for (std::size_t s = 0; s < axis_ * axis_; ++s) {
      const std::int32_t own = face[s];
      if (own < 0) continue;
      for (std::size_t other = s; other < axis_ * axis_; ++other) {
        if (face[other] != own) continue;
        face[other] = -1;
        fragments_.add(column, own, share_,
                       {static_cast<double>(column * axis_ + other % axis_),
                        static_cast<double>(row * axis_ + other / axis_)});
      }
    }
  }

  const geometry::Mesh& mesh_;
  const std::vector<geometry::Vector3>& positions_view_;
  RayGrid rays_;
  std::size_t width_;
  std::size_t axis_;
  float share_;
  FragmentRow fragments_;
};
}  // namespace detail
}  // namespace tapestry::raster
