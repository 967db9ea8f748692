#pragma once
#include <algorithm>
#include <complex>
#include <cstddef>
#include <numbers>
#include <string>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::image {

/// The discrete Fourier transform of n numbers, F[k] = Σ f[x] · exp(−2πi k·x/n), in n·p steps for each prime
/// factor p of n; two factors 2 are one step. It is our own because compilers take seconds for Eigen's.
/// Source: Cooley and Tukey, "An algorithm for the machine calculation of complex Fourier series" (1965).
class FourierAxis {
 public:
  using Complex = std::complex<double>;

  explicit FourierAxis(std::size_t n) : roots_(n), terms_(n) {
    for (std::size_t k = 0; k < n; ++k)
      roots_[k] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
    std::size_t rest = n;
    for (; rest % 4 == 0; rest /= 4) factors_.push_back(4);
    for (std::size_t factor = 2; rest > 1; rest % factor == 0 ? rest /= factor : ++factor)
      if (rest % factor == 0) factors_.push_back(factor);
  }

  /// \param to  n values, elsewhere than `from`
  void forward(const Complex* from, Complex* to) { part(from, to, roots_.size(), 0); }
  /// f[x] = 1/n Σ F[k] · exp(2πi k·x/n)
  void inverse(const Complex* from, Complex* to) {
    const std::size_t n = roots_.size();
    forward(from, to);
    std::reverse(to + 1, to + n);
    for (std::size_t x = 0; x < n; ++x) to[x] /= static_cast<double>(n);
  }

 private:
  /// The transform of n values, every (whole/n)-th from `from` on, by the factors from `depth` on.
  void part(const Complex* from, Complex* to, std::size_t n, std::size_t depth) {
    const std::size_t step = roots_.size() / n;
    if (n == 1) {
      *to = *from;
      return;
    }
    const std::size_t factor = factors_[depth], length = n / factor;
    for (std::size_t q = 0; q < factor; ++q)
      if (length == 1)
        to[q] = from[q * step];
      else
        part(from + q * step, to + q * length, length, depth + 1);
    for (std::size_t k = 0; k < length; ++k)
      if (factor == 4)
        join_four(to + k, length, k * step);
      else
        join(to + k, length, factor, k, step);
  }

  [[nodiscard]] Complex turned(const Complex& term, std::size_t turn) const {
    const Complex& root = roots_[turn];
    return {term.real() * root.real() - term.imag() * root.imag(),
            term.real() * root.imag() + term.imag() * root.real()};
  }

  /// join() of four transforms, where a quarter of a turn is an exchange.
  void join_four(Complex* to, std::size_t length, std::size_t turn) const {
    const Complex a = to[0], b = turned(to[length], turn), c = turned(to[2 * length], 2 * turn),
                  d = turned(to[3 * length], 3 * turn);
    const Complex even = a + c, odd = b + d, across = a - c, along = b - d;
    to[0] = even + odd;
    to[length] = {across.real() + along.imag(), across.imag() - along.real()};
    to[2 * length] = even - odd;
    to[3 * length] = {across.real() - along.imag(), across.imag() + along.real()};
  }

  /// Joins the values k of `factor` transforms of `length` values, which stand one behind the other.
  void join(Complex* to, std::size_t length, std::size_t factor, std::size_t k, std::size_t step) {
    const std::size_t whole = roots_.size();
    for (std::size_t q = 0; q < factor; ++q) terms_[q] = to[q * length];
    for (std::size_t j = 0; j < factor; ++j) {
      Complex sum = terms_[0];
      const std::size_t pace = (k + j * length) * step;
      for (std::size_t q = 1, turn = pace; q < factor; ++q, turn += pace) {
        if (turn >= whole) turn -= whole;
        sum += turned(terms_[q], turn);
      }
      to[j * length] = sum;
    }
  }

  std::vector<Complex> roots_;  ///< exp(−2πi k/n)
  std::vector<Complex> terms_;
  std::vector<std::size_t> factors_{};
};

/// The discrete Fourier transform of real planes of one extent, [H, W] row by row, periodic at their borders:
///
///   F[k, l] = Σ f[y, x] · exp(−2πi (k·y/H + l·x/W))
///
/// Only the columns l = 0 … W/2 of F are kept, [H, W/2 + 1]; the others are conj F[−k, −l]. Each transform
/// keeps its twiddle factors and its memory for the next call, so that threads need one each. It is fast
/// where H and W have no large prime factors, see fourier_extent().
class FourierTransform {
 public:
  using Plane = std::vector<double>;
  using Complex = FourierAxis::Complex;
  using Spectrum = std::vector<Complex>;

  /// \throws DomainError for a plane without rows or columns, or with more than 2³⁰ along an axis
  FourierTransform(std::size_t height, std::size_t width)
      : height_(checked(height, height, width)),
        width_(checked(width, height, width)),
        across_(width),
        down_(height),
        given_(std::max(height, width)),
        made_(std::max(height, width)) {}

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
    for (std::size_t row = 0; row < height_; row += 2) {  // two rows as one, f + ig
      const bool is_pair = row + 1 < height_;
      for (std::size_t x = 0; x < width_; ++x)
        given_[x] = {plane[row * width_ + x], is_pair ? plane[(row + 1) * width_ + x] : 0};
      across_.forward(given_.data(), made_.data());
      for (std::size_t l = 0; l < spectrum_width(); ++l) {
        const Complex here = made_[l], mirrored = std::conj(made_[(width_ - l) % width_]);
        spectrum[row * spectrum_width() + l] = (here + mirrored) * 0.5;
        if (is_pair) spectrum[(row + 1) * spectrum_width() + l] = (here - mirrored) * Complex(0, -0.5);
      }
    }
    transform_columns(spectrum, &FourierAxis::forward);
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
    transform_columns(spectrum, &FourierAxis::inverse);
    Plane plane(height_ * width_);
    for (std::size_t row = 0; row < height_; ++row) {
      const Complex* const half = spectrum.data() + row * spectrum_width();
      for (std::size_t l = 0; l < spectrum_width(); ++l) {
        const bool is_own_mirror = l == (width_ - l) % width_;
        given_[l] = is_own_mirror ? half[l].real() : half[l];
        if (!is_own_mirror) given_[width_ - l] = std::conj(half[l]);
      }
      across_.inverse(given_.data(), made_.data());
      for (std::size_t x = 0; x < width_; ++x) plane[row * width_ + x] = made_[x].real();
    }
    return plane;
  }

 private:
  static std::size_t checked(std::size_t extent, std::size_t height, std::size_t width) {
    constexpr std::size_t most = std::size_t(1) << 30U;
    if (extent == 0 || extent > most)
      throw DomainError(
          {"FourierTransform: found ", height, " rows and ", width, " columns, expected 1 to ", most});
    return extent;
  }

  static void require_size(const char* operation, std::size_t found, std::size_t expected) {
    if (found != expected)
      throw ShapeError({"FourierTransform::", operation, ": found ", found, " values, expected ", expected});
  }

  void transform_columns(Spectrum& spectrum, void (FourierAxis::*transform)(const Complex*, Complex*)) {
    const std::size_t count = spectrum_width();
    for (std::size_t l = 0; l < count; ++l) {
      for (std::size_t k = 0; k < height_; ++k) given_[k] = spectrum[k * count + l];
      (down_.*transform)(given_.data(), made_.data());
      for (std::size_t k = 0; k < height_; ++k) spectrum[k * count + l] = made_[k];
    }
  }

  std::size_t height_, width_;
  FourierAxis across_, down_;
  Spectrum given_, made_;
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
