#pragma once
#include <limits>
#include "objectives.hpp"

namespace tapestry::benchmarks {
/// The objectives' gradients as a person would write them, in any precision: what a tape competes with, and
/// in long double the reference of its error. Each writes to gradient, of the inputs' size, and returns the
/// objective's value.
template <class T>
T hand_adjoint(const Gmm& gmm, const T* x, T* gradient) {
  constexpr std::size_t d = Gmm::d, k = Gmm::k, factor = Gmm::factor;
  const T *const weights = x, *const means = x + k, *const factors = x + k + k * d;
  T *const weights_g = gradient, *const means_g = gradient + k, *const factors_g = gradient + k + k * d;
  std::fill_n(gradient, k + k * d + k * factor, T(0));
  std::vector<T> diagonal(k * d), diagonal_g(k * d), c(k * d), y(k * d), term(k);
  for (std::size_t j = 0; j < k; ++j)
    for (std::size_t i = 0; i < d; ++i) diagonal[j * d + i] = std::exp(factors[j * factor + i]);
  T total = 0;
  for (std::size_t p = 0; p < Gmm::points; ++p) {
    T top = -std::numeric_limits<T>::infinity();
    for (std::size_t j = 0; j < k; ++j) {
      T *const cj = c.data() + j * d, *const yj = y.data() + j * d;
      const T* const column = factors + j * factor;
      T log_determinant = 0, square = 0;
      for (std::size_t i = 0; i < d; ++i) {
        log_determinant += column[i];
        cj[i] = static_cast<T>(gmm.data[p * d + i]) - means[j * d + i];
        yj[i] = diagonal[j * d + i] * cj[i];
      }
      std::size_t below = d;
      for (std::size_t i = 0; i < d; ++i)
        for (std::size_t r = i + 1; r < d; ++r) yj[r] += column[below++] * cj[i];
      for (std::size_t i = 0; i < d; ++i) square += yj[i] * yj[i];
      term[j] = weights[j] + log_determinant - square / 2;
      top = std::max(top, term[j]);
    }
    T sum = 0;
    for (std::size_t j = 0; j < k; ++j) sum += term[j] = std::exp(term[j] - top);
    total += top + std::log(sum);
    for (std::size_t j = 0; j < k; ++j) {
      const T weight = term[j] / sum;
      const T *const cj = c.data() + j * d, *const yj = y.data() + j * d;
      const T* const column = factors + j * factor;
      T* const column_g = factors_g + j * factor;
      weights_g[j] += weight;
      std::size_t below = d;
      for (std::size_t i = 0; i < d; ++i) {
        T c_g = diagonal[j * d + i] * yj[i];
        for (std::size_t r = i + 1; r < d; ++r, ++below) {
          column_g[below] -= weight * yj[r] * cj[i];
          c_g += column[below] * yj[r];
        }
        means_g[j * d + i] += weight * c_g;
        diagonal_g[j * d + i] -= weight * yj[i] * cj[i];
        column_g[i] += weight;
      }
    }
  }
  for (std::size_t j = 0; j < k; ++j)
    for (std::size_t i = 0; i < d; ++i)
      factors_g[j * factor + i] += diagonal_g[j * d + i] * diagonal[j * d + i];
  return total;
}

template <class T>
T hand_adjoint(const Softmax&, const T* x, T* gradient) {
  T total = 0;
  for (std::size_t i = 0; i < Softmax::cells; ++i) {
    const T* const z = x + i * Softmax::classes;
    T* const g = gradient + i * Softmax::classes;
    T top = z[0], sum = 0;
    for (std::size_t j = 1; j < Softmax::classes; ++j) top = std::max(top, z[j]);
    for (std::size_t j = 0; j < Softmax::classes; ++j) sum += g[j] = std::exp(z[j] - top);
    for (std::size_t j = 0; j < Softmax::classes; ++j) g[j] /= sum;
    g[Softmax::label(i)] -= 1;
    total += top + std::log(sum) - z[Softmax::label(i)];
  }
  return total;
}

/// One axis of two boxes: their overlap, and its derivatives by centre and size of the first.
template <class T>
struct Overlap {
  T length = 0, by_centre = 0, by_size = 0;

