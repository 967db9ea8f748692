#pragma once
#include <complex>
#include <numbers>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/platform/memory.hpp>

namespace tapestry::image {
namespace detail {
/// Complex numbers side by side, one of each of some transforms.
template <std::floating_point T>
struct FourierLanes {
  static constexpr std::size_t count = 64 / sizeof(T);
  std::array<T, count> real{}, imaginary{};

  void set(std::size_t lane, const std::complex<T>& value) {
    real[lane] = value.real();
    imaginary[lane] = value.imag();
  }
  [[nodiscard]] std::complex<T> at(std::size_t lane) const { return {real[lane], imaginary[lane]}; }
};
}  // namespace detail

/// The discrete Fourier transform of n numbers, F[k] = Σ f[x] · exp(−2πi k·x/n), in n·p steps for each prime
/// factor p of n; two factors 2 are one step. It transforms several rows of numbers at once, so that a
/// processor's vectors are full whatever the factors. It is our own because compilers take seconds for
/// Eigen's.
/// Source: Cooley and Tukey, "An algorithm for the machine calculation of complex Fourier series" (1965).
template <std::floating_point T>
class FourierAxis {
 public:
  using ComplexNumber = std::complex<T>;
  using Lanes = detail::FourierLanes<T>;

  explicit FourierAxis(std::size_t n) : roots_(n) {
    for (std::size_t k = 0; k < n; ++k)
      roots_[k] = ComplexNumber(
          std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n)));
    std::size_t rest = n;
    for (; rest % 4 == 0; rest /= 4) factors_.push_back(4);
    for (std::size_t factor = 2; rest > 1; rest % factor == 0 ? rest /= factor : ++factor)
      if (rest % factor == 0) factors_.push_back(factor);
  }

  /// \param to  n values, elsewhere than `from`
  void forward(const Lanes* from, Lanes* to) const {
    std::vector<Lanes> terms(factors_.empty() ? 0 : *std::ranges::max_element(factors_));
    part(from, to, roots_.size(), 0, terms.data());
  }
  /// f[x] = 1/n Σ F[k] · exp(2πi k·x/n)
  void inverse(const Lanes* from, Lanes* to) const {
    const std::size_t n = roots_.size();
    forward(from, to);
    std::reverse(to + 1, to + n);
    const auto share = static_cast<T>(n);
    for (std::size_t x = 0; x < n; ++x)
      for (std::size_t i = 0; i < Lanes::count; ++i) {
        to[x].real[i] /= share;
        to[x].imaginary[i] /= share;
      }
  }

 private:
  /// Transforms n values, every (whole/n)-th from `from` on, by the factors from `depth` on; joins in terms.
  void part(const Lanes* from, Lanes* to, std::size_t n, std::size_t depth, Lanes* terms) const {
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
        part(from + q * step, to + q * length, length, depth + 1, terms);
    for (std::size_t k = 0; k < length; ++k)
      if (factor == 4)
        join_four(to + k, length, k * step);
      else
        join(to + k, length, factor, k, step, terms);
  }

  /// Numbers turned by a root.
  static Lanes turned(const Lanes& term, const ComplexNumber& root) {
    const T real = root.real(), imaginary = root.imag();
    Lanes product;
    for (std::size_t i = 0; i < Lanes::count; ++i) {
      product.real[i] = term.real[i] * real - term.imaginary[i] * imaginary;
      product.imaginary[i] = term.real[i] * imaginary + term.imaginary[i] * real;
    }
    return product;
  }

  /// join() of four transforms, where a quarter of a turn is an exchange.
  void join_four(Lanes* to, std::size_t length, std::size_t turn) const {
    const Lanes a = to[0], b = turned(to[length], roots_[turn]), c = turned(to[2 * length], roots_[2 * turn]),
                d = turned(to[3 * length], roots_[3 * turn]);
    for (std::size_t i = 0; i < Lanes::count; ++i) {
      to[0].real[i] = (a.real[i] + c.real[i]) + (b.real[i] + d.real[i]);
      to[2 * length].real[i] = (a.real[i] + c.real[i]) - (b.real[i] + d.real[i]);
      to[length].real[i] = (a.real[i] - c.real[i]) + (b.imaginary[i] - d.imaginary[i]);
      to[3 * length].real[i] = (a.real[i] - c.real[i]) - (b.imaginary[i] - d.imaginary[i]);
    }
    for (std::size_t i = 0; i < Lanes::count; ++i) {
      to[0].imaginary[i] = (a.imaginary[i] + c.imaginary[i]) + (b.imaginary[i] + d.imaginary[i]);
      to[2 * length].imaginary[i] = (a.imaginary[i] + c.imaginary[i]) - (b.imaginary[i] + d.imaginary[i]);
      to[length].imaginary[i] = (a.imaginary[i] - c.imaginary[i]) - (b.real[i] - d.real[i]);
      to[3 * length].imaginary[i] = (a.imaginary[i] - c.imaginary[i]) + (b.real[i] - d.real[i]);
    }
  }

  /// Joins the values k of `factor` transforms of `length` values, which stand one behind the other.
  void join(Lanes* to, std::size_t length, std::size_t factor, std::size_t k, std::size_t step,
            Lanes* terms) const {
    const std::size_t whole = roots_.size();
    for (std::size_t q = 0; q < factor; ++q) terms[q] = to[q * length];
    for (std::size_t j = 0; j < factor; ++j) {
      Lanes sum = terms[0];
      const std::size_t pace = (k + j * length) * step;
      for (std::size_t q = 1, turn = pace; q < factor; ++q, turn += pace) {
        if (turn >= whole) turn -= whole;
        const Lanes term = turned(terms[q], roots_[turn]);
        for (std::size_t i = 0; i < Lanes::count; ++i) {
          sum.real[i] += term.real[i];
          sum.imaginary[i] += term.imaginary[i];
        }
      }
      to[j * length] = sum;
    }
  }

  std::vector<ComplexNumber> roots_;  ///< exp(−2πi k/n)
  std::vector<std::size_t> factors_{};
};

