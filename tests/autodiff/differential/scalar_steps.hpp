#pragma once
#include <tapestry/autodiff/functions.hpp>

namespace tapestry::test {
/// Type of the reference: 64 bits of mantissa on x86, so that its roundings are small
/// against those of doubles.
using Wide = long double;

/// One operation of a random expression: its text in C++, with a, b, c for its operands and S for their type;
/// whether values of the operands are far enough from kinks, ties and edges of its domain, and its slopes not
/// above about 10; and how many of a, b, c it has.
template <class S>
struct ScalarStep {
  const char* text;
  bool (*fits)(Wide a, Wide b, Wide c);
  int operands;
  S (*run)(const S& a, const S& b, const S& c);
};

namespace steps {
using namespace tapestry::detail;  // the functions of <cmath> that it names
using std::fdim, std::floor, std::ldexp, std::lerp, std::max, std::min;
inline Wide square(Wide x) { return x * x; }

inline bool any(Wide, Wide, Wide) { return true; }
inline bool small(Wide a, Wide, Wide) { return std::abs(a) < 2; }
inline bool inside_one(Wide a, Wide, Wide) { return std::abs(a) < 0.8L; }
inline bool positive(Wide a, Wide, Wide) { return a > 0.3L; }
inline bool not_zero(Wide a, Wide, Wide) { return std::abs(a) > 0.3L; }
inline bool divisor(Wide, Wide b, Wide) { return std::abs(b) > 0.4L; }
inline bool apart(Wide a, Wide b, Wide) { return std::abs(a - b) > 0.1L; }
inline bool not_origin(Wide a, Wide b, Wide) { return a * a + b * b > 0.2L; }
inline bool off_the_cut(Wide a, Wide b, Wide) {
  return a * a + b * b > 0.2L && (std::abs(a) > 0.1L || b > 0);
}
inline bool small_product(Wide a, Wide b, Wide c) {
  return std::abs(a) < 4 && std::abs(b) < 4 && std::abs(c) < 4;
}

/// All operations for a type of scalars.
template <class S>
[[nodiscard]] std::span<const ScalarStep<S>> all() {
  using X = const S&;
  static constexpr ScalarStep<S> table[] = {
      // One operand.
      {"-a", any, 1, [](X a, X, X) { return S(-a); }},
      {"sin(a)", any, 1, [](X a, X, X) { return S(sin(a)); }},
      {"cos(a)", any, 1, [](X a, X, X) { return S(cos(a)); }},
      {"tan(a)", [](Wide a, Wide, Wide) { return std::abs(std::cos(a)) > 0.4L; }, 1,
       [](X a, X, X) { return S(tan(a)); }},
      {"asin(a)", inside_one, 1, [](X a, X, X) { return S(asin(a)); }},
      {"acos(a)", inside_one, 1, [](X a, X, X) { return S(acos(a)); }},
      {"atan(a)", any, 1, [](X a, X, X) { return S(atan(a)); }},
      {"sinh(a)", small, 1, [](X a, X, X) { return S(sinh(a)); }},
      {"cosh(a)", small, 1, [](X a, X, X) { return S(cosh(a)); }},
      {"tanh(a)", any, 1, [](X a, X, X) { return S(tanh(a)); }},
      {"asinh(a)", any, 1, [](X a, X, X) { return S(asinh(a)); }},
      {"acosh(a)", [](Wide a, Wide, Wide) { return a > 1.2L; }, 1, [](X a, X, X) { return S(acosh(a)); }},
      {"atanh(a)", inside_one, 1, [](X a, X, X) { return S(atanh(a)); }},
      {"exp(a)", small, 1, [](X a, X, X) { return S(exp(a)); }},
      {"exp2(a)", small, 1, [](X a, X, X) { return S(exp2(a)); }},
      {"expm1(a)", small, 1, [](X a, X, X) { return S(expm1(a)); }},
      {"log(a)", positive, 1, [](X a, X, X) { return S(log(a)); }},
      {"log2(a)", positive, 1, [](X a, X, X) { return S(log2(a)); }},
      {"log10(a)", positive, 1, [](X a, X, X) { return S(log10(a)); }},
      {"log1p(a)", [](Wide a, Wide, Wide) { return a > -0.7L; }, 1, [](X a, X, X) { return S(log1p(a)); }},
      {"sigmoid(a)", any, 1, [](X a, X, X) { return S(sigmoid(a)); }},
      {"softplus(a)", any, 1, [](X a, X, X) { return S(softplus(a)); }},
      {"sqrt(a)", positive, 1, [](X a, X, X) { return S(sqrt(a)); }},
      {"cbrt(a)", not_zero, 1, [](X a, X, X) { return S(cbrt(a)); }},
      {"square(a)", small, 1, [](X a, X, X) { return S(square(a)); }},
      {"pow(a, 3)", small, 1, [](X a, X, X) { return S(pow(a, 3)); }},
      {"erf(a)", any, 1, [](X a, X, X) { return S(erf(a)); }},
      {"erfc(a)", any, 1, [](X a, X, X) { return S(erfc(a)); }},
      {"lgamma(a)", [](Wide a, Wide, Wide) { return a > 0.5L; }, 1, [](X a, X, X) { return S(lgamma(a)); }},
      {"tgamma(a)", [](Wide a, Wide, Wide) { return a > 0.5L && a < 4; }, 1,
       [](X a, X, X) { return S(tgamma(a)); }},
      {"abs(a)", not_zero, 1, [](X a, X, X) { return S(abs(a)); }},
      {"a - floor(a)",
       [](Wide a, Wide, Wide) { return std::abs(a - std::floor(a) - 0.5L) < 0.4L; }, 1,
       [](X a, X, X) { return S(a - floor(a)); }},
      {"ldexp(a, -2)", any, 1, [](X a, X, X) { return S(ldexp(a, -2)); }},
      {"2 / a", not_zero, 1, [](X a, X, X) { return S(2 / a); }},
      {"3 - a * 2", any, 1, [](X a, X, X) { return S(3 - a * 2); }},
      // Two operands.
      {"a + b", any, 2, [](X a, X b, X) { return S(a + b); }},
      {"a - b", any, 2, [](X a, X b, X) { return S(a - b); }},
      {"a * b", small_product, 2, [](X a, X b, X) { return S(a * b); }},
      {"a / b", divisor, 2, [](X a, X b, X) { return S(a / b); }},
      {"pow(a, b)",
       [](Wide a, Wide b, Wide) { return a > 0.4L && a < 4 && std::abs(b) < 2; }, 2,
       [](X a, X b, X) { return S(pow(a, b)); }},
      {"hypot(a, b)", not_origin, 2, [](X a, X b, X) { return S(hypot(a, b)); }},
      {"atan2(a, b)", off_the_cut, 2, [](X a, X b, X) { return S(atan2(a, b)); }},
      {"max(a, b)", apart, 2, [](X a, X b, X) { return S(max(a, b)); }},
      {"min(a, b)", apart, 2, [](X a, X b, X) { return S(min(a, b)); }},
      {"fdim(a, b)", apart, 2, [](X a, X b, X) { return S(fdim(a, b)); }},
      {"logsumexp(a, b)", any, 2, [](X a, X b, X) { return S(logsumexp(a, b)); }},
      {"copysign(a, b)",
       [](Wide a, Wide b, Wide) { return std::abs(a) > 0.1L && std::abs(b) > 0.1L; }, 2,
       [](X a, X b, X) { return S(copysign(a, b)); }},
      {"fmod(a, b)",
       [](Wide a, Wide b, Wide) {
         const Wide rest = std::abs(std::fmod(a, b));
         return std::abs(b) > 1 && rest > 0.1L && rest < std::abs(b) - 0.1L;
       },
       2, [](X a, X b, X) { return S(fmod(a, b)); }},
      {"remainder(a, b)",
       [](Wide a, Wide b, Wide) {
         return std::abs(b) > 1 && std::abs(std::remainder(a, b)) < std::abs(b) / 2 - 0.1L;
       },
       2, [](X a, X b, X) { return S(remainder(a, b)); }},
      {"a < b ? S(a * 2 - b) : S(sin(b) + a)", apart, 2,
       [](X a, X b, X) { return a < b ? S(a * 2 - b) : S(sin(b) + a); }},
      // Three operands, several operations in one statement among them.
      {"fma(a, b, c)", small_product, 3, [](X a, X b, X c) { return S(fma(a, b, c)); }},
      {"lerp(a, b, c)", small_product, 3, [](X a, X b, X c) { return S(lerp(a, b, c)); }},
      {"hypot(a, b, c)", not_origin, 3, [](X a, X b, X c) { return S(hypot(a, b, c)); }},
      {"a - b * c", small_product, 3, [](X a, X b, X c) { return S(a - b * c); }},
      {"(a + b) * (a - c) / 4", small_product, 3, [](X a, X b, X c) { return S((a + b) * (a - c) / 4); }},
      {"-(a - b) - (-c)", any, 3, [](X a, X b, X c) { return S(-(a - b) - (-c)); }},
      {"a + b + c + a + b - c - b - b - a - c - a", any, 3,  // more ±1 than a statement's kind counts
       [](X a, X b, X c) { return S(a + b + c + a + b - c - b - b - a - c - a); }},
      {"(a * b * c + b * c * a + c * a * b + a * a * b + b * b * c + c * c * a) / 16", small_product, 3,
       [](X a, X b, X c) {  // more operands than a statement's kind counts
         return S((a * b * c + b * c * a + c * a * b + a * a * b + b * b * c + c * c * a) / 16);
       }},
      {"sin(a * b) - c * tanh(a + b)", small_product, 3,
       [](X a, X b, X c) { return S(sin(a * b) - c * tanh(a + b)); }},
      {"exp(-square(a - b) / 8) * c", any, 3,
       [](X a, X b, X c) { return S(exp(-square(a - b) / 8) * c); }},
      {"sqrt(1 + a * a + b * b) - log(2 + square(c)) / (1 + exp(-a))", small, 3,
       [](X a, X b, X c) { return S(sqrt(1 + a * a + b * b) - log(2 + square(c)) / (1 + exp(-a))); }},
      {"max(a, b) * min(b, c) / 4",
       [](Wide a, Wide b, Wide c) { return apart(a, b, c) && apart(b, c, a) && small_product(a, b, c); }, 3,
       [](X a, X b, X c) { return S(max(a, b) * min(b, c) / 4); }},
      {"[](S t, S u, S v) { t += u * v; t *= u; t -= v; return S(t /= 2 + square(v)); }(a, b, c)",
       small_product, 3,
       [](X a, X b, X c) {
         S t = a;
         t += b * c;
         t *= b;
         t -= c;
         t /= 2 + square(c);
         return t;
       }},
  };
  return table;
}
}  // namespace steps
}  // namespace tapestry::test
