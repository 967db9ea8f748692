#pragma once
#include <complex>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace tapestry::image {

/// The discrete Fourier transform of real planes of one extent, [H, W] row by row, periodic at their borders:
///
///   F[k, l] = Σ f[y, x] · exp(−2πi (k·y/H + l·x/W))
///
/// Only the columns l = 0 … W/2 of F are kept, [H, W/2 + 1]; the others are conj F[−k, −l]. Each transform
/// keeps its twiddle factors and its memory for the next call, so that threads need one each. Uses kissfft,
/// which comes with Eigen; fast where H and W have no large prime factors, see fourier_extent().
class FourierTransform {
 public:
  using Plane = std::vector<double>;
  using Complex = std::complex<double>;
  using Spectrum = std::vector<Complex>;

  /// \throws DomainError for a plane without rows or columns, or with more than 2³⁰ along an axis
  FourierTransform(std::size_t height, std::size_t width) : height_(height), width_(width) {
    constexpr std::size_t most = std::size_t(1) << 30U;  // kissfft counts in int
    if (height == 0 || width == 0 || height > most || width > most)
      throw DomainError("FourierTransform: found " + std::to_string(height) + " rows and " +
                        std::to_string(width) + " columns, expected 1 to " + std::to_string(most));
    rows_.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    column_.resize(height);
    transformed_.resize(height);
  }

  [[nodiscard]] std::size_t height() const { return height_; }
  [[nodiscard]] std::size_t width() const { return width_; }
  /// W/2 + 1
  [[nodiscard]] std::size_t spectrum_width() const { return width_ / 2 + 1; }

  /// \param plane  f, of H·W values
  /// \returns      F, of H·(W/2 + 1) values
  /// \throws ShapeError for another number of values
  [[nodiscard]] Spectrum forward(const Plane& plane) {
    require_size("forward", plane.size(), height_ * width_);
    Spectrum spectrum(height_ * spectrum_width());
    for (std::size_t row = 0; row < height_; ++row)
      if (width_ == 1)  // kissfft takes no length of 1
        spectrum[row] = plane[row];
      else
        rows_.fwd(spectrum.data() + row * spectrum_width(), plane.data() + row * width_, length(width_));
    transform_columns(spectrum,
                      [&](Complex* to, const Complex* from) { columns_.fwd(to, from, length(height_)); });
    return spectrum;
  }

  /// The plane of a spectrum. Parts that no real plane has, such as an imaginary part of F[0, 0], are left
  /// out.
  ///
  /// \param spectrum  F, of H·(W/2 + 1) values
  /// \returns         f, of H·W values
  /// \throws ShapeError for another number of values
  [[nodiscard]] Plane inverse(Spectrum spectrum) {
    require_size("inverse", spectrum.size(), height_ * spectrum_width());
    transform_columns(spectrum,
                      [&](Complex* to, const Complex* from) { columns_.inv(to, from, length(height_)); });
    Plane plane(height_ * width_);
    for (std::size_t row = 0; row < height_; ++row)
      if (width_ == 1)
        plane[row] = spectrum[row].real();
      else
        rows_.inv(plane.data() + row * width_, spectrum.data() + row * spectrum_width(), length(width_));
    return plane;
  }

 private:
  static Eigen::Index length(std::size_t extent) { return static_cast<Eigen::Index>(extent); }

  static void require_size(const char* operation, std::size_t found, std::size_t expected) {
    if (found != expected)
      throw ShapeError(std::string("FourierTransform::") + operation + ": found " + std::to_string(found) +
                       " values, expected " + std::to_string(expected));
  }

  /// \param transform  takes a destination and a column
  template <std::invocable<Complex*, const Complex*> Transform>
  void transform_columns(Spectrum& spectrum, Transform transform) {
    if (height_ == 1) return;
    const std::size_t count = spectrum_width();
    for (std::size_t l = 0; l < count; ++l) {
      for (std::size_t k = 0; k < height_; ++k) column_[k] = spectrum[k * count + l];
      transform(transformed_.data(), column_.data());
      for (std::size_t k = 0; k < height_; ++k) spectrum[k * count + l] = transformed_[k];
    }
  }

  std::size_t height_, width_;
  Eigen::FFT<double> rows_, columns_;
  Spectrum column_, transformed_;
};

/// The least extent from `extent` on, at least 1, without prime factors above 127. A transform takes as many
/// operations a value as the sum of its prime factors.
[[nodiscard]] inline std::size_t fourier_extent(std::size_t extent) {
  constexpr std::size_t largest_factor = 127;
  for (std::size_t candidate = extent == 0 ? 1 : extent;; ++candidate) {
    std::size_t rest = candidate;
    for (std::size_t factor = 2; factor <= largest_factor && rest > 1; ++factor)
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return candidate;
  }
}

}  // namespace tapestry::image