/// The discrete Fourier transform of real planes of one extent, [H, W] row by row, periodic at their borders:
///
///   F[k, l] = Σ f[y, x] · exp(−2πi (k·y/H + l·x/W))
///
/// Only the columns l = 0 … W/2 of F are kept, [H, W/2 + 1]; the others are conj F[−k, −l]. It runs on all
/// threads, and fast where H and W have no large prime factors, see fourier_extent().
template <std::floating_point T>
class FourierTransform {
 public:
  using Plane = std::vector<T, platform::PageAllocator<T>>;
  using ComplexNumber = std::complex<T>;
  using Spectrum = std::vector<ComplexNumber, platform::PageAllocator<ComplexNumber>>;
  using Lanes = detail::FourierLanes<T>;

  /// \throws DomainError for a plane without rows or columns, or with more than 2³⁰ along an axis
  FourierTransform(std::size_t height, std::size_t width)
      : height_(checked(height, height, width)),
        width_(checked(width, height, width)),
        across_(width),
        down_(height) {}

  [[nodiscard]] std::size_t height() const { return height_; }
  [[nodiscard]] std::size_t width() const { return width_; }
  /// W/2 + 1
  [[nodiscard]] std::size_t spectrum_width() const { return width_ / 2 + 1; }

  /// \param plane  f, of H·W values
  /// \returns      F, of H·(W/2 + 1) values
  /// \throws ShapeError for another number of values
  [[nodiscard]] Spectrum forward(const Plane& plane) const {
    require_size("forward", plane.size(), height_ * width_);
    Spectrum spectrum(height_ * spectrum_width());
    for_each_group(block_count(height_, 2), width_, [&](std::size_t first, Lanes* given, Lanes* made) {
      take_pairs_of_rows(plane, 2 * first, given);
      across_.forward(given, made);
      for (std::size_t i = 0; i < Lanes::count && 2 * (first + i) < height_; ++i) {
        const std::size_t row = 2 * (first + i);
        const bool is_pair = row + 1 < height_;
        for (std::size_t l = 0; l < spectrum_width(); ++l) {
          const ComplexNumber here = made[l].at(i), mirrored = std::conj(made[(width_ - l) % width_].at(i));
          const ComplexNumber sum = (here + mirrored) / T(2), difference = (here - mirrored) / T(2);
          spectrum[row * spectrum_width() + l] = sum;
          if (is_pair) spectrum[(row + 1) * spectrum_width() + l] = {difference.imag(), -difference.real()};
        }
      }
    });
    transform_columns(spectrum, &FourierAxis<T>::forward);
    return spectrum;
  }

