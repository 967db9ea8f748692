#pragma once
#include <tapestry/autodiff/functions.hpp>

namespace tapestry::test {
using Wide = long double;  // 64 bits of mantissa and exponents to 2^±16382 on x86

/// Distance in units in the last place of the reference, denormals having the spacing of the smallest.
inline double ulps(double found, Wide reference) {
  const auto rounded = static_cast<double>(reference);
  if (found == rounded) return 0;
  if (!std::isfinite(rounded) || !std::isfinite(found)) return std::numeric_limits<double>::infinity();
  int exponent = 0;
  std::frexp(rounded, &exponent);
  const int last = std::max(exponent - 53, -1074);
  return static_cast<double>(std::abs(static_cast<Wide>(found) - reference) / std::ldexp(Wide(1), last));
}

/// A function of one number, for tests of all functions.
struct FunctionRow {
  const char* name;                 ///< in reference/function_table.txt, too
  double f, f1, f2, f3;             ///< bounds in ulp of the errors of value and derivatives up to the third
  double low, high;                 ///< range of arguments for `slope`
  Wide (*slope)(Wide x) = nullptr;  ///< the derivative by another formula
};

/// Calls visit(row, f) for each function, where f takes a variable, a dual or an array.
template <class Visit>
void for_each_function(const Visit& visit) {
  constexpr Wide ln2 = std::numbers::ln2_v<Wide>, ln10 = std::numbers::ln10_v<Wide>;
  constexpr Wide bell = 2 * std::numbers::inv_sqrtpi_v<Wide>;
  visit({"exp", 1, 1, 1, 1, -745, 709, [](Wide x) { return std::exp(x); }}, [](auto x) { return exp(x); });
  visit({"exp2", 1, 2, 3, 4, -1074, 1023, [](Wide x) { return ln2 * std::exp2(x); }},
        [](auto x) { return exp2(x); });
  visit({"exp10", 2, 3, 5, 8, -323, 308, [](Wide x) { return ln10 * std::pow(10.0L, x); }},
        [](auto x) { return exp10(x); });
  visit({"expm1", 1, 1, 1, 1, -745, 709, [](Wide x) { return std::exp(x); }},
        [](auto x) { return expm1(x); });
  visit({"log", 1, 1, 2, 3, 0, 1e307, [](Wide x) { return 1 / x; }}, [](auto x) { return log(x); });
  visit({"log2", 1, 2, 3, 4, 0, 1e307, [](Wide x) { return 1 / (x * ln2); }}, [](auto x) { return log2(x); });
  visit({"log10", 1, 2, 3, 4, 0, 1e307, [](Wide x) { return 1 / (x * ln10); }},
        [](auto x) { return log10(x); });
  visit({"log1p", 1, 2, 5, 8, -1, 1e5, [](Wide x) { return 1 / (1 + x); }}, [](auto x) { return log1p(x); });
  visit(
      {"sigmoid", 2, 4, 5, 8, -745, 745, [](Wide x) { return 1 / ((1 + std::exp(x)) * (1 + std::exp(-x))); }},
      [](auto x) { return sigmoid(x); });
  visit({"softplus", 2, 2, 5, 8, -745, 745, [](Wide x) { return 1 / (1 + std::exp(-x)); }},
        [](auto x) { return softplus(x); });
  visit({"sin", 1, 1, 1, 1, -100, 100, [](Wide x) { return std::cos(x); }}, [](auto x) { return sin(x); });
  visit({"cos", 1, 1, 1, 1, -100, 100, [](Wide x) { return -std::sin(x); }}, [](auto x) { return cos(x); });
  visit({"tan", 1, 4, 5, 8, -100, 100, [](Wide x) { return 1 / (std::cos(x) * std::cos(x)); }},
        [](auto x) { return tan(x); });
  visit({"asin", 1, 4, 5, 8, -1, 1, [](Wide x) { return 1 / std::sqrt((1 - x) * (1 + x)); }},
        [](auto x) { return asin(x); });
  visit({"acos", 1, 4, 5, 8, -1, 1, [](Wide x) { return -1 / std::sqrt((1 - x) * (1 + x)); }},
        [](auto x) { return acos(x); });
  visit({"atan", 1, 4, 5, 8, -1e160, 1e160, [](Wide x) { return 1 / (1 + x * x); }},
        [](auto x) { return atan(x); });
  visit({"sinh", 2, 1, 2, 1, -710, 710, [](Wide x) { return std::cosh(x); }}, [](auto x) { return sinh(x); });
  visit({"cosh", 1, 2, 1, 2, -710, 710, [](Wide x) { return std::sinh(x); }}, [](auto x) { return cosh(x); });
  visit({"tanh", 2, 4, 5, 8, -372, 372, [](Wide x) { return 1 / (std::cosh(x) * std::cosh(x)); }},
        [](auto x) { return tanh(x); });
  visit({"asinh", 2, 4, 5, 8, -1e300, 1e300, [](Wide x) { return 1 / std::sqrt(1 + x * x); }},
        [](auto x) { return asinh(x); });
  visit({"acosh", 2, 4, 5, 8, 1, 1e300, [](Wide x) { return 1 / std::sqrt((x - 1) * (x + 1)); }},
        [](auto x) { return acosh(x); });
  visit({"atanh", 2, 4, 5, 8, -1, 1, [](Wide x) { return 1 / ((1 - x) * (1 + x)); }},
        [](auto x) { return atanh(x); });
  visit({"square", 1, 1, 1, 1, -1e150, 1e150, [](Wide x) { return 2 * x; }},
        [](auto x) { return square(x); });
  visit({"reciprocal", 1, 2, 3, 4, -1e150, 1e150, [](Wide x) { return -1 / (x * x); }},
        [](auto x) { return 1 / x; });
  visit({"sqrt", 1, 2, 3, 4, 0, 1e307, [](Wide x) { return 1 / (2 * std::sqrt(x)); }},
        [](auto x) { return sqrt(x); });
  visit({"cbrt", 3, 2, 5, 8, -1e300, 1e300, [](Wide x) { return 1 / (3 * std::cbrt(x) * std::cbrt(x)); }},
        [](auto x) { return cbrt(x); });
  visit({"erf", 1, 4, 5, 8, -26.6, 26.6, [](Wide x) { return bell * std::exp(-x * x); }},
        [](auto x) { return erf(x); });
  visit({"erfc", 1, 4, 5, 8, -26.6, 26.6, [](Wide x) { return -bell * std::exp(-x * x); }},
        [](auto x) { return erfc(x); });
  visit({"lgamma", 2, 4, 5, 8, 0, 170}, [](auto x) { return lgamma(x); });
  visit({"tgamma", 3, 4, 5, 8, 0, 170}, [](auto x) { return tgamma(x); });
  visit({"digamma", 1, 4, 5, 8, 0, 170}, [](auto x) { return digamma(x); });
  visit({"trigamma", 4, 4, 5, 8, 0, 170}, [](auto x) { return polygamma<1>(x); });
}
}  // namespace tapestry::test
