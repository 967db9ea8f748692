#pragma once
#include "bundle_adjustment.hpp"
#include "ciou.hpp"
#include "float_sum.hpp"
#include "hand_tracking.hpp"
#include "matmul_chain.hpp"

namespace tapestry::benchmarks {
// The functions that are differentiated. Each objective has
//
//   start()              seeded inputs
//   objective(x)         its value, for any scalar with arithmetic, comparisons and seeded.hpp's functions
//   hand_adjoint(objective, x, gradient)   its gradient by hand; returns its value
//
// Definitions, sizes and seeds of those in this file are those of the common set of objectives that the
// published figures of other tapes were measured on, so that ratios to a common peer compare.

/// Log-likelihood of 1,000 points under a mixture of 25 Gaussians in 10 dimensions. Inputs: weights [k],
/// means [k, d], and of each inverse covariance factor the logarithms of the diagonal, then the columns
/// below.
struct Gmm {
  static constexpr const char* name = "gmm";
  static constexpr std::size_t d = 10, k = 25, points = 1000;
  static constexpr std::size_t factor = d * (d + 1) / 2;

  std::vector<double> data = uniform(points * d, -1, 1, 7);
  [[nodiscard]] static std::vector<double> start() { return uniform(k + k * d + k * factor, -.5, .5, 8); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    const S *const weights = x, *const means = x + k, *const factors = x + k + k * d;
    std::vector<S> diagonal(k * d), log_determinant(k), term(k), c(d), y(d);
    for (std::size_t j = 0; j < k; ++j) {
      S sum = 0;
      for (std::size_t i = 0; i < d; ++i) {
        sum += factors[j * factor + i];
        diagonal[j * d + i] = exp(factors[j * factor + i]);
      }
      log_determinant[j] = sum;
    }
    S total = 0;
    for (std::size_t p = 0; p < points; ++p) {
      for (std::size_t j = 0; j < k; ++j) {
        for (std::size_t i = 0; i < d; ++i) c[i] = data[p * d + i] - means[j * d + i];
        for (std::size_t i = 0; i < d; ++i) y[i] = diagonal[j * d + i] * c[i];
        std::size_t below = d;
        for (std::size_t i = 0; i < d; ++i)
          for (std::size_t r = i + 1; r < d; ++r) y[r] += factors[j * factor + below++] * c[i];
        S square = 0;
        for (std::size_t i = 0; i < d; ++i) square += y[i] * y[i];
        term[j] = weights[j] + log_determinant[j] - 0.5 * square;
      }
      S top = term[0];
      for (std::size_t j = 1; j < k; ++j) top = larger<S>(top, term[j]);
      S sum = 0;
      for (std::size_t j = 0; j < k; ++j) sum += exp(term[j] - top);
      total += top + log(sum);
    }
    return total;
  }
};

/// Cross-entropy of the softmax of 80 logits in each of 2,000 cells.
struct Softmax {
  static constexpr const char* name = "softmax";
  static constexpr std::size_t classes = 80, cells = 2000;
  [[nodiscard]] static std::vector<double> start() { return uniform(classes * cells, -3, 3, 9); }
  [[nodiscard]] static std::size_t label(std::size_t cell) { return cell * 7 % classes; }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t i = 0; i < cells; ++i) {
      const S* const z = x + i * classes;
      S top = z[0];
      for (std::size_t j = 1; j < classes; ++j) top = larger<S>(top, z[j]);
      S sum = 0;
      for (std::size_t j = 0; j < classes; ++j) sum += exp(z[j] - top);
      total += top + log(sum) - z[label(i)];
    }
    return total;
  }
};

