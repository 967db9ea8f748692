#pragma once
#include <tapestry/autodiff/array_functions.hpp>

namespace tapestry::test {
/// The reference of arrays: plain numbers and loops. \see ScalarStep about Wide
struct WideArray {
  using Wide = long double;

  std::size_t rows = 0, columns = 0;
  std::vector<Wide> elements{};

  /// Element (i, j), where an axis of extent 1 repeats.
  [[nodiscard]] Wide operator()(std::size_t i, std::size_t j) const {
    return elements[(rows == 1 ? 0 : i) * columns + (columns == 1 ? 0 : j)];
  }
  /// An array of f(i, j).
  template <class F>
  [[nodiscard]] static WideArray of(std::size_t rows, std::size_t columns, const F& f) {
    WideArray result{rows, columns, {}};
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j) result.elements.push_back(f(i, j));
    return result;
  }
  template <class F>
  [[nodiscard]] bool all(const F& f) const {
    return std::all_of(elements.begin(), elements.end(), f);
  }
};

/// One operation on arrays a, b of two axes and a scalar s, like ScalarStep; extents of a and b may not fit.
struct ArrayStep {
  using Wide = WideArray::Wide;
  using A = ArrayVariable<double, 2>;
  using V = Variable<double>;

  const char* text;
  bool (*fits)(const WideArray& a, const WideArray& b, Wide s);
  WideArray (*reference)(const WideArray& a, const WideArray& b, Wide s);
  A (*run)(const A& a, const A& b, const V& s);
};

/// One that makes a scalar.
struct ReductionStep {
  using Wide = WideArray::Wide;
  using A = ArrayVariable<double, 2>;
  using V = Variable<double>;

  const char* text;
  bool (*fits)(const WideArray& a, Wide s);
  Wide (*reference)(const WideArray& a, Wide s);
  V (*run)(const A& a, const V& s);
};