  Overlap(T centre, T size, T other_centre, T other_size) {
    const T low = centre - size / 2, high = centre + size / 2;
    const T other_low = other_centre - other_size / 2, other_high = other_centre + other_size / 2;
    const T overlap = std::min(high, other_high) - std::max(low, other_low);
    if (!(overlap > 0)) return;
    length = overlap;
    const T by_high = high < other_high ? T(1) : T(0), by_low = low > other_low ? T(-1) : T(0);
    by_centre = by_high + by_low;
    by_size = (by_high - by_low) / 2;
  }
};

template <class T>
T hand_adjoint(const Iou& iou, const T* x, T* gradient) {
  T total = 0;
  for (std::size_t i = 0; i < Iou::boxes; ++i) {
    const T* const b = x + 4 * i;
    const double* const truth = iou.truth.data() + 4 * i;
    const T t[4] = {static_cast<T>(truth[0]), static_cast<T>(truth[1]), static_cast<T>(truth[2]),
                    static_cast<T>(truth[3])};
    const Overlap<T> across(b[0], b[2], t[0], t[2]), down(b[1], b[3], t[1], t[3]);
    const T intersection = across.length * down.length;
    const T both = b[2] * b[3] + t[2] * t[3] - intersection;
    total += 1 - intersection / both;
    const T by_intersection = -(both + intersection) / (both * both);
    const T by_area = intersection / (both * both);
    T* const g = gradient + 4 * i;
    g[0] = by_intersection * down.length * across.by_centre;
    g[1] = by_intersection * across.length * down.by_centre;
    g[2] = by_intersection * down.length * across.by_size + by_area * b[3];
    g[3] = by_intersection * across.length * down.by_size + by_area * b[2];
  }
  return total;
}

template <class T>
T hand_adjoint(const Smoothness&, const T* x, T* gradient) {
  constexpr std::size_t side = Smoothness::side, row_length = 3 * side;
  std::fill_n(gradient, side * row_length, T(0));
  T total = 0;
  for (std::size_t row = 0; row + 1 < side; ++row)
    for (std::size_t i = row_length * row; i < row_length * row + row_length - 3; ++i) {
      const T down = x[i + row_length] - x[i], right = x[i + 3] - x[i];
      total += down * down + right * right;
      gradient[i + row_length] += 2 * down;
      gradient[i + 3] += 2 * right;
      gradient[i] -= 2 * (down + right);
    }
  return total;
}

template <class T>
T hand_adjoint(const Project&, const T* x, T* gradient) {
  const T focal = static_cast<T>(1.7), at_x = static_cast<T>(.1), at_y = static_cast<T>(.2);
  const T colour[3] = {static_cast<T>(.3), static_cast<T>(.6), static_cast<T>(.9)};
  T total = 0;
  for (std::size_t i = 0; i < Project::triangles; ++i) {
    const T* const v = x + 9 * i;
    T px[3], py[3], iz[3], px_g[3] = {}, py_g[3] = {}, iz_g[3], w_g[3];
    for (std::size_t k = 0; k < 3; ++k) {
      iz[k] = 1 / v[3 * k + 2];
      px[k] = focal * v[3 * k] * iz[k];
      py[k] = focal * v[3 * k + 1] * iz[k];
    }
    const T area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
    const T w0 = ((px[1] - at_x) * (py[2] - at_y) - (px[2] - at_x) * (py[1] - at_y)) / area;
    const T w1 = ((px[2] - at_x) * (py[0] - at_y) - (px[0] - at_x) * (py[2] - at_y)) / area;
    const T w[3] = {w0, w1, 1 - w0 - w1};
    T depth = 0, mixed = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      depth += w[k] * iz[k];
      mixed += w[k] * iz[k] * colour[k];
    }
    const T result = std::tanh(mixed / depth);
    total += result;
    const T mixed_g = (1 - result * result) / depth, depth_g = -mixed_g * mixed / depth;
    for (std::size_t k = 0; k < 3; ++k) {
      w_g[k] = iz[k] * (depth_g + colour[k] * mixed_g);
      iz_g[k] = w[k] * (depth_g + colour[k] * mixed_g);
    }
    const T n0_g = (w_g[0] - w_g[2]) / area, n1_g = (w_g[1] - w_g[2]) / area;
    const T area_g = -(w0 * n0_g + w1 * n1_g);
    px_g[0] = -(py[2] - at_y) * n1_g - (py[2] - py[1]) * area_g;
    px_g[1] = (py[2] - at_y) * n0_g + (py[2] - py[0]) * area_g;
    px_g[2] = -(py[1] - at_y) * n0_g + (py[0] - at_y) * n1_g - (py[1] - py[0]) * area_g;
    py_g[0] = (px[2] - at_x) * n1_g + (px[2] - px[1]) * area_g;
    py_g[1] = -(px[2] - at_x) * n0_g - (px[2] - px[0]) * area_g;
    py_g[2] = (px[1] - at_x) * n0_g - (px[0] - at_x) * n1_g + (px[1] - px[0]) * area_g;
    for (std::size_t k = 0; k < 3; ++k) {
      T* const g = gradient + 9 * i + 3 * k;
      g[0] = focal * iz[k] * px_g[k];
      g[1] = focal * iz[k] * py_g[k];
      g[2] = -iz[k] * iz[k] * (iz_g[k] + focal * (v[3 * k] * px_g[k] + v[3 * k + 1] * py_g[k]));
    }
  }
  return total;
}

template <class T>
T hand_adjoint(const Speelpenning&, const T* x, T* gradient) {
  T product = 1;
  for (std::size_t i = 0; i < Speelpenning::count; ++i) {
    gradient[i] = product;
    product *= x[i];
  }
  T behind = 1;
  for (std::size_t i = Speelpenning::count; i-- > 0;) {
    gradient[i] *= behind;
    behind *= x[i];
  }
  return product;
}

template <class T>
T hand_adjoint(const Recurrence&, const T* x, T* gradient) {
  const T half = static_cast<T>(.5), fifth = static_cast<T>(.2);
  static thread_local std::vector<T> as(Recurrence::steps + 1),
      bs(Recurrence::steps + 1);  // kept, as tapes are
  as[0] = x[0];
  bs[0] = x[1];
  for (std::size_t i = 0; i < Recurrence::steps; ++i) {
    as[i + 1] = x[2 + i % 6] - half * as[i] * bs[i];
    bs[i + 1] = half * bs[i] + as[i + 1] * x[(i + 3) % 8] * fifth;
  }
  std::fill_n(gradient, 8, T(0));
  T a_g = 1, b_g = 1;
  for (std::size_t i = Recurrence::steps; i-- > 0;) {
    gradient[(i + 3) % 8] += b_g * as[i + 1] * fifth;
    a_g += b_g * x[(i + 3) % 8] * fifth;
    gradient[2 + i % 6] += a_g;
    b_g = half * (b_g - as[i] * a_g);
    a_g = -half * bs[i] * a_g;
  }
  gradient[0] += a_g;
  gradient[1] += b_g;
  return as.back() + bs.back();
}
}  // namespace tapestry::benchmarks