  /// The plane of a spectrum. Parts that no real plane has, such as an imaginary part of F[0, 0], are left
  /// out.
  ///
  /// \param spectrum  F, of H·(W/2 + 1) values
  /// \returns         f, of H·W values
  /// \throws ShapeError for another number of values
  [[nodiscard]] Plane inverse(Spectrum spectrum) const {
    require_size("inverse", spectrum.size(), height_ * spectrum_width());
    transform_columns(spectrum, &FourierAxis<T>::inverse);
    Plane plane(height_ * width_);
    for_each_group(block_count(height_, 2), width_, [&](std::size_t first, Lanes* given, Lanes* made) {
      take_pairs_of_spectra(spectrum, 2 * first, given);
      across_.inverse(given, made);
      for (std::size_t i = 0; i < Lanes::count && 2 * (first + i) < height_; ++i) {
        T* const row = plane.data() + 2 * (first + i) * width_;
        for (std::size_t x = 0; x < width_; ++x) row[x] = made[x].real[i];
        if (2 * (first + i) + 1 < height_)
          for (std::size_t x = 0; x < width_; ++x) row[width_ + x] = made[x].imaginary[i];
      }
    });
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

  /// Calls body(first, given, made) for groups of `count` transforms of `extent` numbers, with memory for
  /// both.
  template <class Body>
  static void for_each_group(std::size_t count, std::size_t extent, Body body) {
    constexpr std::size_t groups = 4;
    parallel_for_blocks(count, groups * Lanes::count, [&](std::size_t begin, std::size_t end) {
      std::vector<Lanes, platform::PageAllocator<Lanes>> given(extent), made(extent);
      for (std::size_t first = begin; first < end; first += Lanes::count)
        body(first, given.data(), made.data());
    });
  }

  /// Two rows as one, f + ig, in each lane. Lanes without rows stay unchanged.
  void take_pairs_of_rows(const Plane& plane, std::size_t first, Lanes* given) const {
    for (std::size_t i = 0; i < Lanes::count && first + 2 * i < height_; ++i) {
      const T* const row = plane.data() + (first + 2 * i) * width_;
      const bool is_pair = first + 2 * i + 1 < height_;
      for (std::size_t x = 0; x < width_; ++x) given[x].set(i, {row[x], is_pair ? row[width_ + x] : 0});
    }
  }

  /// The rows of two spectra as one, F + iG, in each lane; of real rows, so that F[−l] is conj F[l].
  void take_pairs_of_spectra(const Spectrum& spectrum, std::size_t first, Lanes* given) const {
    const std::size_t count = spectrum_width();
    for (std::size_t i = 0; i < Lanes::count && first + 2 * i < height_; ++i) {
      const ComplexNumber* const f = spectrum.data() + (first + 2 * i) * count;
      const ComplexNumber* const g = first + 2 * i + 1 < height_ ? f + count : nullptr;
      for (std::size_t l = 0; l < count; ++l) {
        const bool is_own_mirror = l == (width_ - l) % width_;
        const ComplexNumber own = is_own_mirror ? f[l].real() : f[l];
        const ComplexNumber other = g == nullptr ? 0 : is_own_mirror ? g[l].real() : g[l];
        given[l].set(i, {own.real() - other.imag(), own.imag() + other.real()});
        if (!is_own_mirror) given[width_ - l].set(i, {own.real() + other.imag(), other.real() - own.imag()});
      }
    }
  }

  void transform_columns(Spectrum& spectrum,
                         void (FourierAxis<T>::*transform)(const Lanes*, Lanes*) const) const {
    const std::size_t count = spectrum_width();
    for_each_group(count, height_, [&](std::size_t first, Lanes* given, Lanes* made) {
      const std::size_t columns = std::min(Lanes::count, count - first);
      for (std::size_t k = 0; k < height_; ++k)
        for (std::size_t i = 0; i < columns; ++i) given[k].set(i, spectrum[k * count + first + i]);
      (down_.*transform)(given, made);
      for (std::size_t k = 0; k < height_; ++k)
        for (std::size_t i = 0; i < columns; ++i) spectrum[k * count + first + i] = made[k].at(i);
    });
  }

  std::size_t height_, width_;
  FourierAxis<T> across_, down_;
};

/// The least extent from `extent` on, at least 1, without prime factors above 7. A transform takes as many
/// operations a value as the sum of its prime factors.
[[nodiscard]] inline std::size_t fourier_extent(std::size_t extent) {
  constexpr std::size_t largest_factor = 7;
  for (std::size_t candidate = extent == 0 ? 1 : extent;; ++candidate) {
    std::size_t rest = candidate;
    for (std::size_t factor = 2; factor <= largest_factor && rest > 1; ++factor)
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return candidate;
  }
}
}  // namespace tapestry::image
