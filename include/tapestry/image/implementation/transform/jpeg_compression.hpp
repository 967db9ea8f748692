#pragma once
#include <cmath>
#include <numbers>
#include <tapestry/image/detail/transform/camera_effects.hpp>

namespace tapestry::image {
namespace detail {
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

/// An 8 × 8 matrix of rows: a block of a plane, or a transform of its rows.
template <std::floating_point T>
using JpegBlock = std::array<std::array<T, 8>, 8>;

/// a · b
template <std::floating_point T>
JpegBlock<T> block_product(const JpegBlock<T>& a, const JpegBlock<T>& b) {
  JpegBlock<T> all{};
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t k = 0; k < 8; ++k)
      for (std::size_t j = 0; j < 8; ++j) all[i][j] += a[i][k] * b[k][j];
  return all;
}

/// The steps that coefficients are rounded to, on the scale 0 … 255.
template <std::floating_point T>
JpegBlock<T> jpeg_steps(const JpegTable& table, int quality) {
  const int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
  JpegBlock<T> steps;
  for (std::size_t v = 0; v < 8; ++v)
    for (std::size_t u = 0; u < 8; ++u)
      steps[v][u] = static_cast<T>(std::clamp((table[v][u] * percent + 50) / 100, 1, 255));
  return steps;
}

/// The orthonormal discrete cosine transform of blocks, X ↦ C · X · Cᵀ, and its inverse.
template <std::floating_point T>
class CosineTransform {
 public:
  CosineTransform() {
    for (std::size_t u = 0; u < 8; ++u)
      for (std::size_t x = 0; x < 8; ++x)
        rows_[u][x] = columns_[x][u] =
            static_cast<T>(std::sqrt(u == 0 ? 0.125 : 0.25) *
                           std::cos(static_cast<double>((2 * x + 1) * u) * std::numbers::pi / 16));
  }
  [[nodiscard]] JpegBlock<T> forward(const JpegBlock<T>& block) const {
    return block_product(block_product(rows_, block), columns_);
  }
  [[nodiscard]] JpegBlock<T> inverse(const JpegBlock<T>& block) const {
    return block_product(block_product(columns_, block), rows_);
  }

 private:
  JpegBlock<T> rows_, columns_;  ///< C, Cᵀ
};

/// Luma and two chroma planes of a picture, on the scale −128 … 127, filled up to whole blocks.
template <std::floating_point T>
using JpegPlanes = std::array<Array<T, 2>, 3>;

/// Colours to luma and chroma (JFIF 1.02), and back.
template <std::floating_point T>
Matrix3<T> luma_chroma_from_colour() {
  return scaled<T>({{{0.299, 0.587, 0.114},
                     {-0.168735891647856, -0.331264108352144, 0.5},
                     {0.5, -0.418687589158345, -0.081312410841655}}},
                   255);
}

template <std::floating_point T>
Matrix3<T> colour_from_luma_chroma() {
  return scaled<T>({{{1, 0, 1.402}, {1, -0.344136286201022, -0.714136286201022}, {1, 1.772, 0}}}, 1.0 / 255);
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
    const T* const colour = picture.data() + pixel;
    const auto value = product(matrix, {colour[0], colour[1], colour[2]});
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
    for (std::size_t x = 0; x < extents[1]; ++x) {
      const auto colour = product(
          matrix, {planes[0](y, x) + 128, planes[1](y / half, x / half), planes[2](y / half, x / half)});
      std::ranges::copy(colour, &picture(y, x, 0));
    }
  });
  return picture;
}

template <std::floating_point T>
JpegBlock<T> block_at(const Array<T, 2>& plane, std::size_t y, std::size_t x) {
  JpegBlock<T> block;
  for (std::size_t i = 0; i < 8; ++i) std::copy_n(&plane(y + i, x), 8, block[i].data());
  return block;
}

template <std::floating_point T>
void set_block(const JpegBlock<T>& block, std::size_t y, std::size_t x, Array<T, 2>& plane) {
  for (std::size_t i = 0; i < 8; ++i) std::ranges::copy(block[i], &plane(y + i, x));
}

/// Calls visit(y, x) for the first pixel of each block of a plane, from several threads.
template <std::floating_point T, class Visit>
void for_each_jpeg_block(const Array<T, 2>& plane, Visit visit) {
  parallel_for(plane.shape(0) / 8, [&](std::size_t row) {
    for (std::size_t x = 0; x < plane.shape(1); x += 8) visit(row * 8, x);
  });
}

