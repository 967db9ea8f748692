#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/camera_effects.hpp>
#include <tapestry/image/transform/colour_change.hpp>

namespace tapestry::image::detail {

using JpegTable = std::array<std::array<int, 8>, 8>;

inline constexpr JpegTable jpeg_luma_table{{{16, 11, 10, 16, 24, 40, 51, 61},
                                            {12, 12, 14, 19, 26, 58, 60, 55},
                                            {14, 13, 16, 24, 40, 57, 69, 56},
                                            {14, 17, 22, 29, 51, 87, 80, 62},
                                            {18, 22, 37, 56, 68, 109, 103, 77},
                                            {24, 35, 55, 64, 81, 104, 113, 92},
                                            {49, 64, 78, 87, 103, 121, 120, 101},
                                            {72, 92, 95, 98, 112, 100, 103, 99}}};

inline constexpr JpegTable jpeg_chroma_table{{{17, 18, 24, 47, 99, 99, 99, 99},
                                              {18, 21, 26, 66, 99, 99, 99, 99},
                                              {24, 26, 56, 99, 99, 99, 99, 99},
                                              {47, 66, 99, 99, 99, 99, 99, 99},
                                              {99, 99, 99, 99, 99, 99, 99, 99},
                                              {99, 99, 99, 99, 99, 99, 99, 99},
                                              {99, 99, 99, 99, 99, 99, 99, 99},
                                              {99, 99, 99, 99, 99, 99, 99, 99}}};

template <std::floating_point T>
using JpegBlock = Eigen::Array<T, 8, 8, Eigen::RowMajor>;
/// The steps that coefficients are rounded to, on the scale 0 … 255.
template <std::floating_point T>
JpegBlock<T> jpeg_steps(const JpegTable& table, int quality) {
  const int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
  JpegBlock<T> steps;
  for (int v = 0; v < 8; ++v)
    for (int u = 0; u < 8; ++u)
      steps(v, u) =
          static_cast<T>(std::clamp((table[std::size_t(v)][std::size_t(u)] * percent + 50) / 100, 1, 255));
  return steps;
}

/// The orthonormal discrete cosine transform of eight numbers; its transpose is its inverse.
template <std::floating_point T>
Eigen::Matrix<T, 8, 8> cosine_matrix() {
  Eigen::Matrix<T, 8, 8> matrix;
  for (int u = 0; u < 8; ++u)
    for (int x = 0; x < 8; ++x)
      matrix(u, x) = static_cast<T>(std::sqrt(u == 0 ? 0.125 : 0.25) *
                                    std::cos((2 * x + 1) * u * std::numbers::pi / 16));
  return matrix;
}

/// Luma and two chroma planes of a picture, on the scale −128 … 127, filled up to whole blocks.
template <std::floating_point T>
using JpegPlanes = std::array<Array<T, 2>, 3>;

/// Colours to luma and chroma (JFIF 1.02), and back.
template <std::floating_point T>
Eigen::Matrix<T, 3, 3> luma_chroma_from_colour() {
  Eigen::Matrix3d matrix;
  matrix << 0.299, 0.587, 0.114, -0.168735891647856, -0.331264108352144, 0.5, 0.5, -0.418687589158345,
      -0.081312410841655;
  return (255 * matrix).cast<T>();
}

template <std::floating_point T>
Eigen::Matrix<T, 3, 3> colour_from_luma_chroma() {
  Eigen::Matrix3d matrix;
  matrix << 1, 0, 1.402, 1, -0.344136286201022, -0.714136286201022, 1, 1.772, 0;
  return (matrix / 255).cast<T>();
}

/// Calls visit(pixel's first number, position in the luma plane, position in a chroma plane) for every place
/// of the filled-up luma plane; places beyond the picture belong to its nearest pixel. A pixel, and a
/// chroma's place, belong to one thread.
template <class Visit>
void for_each_jpeg_pixel(const Extents<3>& extents, const JpegCompression& jpeg, Visit visit) {
  const std::size_t unit = jpeg.is_chroma_halved ? 16 : 8, half = jpeg.is_chroma_halved ? 2 : 1;
  const std::size_t height = block_count(extents[0], unit) * unit,
                    width = block_count(extents[1], unit) * unit;
  for_each_row(height, [&](std::size_t y) {
    const std::size_t row = std::min(y, extents[0] - 1) * extents[1];
    for (std::size_t x = 0; x < width; ++x)
      visit((row + std::min(x, extents[1] - 1)) * 3, y * width + x, y / half * (width / half) + x / half);
  });
}

template <std::floating_point T>
JpegPlanes<T> empty_jpeg_planes(const Extents<3>& extents, const JpegCompression& jpeg) {
  const std::size_t unit = jpeg.is_chroma_halved ? 16 : 8, half = jpeg.is_chroma_halved ? 2 : 1;
  const std::size_t height = block_count(extents[0], unit) * unit,
                    width = block_count(extents[1], unit) * unit;
  return {zeros<T, 2>({height, width}), zeros<T, 2>({height / half, width / half}),
          zeros<T, 2>({height / half, width / half})};
}

template <std::floating_point T>
JpegPlanes<T> jpeg_planes(const Array<T, 3>& picture, const JpegCompression& jpeg) {
  auto planes = empty_jpeg_planes<T>(picture.shape(), jpeg);
  const auto matrix = luma_chroma_from_colour<T>();
  const T share = jpeg.is_chroma_halved ? T(0.25) : T(1);
  for_each_jpeg_pixel(picture.shape(), jpeg, [&](std::size_t pixel, std::size_t luma, std::size_t chroma) {
    const Eigen::Matrix<T, 3, 1> value =
        matrix * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(picture.data() + pixel);
    planes[0].data()[luma] = value[0] - 128;
    planes[1].data()[chroma] += share * value[1];
    planes[2].data()[chroma] += share * value[2];
  });
  return planes;
}

/// The picture decompressed from the planes, before it is clipped to 0 … 1.
template <std::floating_point T>
Array<T, 3> picture_of_jpeg(const JpegPlanes<T>& planes, const Extents<3>& extents,
                            const JpegCompression& jpeg) {
  Array<T, 3> picture(extents);
  const auto matrix = colour_from_luma_chroma<T>();
  const std::size_t half = jpeg.is_chroma_halved ? 2 : 1;
  for_each_row(extents[0], [&](std::size_t y) {
    for (std::size_t x = 0; x < extents[1]; ++x)
      Eigen::Map<Eigen::Matrix<T, 3, 1>>(&picture(y, x, 0)) =
          matrix * Eigen::Matrix<T, 3, 1>(planes[0](y, x) + 128, planes[1](y / half, x / half),
                                          planes[2](y / half, x / half));
  });
  return picture;
}

/// Calls visit(block) for the blocks of a plane, from several threads; visit may change the block.
template <std::floating_point T, class Visit>
void for_each_jpeg_block(Array<T, 2>& plane, Visit visit) {
  const std::size_t width = plane.shape(1);
  parallel_for(plane.shape(0) / 8, [&](std::size_t row) {
    for (std::size_t x = 0; x < width; x += 8) {
      Eigen::Map<JpegBlock<T>, 0, Eigen::OuterStride<>> block(
          plane.data() + row * 8 * width + x, Eigen::OuterStride<>(static_cast<Eigen::Index>(width)));
      visit(block, row * 8 * width + x);
    }
  });
}

template <std::floating_point T>
void round_coefficients(JpegPlanes<T>& planes, const JpegCompression& jpeg) {
  const auto cosines = cosine_matrix<T>();
  for (std::size_t p = 0; p < 3; ++p) {
    const auto steps = jpeg_steps<T>(p == 0 ? jpeg_luma_table : jpeg_chroma_table, jpeg.quality);
    for_each_jpeg_block(planes[p], [&](auto& block, std::size_t) {
      const JpegBlock<T> exact = (cosines * block.matrix() * cosines.transpose()).array() / steps;
      JpegBlock<T> whole = exact.round();
      if (jpeg.is_rounding_smooth) whole += (exact - whole).cube();
      block.matrix() = cosines.transpose() * (whole * steps).matrix() * cosines;
    });
  }
}

/// Turns adjoints of the rounded planes into those of the unrounded planes, by the slopes of smooth rounding.
template <std::floating_point T>
void pull_back_rounding(JpegPlanes<T>& before, const JpegCompression& jpeg, JpegPlanes<T>& adjoints) {
  const auto cosines = cosine_matrix<T>();
  for (std::size_t p = 0; p < 3; ++p) {
    const auto steps = jpeg_steps<T>(p == 0 ? jpeg_luma_table : jpeg_chroma_table, jpeg.quality);
    const Eigen::OuterStride<> stride(static_cast<Eigen::Index>(adjoints[p].shape(1)));
    for_each_jpeg_block(before[p], [&](auto& block, std::size_t first) {
      Eigen::Map<JpegBlock<T>, 0, Eigen::OuterStride<>> adjoint(adjoints[p].data() + first, stride);
      const JpegBlock<T> exact = (cosines * block.matrix() * cosines.transpose()).array() / steps;
      const JpegBlock<T> slope = 3 * (exact - exact.round()).square();
      const JpegBlock<T> of_coefficients = (cosines * adjoint.matrix() * cosines.transpose()).array() * slope;
      adjoint.matrix() = cosines.transpose() * of_coefficients.matrix() * cosines;
    });
  }
}

/// Adjoints of the rounded planes, from those of the picture; clipped channels have none.
///
/// \param before  the planes before they were rounded
template <std::floating_point T>
JpegPlanes<T> adjoints_of_planes(const JpegPlanes<T>& before, const JpegCompression& jpeg,
                                 const Array<T, 3>& out_adjoint) {
  auto rounded = before;
  round_coefficients(rounded, jpeg);
  const auto out = picture_of_jpeg(rounded, out_adjoint.shape(), jpeg);
  auto adjoints = empty_jpeg_planes<T>(out.shape(), jpeg);
  const Eigen::Matrix<T, 3, 3> to_planes = colour_from_luma_chroma<T>().transpose();
  const std::size_t half = jpeg.is_chroma_halved ? 2 : 1;
  for_each_row(out.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < out.shape(1); ++x) {
      Eigen::Matrix<T, 3, 1> adjoint;
      for (std::size_t c = 0; c < 3; ++c)
        adjoint[static_cast<Eigen::Index>(c)] =
            out(y, x, c) >= 0 && out(y, x, c) <= 1 ? out_adjoint(y, x, c) : T(0);
      const Eigen::Matrix<T, 3, 1> of_planes = to_planes * adjoint;
      adjoints[0](y, x) = of_planes[0];
      adjoints[1](y / half, x / half) += of_planes[1];
      adjoints[2](y / half, x / half) += of_planes[2];
    }
  });
  return adjoints;
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const JpegCompression& jpeg) {
  detail::require_sound(jpeg);
  detail::require_colours("transformed", picture);
  auto planes = detail::jpeg_planes(picture, jpeg);
  detail::round_coefficients(planes, jpeg);
  auto out = detail::picture_of_jpeg(planes, picture.shape(), jpeg);
  for (T& value : out.storage()) value = std::clamp(value, T(0), T(1));
  return out;
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const JpegCompression& jpeg,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  detail::require_sound(jpeg);
  detail::require_colours("transformed_adjoint", picture);
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  auto before = detail::jpeg_planes(picture, jpeg);
  auto adjoints = detail::adjoints_of_planes(before, jpeg, out_adjoint);
  detail::pull_back_rounding(before, jpeg, adjoints);
  const Eigen::Matrix<T, 3, 3> to_colours = detail::luma_chroma_from_colour<T>().transpose();
  const T share = jpeg.is_chroma_halved ? T(0.25) : T(1);
  detail::for_each_jpeg_pixel(
      picture.shape(), jpeg, [&](std::size_t pixel, std::size_t luma, std::size_t chroma) {
        Eigen::Map<Eigen::Matrix<T, 3, 1>>(picture_adjoint.data() + pixel) +=
            to_colours * Eigen::Matrix<T, 3, 1>(adjoints[0].data()[luma], share * adjoints[1].data()[chroma],
                                                share * adjoints[2].data()[chroma]);
      });
}

}  // namespace tapestry::image
