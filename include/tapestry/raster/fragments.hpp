#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/barycentric.hpp>
#include <tapestry/raster/visibility.hpp>
#include <vector>

namespace tapestry::raster {

/// What a pixel shows of one face.
struct Fragment {
  std::size_t pixel;  ///< row · width + column
  std::int32_t face;
  double coverage;                    ///< share of the pixel's samples, in (0, 1]
  std::array<double, 3> barycentric;  ///< perspective-correct, mean over those samples
};

/// Whether the samples of one face in one pixel make one fragment together, or one each.
enum class FragmentGrain { face, sample };

/// Visits the fragments of a view: pixels in order, and within a pixel faces in the order of their first
/// samples. All that a picture, its texture gradient and a silhouette need follows from this list.
class FragmentWalk {
 public:
  FragmentWalk(const VisibilityBuffer& buffer, const geometry::Mesh& mesh,
               const std::vector<geometry::Vector3>& positions_view, const geometry::Camera& camera,
               FragmentGrain grain)
      : buffer_(buffer),
        mesh_(mesh),
        positions_view_(positions_view),
        barycentric_(camera, buffer.height * buffer.samples_per_axis, buffer.width * buffer.samples_per_axis),
        grain_(grain) {}

  /// Calls visit(fragment) for the fragments of pixel rows begin … end − 1. Different rows may be
  /// walked at the same time.
  template <class Visit>
  void walk(std::size_t row_begin, std::size_t row_end, Visit visit) const {
    Barycentric barycentric = barycentric_;
    for (std::size_t row = row_begin; row < row_end; ++row) {
      for (std::size_t column = 0; column < buffer_.width; ++column) {
        if (touches_mesh(row, column)) walk_pixel(row, column, barycentric, visit);
      }
    }
  }

 private:
  [[nodiscard]] bool touches_mesh(std::size_t row, std::size_t column) const {
    const std::size_t axis = buffer_.samples_per_axis, columns = buffer_.width * axis;
    for (std::size_t y = 0; y < axis; ++y) {
      const std::int32_t* const faces = buffer_.face.data() + (row * axis + y) * columns + column * axis;
      for (std::size_t x = 0; x < axis; ++x) {
        if (faces[x] >= 0) return true;
      }
    }
    return false;
  }

  template <class Visit>
  void walk_pixel(std::size_t row, std::size_t column, Barycentric& barycentric, Visit& visit) const {
    const std::size_t axis = buffer_.samples_per_axis, columns = buffer_.width * axis;
    const double share = 1.0 / static_cast<double>(axis * axis);
    std::array<std::int32_t, 64> face;
    for (std::size_t s = 0; s < axis * axis; ++s) {
      face[s] = buffer_.face[(row * axis + s / axis) * columns + column * axis + s % axis];
    }
    for (std::size_t s = 0; s < axis * axis; ++s) {
      if (face[s] < 0) continue;
      barycentric.select(mesh_, positions_view_, face[s]);
      Fragment fragment{row * buffer_.width + column, face[s], 0, {0, 0, 0}};
      std::size_t count = 0;
      for (std::size_t other = s; other < axis * axis; ++other) {
        if (face[other] != fragment.face) continue;
        if (other != s) face[other] = -1;
        const auto b = barycentric.at(row * axis + other / axis, column * axis + other % axis);
        if (grain_ == FragmentGrain::sample) {
          visit(Fragment{fragment.pixel, fragment.face, share, b});
        }
        for (std::size_t k = 0; k < 3; ++k) fragment.barycentric[k] += b[k];
        ++count;
      }
      if (grain_ == FragmentGrain::sample) continue;
      for (double& value : fragment.barycentric) value /= static_cast<double>(count);
      fragment.coverage = share * static_cast<double>(count);
      visit(static_cast<const Fragment&>(fragment));
    }
  }

  const VisibilityBuffer& buffer_;
  const geometry::Mesh& mesh_;
  const std::vector<geometry::Vector3>& positions_view_;
  Barycentric barycentric_;
  FragmentGrain grain_;
};

/// All fragments of a view, in the order of FragmentWalk.
[[nodiscard]] inline std::vector<Fragment> fragments(const VisibilityBuffer& buffer,
                                                     const geometry::Mesh& mesh,
                                                     const geometry::Camera& camera,
                                                     FragmentGrain grain = FragmentGrain::face) {
  const auto positions_view = positions_in_view(mesh, camera);
  std::vector<Fragment> result;
  FragmentWalk(buffer, mesh, positions_view, camera, grain)
      .walk(0, buffer.height, [&](const Fragment& fragment) { result.push_back(fragment); });
  return result;
}

}  // namespace tapestry::raster