namespace array_steps {
using Wide = WideArray::Wide;
using A = ArrayVariable<double, 2>;
using V = Variable<double>;

template <class F>
[[nodiscard]] WideArray each(const WideArray& a, const F& f) {
  return WideArray::of(a.rows, a.columns, [&](std::size_t i, std::size_t j) { return f(a(i, j)); });
}
template <class F>
[[nodiscard]] WideArray each(const WideArray& a, const WideArray& b, const F& f) {
  return WideArray::of(std::max(a.rows, b.rows), std::max(a.columns, b.columns),
                       [&](std::size_t i, std::size_t j) { return f(a(i, j), b(i, j)); });
}
/// f of each column, as a row.
template <class F>
[[nodiscard]] WideArray each_column(const WideArray& a, const F& f) {
  return WideArray::of(1, a.columns, [&](std::size_t, std::size_t j) {
    std::vector<Wide> line;
    for (std::size_t i = 0; i < a.rows; ++i) line.push_back(a(i, j));
    return f(line);
  });
}

inline Wide sum_of(const std::vector<Wide>& line) {
  Wide total = 0;
  for (const Wide x : line) total += x;
  return total;
}
inline Wide log_sum_of(const std::vector<Wide>& line) {
  Wide total = 0;
  for (const Wide x : line) total += std::exp(x);
  return std::log(total);
}
inline Wide largest_of(const std::vector<Wide>& line) { return *std::max_element(line.begin(), line.end()); }
/// Whether the largest is apart from all others.
inline bool has_one_largest(const std::vector<Wide>& line) {
  return std::count_if(line.begin(), line.end(), [&](Wide x) { return x > largest_of(line) - 0.1L; }) == 1;
}

inline bool any(const WideArray&, const WideArray&, Wide) { return true; }
inline bool small(const WideArray& a, const WideArray&, Wide) {
  return a.all([](Wide x) { return std::abs(x) < 2; });
}
inline bool positive(const WideArray& a, const WideArray&, Wide) {
  return a.all([](Wide x) { return x > 0.3L; });
}
inline bool not_zero(const WideArray& a, const WideArray&, Wide) {
  return a.all([](Wide x) { return std::abs(x) > 0.2L; });
}
inline bool pairs(const WideArray& a, const WideArray& b) {
  const auto fit = [](std::size_t m, std::size_t n) { return m == n || m == 1 || n == 1; };
  return fit(a.rows, b.rows) && fit(a.columns, b.columns);
}
inline bool beside(const WideArray& a, const WideArray& b, Wide) { return pairs(a, b); }
inline bool apart(const WideArray& a, const WideArray& b, Wide) {
  return pairs(a, b) &&
         each(a, b, [](Wide x, Wide y) { return x - y; }).all([](Wide x) { return std::abs(x) > 0.02L; });
}
inline bool divisor(const WideArray& a, const WideArray& b, Wide s) {
  return pairs(a, b) && not_zero(b, a, s);
}
inline bool not_origin(const WideArray& a, const WideArray& b, Wide s) {
  return pairs(a, b) && (not_zero(a, b, s) || not_zero(b, a, s));
}
inline bool inner(const WideArray& a, const WideArray& b, Wide) { return a.columns == b.rows; }

[[nodiscard]] inline std::span<const ArrayStep> all() {
  using W = const WideArray&;
  using X = const A&;
  using S = const V&;
  static constexpr ArrayStep table[] = {
      {"sin(a)", any, [](W a, W, Wide) { return each(a, [](Wide x) { return std::sin(x); }); },
       [](X a, X, S) { return A(sin(a)); }},
      {"exp(a)", small, [](W a, W, Wide) { return each(a, [](Wide x) { return std::exp(x); }); },
       [](X a, X, S) { return A(exp(a)); }},
      {"tanh(a)", any, [](W a, W, Wide) { return each(a, [](Wide x) { return std::tanh(x); }); },
       [](X a, X, S) { return A(tanh(a)); }},
      {"log(a)", positive, [](W a, W, Wide) { return each(a, [](Wide x) { return std::log(x); }); },
       [](X a, X, S) { return A(log(a)); }},
      {"sqrt(a)", positive, [](W a, W, Wide) { return each(a, [](Wide x) { return std::sqrt(x); }); },
       [](X a, X, S) { return A(sqrt(a)); }},
      {"abs(a)", not_zero, [](W a, W, Wide) { return each(a, [](Wide x) { return std::abs(x); }); },
       [](X a, X, S) { return A(abs(a)); }},
      {"sigmoid(-a)", any, [](W a, W, Wide) { return each(a, [](Wide x) { return 1 / (1 + std::exp(x)); }); },
       [](X a, X, S) { return A(sigmoid(-a)); }},
      {"softplus(a)", any,
       [](W a, W, Wide) { return each(a, [](Wide x) { return std::log1p(std::exp(x)); }); },
       [](X a, X, S) { return A(softplus(a)); }},
      {"clamp(a / 3, -1, 1)",
       [](W a, W, Wide) { return a.all([](Wide x) { return std::abs(std::abs(x) - 3) > 0.05L; }); },
       [](W a, W, Wide) { return each(a, [](Wide x) { return std::min(std::max(x / 3, -1.0L), 1.0L); }); },
       [](X a, X, S) { return A(clamp(a / 3, -1, 1)); }},
      {"a + b", beside, [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return x + y; }); },
       [](X a, X b, S) { return A(a + b); }},
      {"a - b", beside, [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return x - y; }); },
       [](X a, X b, S) { return A(a - b); }},
      {"a * b", beside, [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return x * y; }); },
       [](X a, X b, S) { return A(a * b); }},
      {"a / b", divisor, [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return x / y; }); },
       [](X a, X b, S) { return A(a / b); }},
      {"max(a, b)", apart,
       [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return std::max(x, y); }); },
       [](X a, X b, S) { return A(max(a, b)); }},
      {"min(a, b)", apart,
       [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return std::min(x, y); }); },
       [](X a, X b, S) { return A(min(a, b)); }},
      {"hypot(a, b)", not_origin,
       [](W a, W b, Wide) { return each(a, b, [](Wide x, Wide y) { return std::hypot(x, y); }); },
       [](X a, X b, S) { return A(hypot(a, b)); }},
      {"a * s", any, [](W a, W, Wide s) { return each(a, [=](Wide x) { return x * s; }); },
       [](X a, X, S s) { return A(a * s); }},
      {"3 - a / (2 + s * s)", any,
       [](W a, W, Wide s) { return each(a, [=](Wide x) { return 3 - x / (2 + s * s); }); },
       [](X a, X, S s) { return A(3 - a / (2 + s * s)); }},
      {"where(a < b, a, sin(b) * s)",
       [](W a, W b, Wide s) { return apart(a, b, s) && a.rows >= b.rows && a.columns >= b.columns; },
       [](W a, W b, Wide s) {
         return each(a, b, [=](Wide x, Wide y) { return x < y ? x : std::sin(y) * s; });
       },
       [](X a, X b, S s) { return A(where(a < b, a, sin(b) * s)); }},
      {"a * b + exp(-square(a)) * s - tanh(b) / 2", beside,
       [](W a, W b, Wide s) {
         return each(a, b, [=](Wide x, Wide y) { return x * y + std::exp(-x * x) * s - std::tanh(y) / 2; });
       },
       [](X a, X b, S s) { return A(a * b + exp(-square(a)) * s - tanh(b) / 2); }},
      {"transpose(a)", any,
       [](W a, W, Wide) {
         return WideArray::of(a.columns, a.rows, [&](std::size_t i, std::size_t j) { return a(j, i); });
       },
       [](X a, X, S) { return A(transpose(a)); }},
      {"sin(transpose(a)) * s", any,
       [](W a, W, Wide s) {
         return WideArray::of(a.columns, a.rows,
                              [&](std::size_t i, std::size_t j) { return std::sin(a(j, i)) * s; });
       },
       [](X a, X, S s) { return A(sin(transpose(a)) * s); }},
      {"slice(a, {{{0, 9, 2}, {1}}}) * 2", [](W a, W, Wide) { return a.columns > 1; },
       [](W a, W, Wide) {
         return WideArray::of((std::min<std::size_t>(a.rows, 9) + 1) / 2, a.columns - 1,
                              [&](std::size_t i, std::size_t j) { return 2 * a(2 * i, j + 1); });
       },
       [](X a, X, S) {
         return A(slice(a, {{{0, 9, 2}, {1}}}) * 2);
       }},
      {"matmul(a, b) / 8", inner,
       [](W a, W b, Wide) {
         return WideArray::of(a.rows, b.columns, [&](std::size_t i, std::size_t j) {
           Wide total = 0;
           for (std::size_t k = 0; k < a.columns; ++k) total += a(i, k) * b(k, j);
           return total / 8;
         });
       },
       [](X a, X b, S) { return A(matmul(a, b) / 8); }},
      {"reshape<2>(sum_along(a, 0), {1, a.shape()[1]}) / 4", any,
       [](W a, W, Wide) { return each_column(a, [](const auto& line) { return sum_of(line) / 4; }); },
       [](X a, X, S) {
         return A(reshape<2>(sum_along(a, 0), {1, a.shape()[1]}) / 4);
       }},
      {"reshape<2>(logsumexp_along(a, 0), {1, a.shape()[1]})", any,
       [](W a, W, Wide) { return each_column(a, log_sum_of); },
       [](X a, X, S) {
         return A(reshape<2>(logsumexp_along(a, 0), {1, a.shape()[1]}));
       }},
      {"reshape<2>(largest_along(a, 0), {1, a.shape()[1]})",
       [](W a, W, Wide) {
         return each_column(a, [](const auto& line) { return Wide(has_one_largest(line)); }).all([](Wide x) {
           return x != 0;
         });
       },
       [](W a, W, Wide) { return each_column(a, largest_of); },
       [](X a, X, S) {
         return A(reshape<2>(largest_along(a, 0), {1, a.shape()[1]}));
       }},
      {"softmax_along(a, 1)", any,
       [](W a, W, Wide) {
         return WideArray::of(a.rows, a.columns, [&](std::size_t i, std::size_t j) {
           Wide total = 0;
           for (std::size_t k = 0; k < a.columns; ++k) total += std::exp(a(i, k) - a(i, j));
           return 1 / total;
         });
       },
       [](X a, X, S) { return A(softmax_along(a, 1)); }},
      {"a + sum_along(select(a, 0, 0), 0) / 8", any,
       [](W a, W, Wide) {
         Wide total = 0;
         for (std::size_t j = 0; j < a.columns; ++j) total += a(0, j);
         return each(a, [=](Wide x) { return x + total / 8; });
       },
       [](X a, X, S) { return A(a + sum_along(select(a, 0, 0), 0) / 8); }},
  };
  return table;
}