template <std::floating_point T>
void round_coefficients(JpegPlanes<T>& planes, const JpegCompression& jpeg) {
  const CosineTransform<T> cosines;
  for (std::size_t p = 0; p < 3; ++p) {
    const auto steps = jpeg_steps<T>(p == 0 ? jpeg_luma_table : jpeg_chroma_table, jpeg.quality);
    for_each_jpeg_block(planes[p], [&](std::size_t y, std::size_t x) {
      JpegBlock<T> block = cosines.forward(block_at(planes[p], y, x));
      for (std::size_t v = 0; v < 8; ++v)
        for (std::size_t u = 0; u < 8; ++u) {
          const T exact = block[v][u] / steps[v][u], whole = std::round(exact), rest = exact - whole;
          block[v][u] = (jpeg.is_rounding_smooth ? whole + rest * rest * rest : whole) * steps[v][u];
        }
      set_block(cosines.inverse(block), y, x, planes[p]);
    });
  }
}

/// Turns adjoints of the rounded planes into those of the unrounded planes, by the slopes of smooth rounding.
template <std::floating_point T>
void pull_back_rounding(const JpegPlanes<T>& before, const JpegCompression& jpeg, JpegPlanes<T>& adjoints) {
  const CosineTransform<T> cosines;
  for (std::size_t p = 0; p < 3; ++p) {
    const auto steps = jpeg_steps<T>(p == 0 ? jpeg_luma_table : jpeg_chroma_table, jpeg.quality);
    for_each_jpeg_block(before[p], [&](std::size_t y, std::size_t x) {
      const JpegBlock<T> block = cosines.forward(block_at(before[p], y, x));
      JpegBlock<T> adjoint = cosines.forward(block_at(adjoints[p], y, x));
      for (std::size_t v = 0; v < 8; ++v)
        for (std::size_t u = 0; u < 8; ++u) {
          const T exact = block[v][u] / steps[v][u], rest = exact - std::round(exact);
          adjoint[v][u] *= 3 * rest * rest;
        }
      set_block(cosines.inverse(adjoint), y, x, adjoints[p]);
    });
  }
}

/// Adjoints of the rounded planes, from the picture's; clipped channels have none.
///
/// \param before  the planes before they were rounded
template <std::floating_point T>
JpegPlanes<T> adjoints_of_planes(const JpegPlanes<T>& before, const JpegCompression& jpeg,
                                 const Array<T, 3>& out_adjoint) {
  auto rounded = before;
  round_coefficients(rounded, jpeg);
  const auto out = picture_of_jpeg(rounded, out_adjoint.shape(), jpeg);
  auto adjoints = empty_jpeg_planes<T>(out.shape(), jpeg);
  const auto to_planes = transposed(colour_from_luma_chroma<T>());
  const std::size_t half = jpeg.is_chroma_halved ? 2 : 1;
  for_each_row(out.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < out.shape(1); ++x) {
      std::array<T, 3> adjoint;
      for (std::size_t c = 0; c < 3; ++c)
        adjoint[c] = out(y, x, c) >= 0 && out(y, x, c) <= 1 ? out_adjoint(y, x, c) : T(0);
      const auto of_planes = product(to_planes, adjoint);
      adjoints[0](y, x) = of_planes[0];
      adjoints[1](y / half, x / half) += of_planes[1];
      adjoints[2](y / half, x / half) += of_planes[2];
    }
  });
  return adjoints;
}
}  // namespace detail

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
  const auto before = detail::jpeg_planes(picture, jpeg);
  auto adjoints = detail::adjoints_of_planes(before, jpeg, out_adjoint);
  detail::pull_back_rounding(before, jpeg, adjoints);
  const auto to_colours = transposed(detail::luma_chroma_from_colour<T>());
  const T share = jpeg.is_chroma_halved ? T(0.25) : T(1);
  detail::for_each_jpeg_pixel(
      picture.shape(), jpeg, [&](std::size_t pixel, std::size_t luma, std::size_t chroma) {
        const auto adjoint =
            product(to_colours, {adjoints[0].data()[luma], share * adjoints[1].data()[chroma],
                                 share * adjoints[2].data()[chroma]});
        for (std::size_t c = 0; c < 3; ++c) picture_adjoint.data()[pixel + c] += adjoint[c];
      });
}
}  // namespace tapestry::image