/// Σ 1 − IoU over 10,000 pairs of boxes (cx, cy, w, h).
struct Iou {
  static constexpr const char* name = "iou";
  static constexpr std::size_t boxes = 10000;
  std::vector<double> truth = uniform(4 * boxes, .3, .7, 10);
  [[nodiscard]] static std::vector<double> start() { return uniform(4 * boxes, .3, .7, 11); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t i = 0; i < boxes; ++i) {
      const S* const b = x + 4 * i;
      const double* const g = truth.data() + 4 * i;
      const S left = larger<S>(b[0] - b[2] / 2., S(g[0] - g[2] / 2));
      const S right = smaller<S>(b[0] + b[2] / 2., S(g[0] + g[2] / 2));
      const S top = larger<S>(b[1] - b[3] / 2., S(g[1] - g[3] / 2));
      const S bottom = smaller<S>(b[1] + b[3] / 2., S(g[1] + g[3] / 2));
      const S w = larger<S>(right - left, S(0.)), h = larger<S>(bottom - top, S(0.));
      const S intersection = w * h;
      const S both = b[2] * b[3] + g[2] * g[3] - intersection;
      total += 1. - intersection / both;
    }
    return total;
  }
};

/// Squared colour steps of a picture [256, 256, 3].
struct Smoothness {
  static constexpr const char* name = "smoothness";
  static constexpr std::size_t side = 256;
  [[nodiscard]] static std::vector<double> start() { return uniform(side * side * 3, 0, 1, 12); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t row = 0; row + 1 < side; ++row)
      for (std::size_t i = 3 * side * row; i < 3 * side * row + 3 * (side - 1); ++i) {
        const S down = x[i + 3 * side] - x[i];
        const S right = x[i + 3] - x[i];
        total += down * down + right * right;
      }
    return total;
  }
};

/// 10,000 triangles seen in perspective, and a value interpolated in each.
struct Project {
  static constexpr const char* name = "project";
  static constexpr std::size_t triangles = 10000;
  [[nodiscard]] static std::vector<double> start() {
    auto x = uniform(9 * triangles, -1, 1, 13);
    for (std::size_t i = 2; i < x.size(); i += 3) x[i] += 4;
    return x;
  }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t i = 0; i < triangles; ++i) {
      const S* const v = x + 9 * i;
      S px[3], py[3], iz[3];
      for (std::size_t k = 0; k < 3; ++k) {
        iz[k] = 1. / v[3 * k + 2];
        px[k] = 1.7 * v[3 * k] * iz[k];
        py[k] = 1.7 * v[3 * k + 1] * iz[k];
      }
      const S area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
      const S w0 = ((px[1] - .1) * (py[2] - .2) - (px[2] - .1) * (py[1] - .2)) / area;
      const S w1 = ((px[2] - .1) * (py[0] - .2) - (px[0] - .1) * (py[2] - .2)) / area;
      const S w2 = 1. - w0 - w1;
      const S z = 1. / (w0 * iz[0] + w1 * iz[1] + w2 * iz[2]);
      total += tanh(z * (w0 * iz[0] * .3 + w1 * iz[1] * .6 + w2 * iz[2] * .9));
    }
    return total;
  }
};

/// The product of 1,000 numbers.
struct Speelpenning {
  static constexpr const char* name = "speelpenning";
  static constexpr std::size_t count = 1000;
  [[nodiscard]] static std::vector<double> start() { return uniform(count, .9, 1.1, 14); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S product = 1;
    for (std::size_t i = 0; i < count; ++i) product *= x[i];
    return product;
  }
};

/// A recurrence of a million statements, each of which needs the one before.
struct Recurrence {
  static constexpr const char* name = "recurrence";
  static constexpr std::size_t steps = 500000;
  [[nodiscard]] static std::vector<double> start() { return uniform(8, .1, .9, 15); }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S a = x[0], b = x[1];
    for (std::size_t i = 0; i < steps; ++i) {
      a = x[2 + i % 6] - 0.5 * a * b;
      b = 0.5 * b + a * x[(i + 3) % 8] * 0.2;
    }
    return a + b;
  }
};

/// How often each of several threads computes an objective until it waits for the others: waking threads
/// takes as long as the smallest objectives.
inline constexpr int computations_a_wait = 8;

/// Calls visit(objective) for every objective.
template <class Visit>
void for_each_objective(Visit visit) {
  visit(Gmm());
  visit(Softmax());
  visit(Iou());
  visit(Smoothness());
  visit(Project());
  visit(Speelpenning());
  visit(Recurrence());
  visit(HandTracking());
  visit(Ciou());
  visit(MatmulChain());
  visit(Bundle());
  visit(BundleJacobian());
  visit(FloatSum());
}
}  // namespace tapestry::benchmarks