[[nodiscard]] inline std::span<const ReductionStep> reductions() {
  using W = const WideArray&;
  using X = const A&;
  using S = const V&;
  static constexpr auto any = [](W, Wide) { return true; };
  static constexpr ReductionStep table[] = {
      {"sum(a) / 4", any, [](W a, Wide) { return sum_of(a.elements) / 4; },
       [](X a, S) { return V(sum(a) / 4); }},
      {"mean(a) * s", any,
       [](W a, Wide s) { return sum_of(a.elements) / static_cast<Wide>(a.elements.size()) * s; },
       [](X a, S s) { return V(mean(a) * s); }},
      {"logsumexp(a)", any, [](W a, Wide) { return log_sum_of(a.elements); },
       [](X a, S) { return logsumexp(a); }},
      {"norm(a)", [](W a, Wide) { return a.all([](Wide x) { return std::abs(x) > 0.05L; }); },
       [](W a, Wide) { return std::sqrt(sum_of(each(a, [](Wide x) { return x * x; }).elements)); },
       [](X a, S) { return norm(a); }},
      {"largest(a) + s", [](W a, Wide) { return has_one_largest(a.elements); },
       [](W a, Wide s) { return largest_of(a.elements) + s; }, [](X a, S s) { return V(largest(a) + s); }},
      {"sum(a * a - exp(-a) * s) / 16", [](W a, Wide) { return small(a, a, 0); },
       [](W a, Wide s) {
         return sum_of(each(a, [=](Wide x) { return x * x - std::exp(-x) * s; }).elements) / 16;
       },
       [](X a, S s) { return V(sum(a * a - exp(-a) * s) / 16); }},
      {"element(a, {0, a.shape()[1] - 1}) - sin(s)", any,
       [](W a, Wide s) { return a(0, a.columns - 1) - std::sin(s); },
       [](X a, S s) {
         return V(element(a, {0, a.shape()[1] - 1}) - sin(s));
       }},
  };
  return table;
}
}  // namespace array_steps
}  // namespace tapestry::test
