#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>

namespace tapestry {
namespace detail {
// Polygamma functions in long double. Near the roots between the poles at 0, −1, −2 … terms cancel; in long
// double, a result in double keeps its digits down to about 2⁻¹⁰ from the root. Nearer to one of the first 20
// roots, digamma is computed from there.

/// ψ on [1, 2]: (x − r) · p(x − 3/2), r the root and p the polynomial through ψ(x) / (x − r) at 28 Chebyshev
/// nodes; relative error 4e−22.
[[nodiscard]] inline long double digamma_between_1_and_2(long double x) {
  constexpr long double root = 0xb.b16c31ab5f1fb7p-3L, root_rest = 9.016312093258695918614e-20L;
  constexpr std::array<long double, 28> p = {
      0.9510558760318328797107L,      -0.4236274212814604962284L,      0.2405424842407869145226L,
      -0.1484049230539173211742L,     0.09498872445291451600469L,      -0.06192213327171340186751L,
      0.04076083393834345061737L,     -0.02697579684008662070249L,     0.01790724843676637431457L,
      -0.01190821533311543035045L,    0.007927018638863708787609L,     -0.005280014201501968384717L,
      0.003518157365915143117156L,    -0.00234470160953427555871L,     0.001562847843209686772289L,
      -0.001041781468355919025362L,   0.0006944059749926768664975L,    -0.0004629186430343131648852L,
      0.0003090760680201397536684L,   -0.0002060477291657639400575L,   0.0001350828369256752598138L,
      -0.00009005474784103046675338L, 0.0000676203022391005289746L,    -0.00004508012498020291593511L,
      0.00001356644183215455596971L,  -0.000009044282882707880288568L, 0.00002713280585511699843535L,
      -0.00001808853464330004427102L};
  long double sum = 0;
  for (std::size_t k = p.size(); k-- > 0;) sum = sum * (x - 1.5L) + p[k];
  return ((x - root) - root_rest) * sum;
}

/// Bernoulli numbers B₂, B₄ … B₂₄ of the asymptotic series; not constexpr: on PowerPC long doubles are pairs
/// of doubles, and their quotients are not constexpr.
inline const std::array<long double, 12> even_bernoulli = {
    1.0L / 6, -1.0L / 30,     1.0L / 42,      -1.0L / 30,       5.0L / 66,       -691.0L / 2730,
    7.0L / 6, -3617.0L / 510, 43867.0L / 798, -174611.0L / 330, 854513.0L / 138, -236364091.0L / 2730};

/// cot πx, by the distance to the nearest integer, which is exact.
[[nodiscard]] inline long double cot_pi(long double x) {
  return 1 / std::tan(std::numbers::pi_v<long double> * (x - std::round(x)));
}

[[nodiscard]] inline long double positive_digamma(long double x) {
  if (x < 1) return digamma_between_1_and_2(1 + x) - 1 / x;
  if (x >= 12) {
    long double sum = std::log(x) - 1 / (2 * x);
    long double power = 1;
    for (std::size_t k = 1; k <= even_bernoulli.size(); ++k)
      sum -= even_bernoulli[k - 1] / (2 * static_cast<long double>(k)) * (power /= x * x);
    return sum;
  }
  long double sum = 0;
  for (; x > 2; x -= 1) sum += 1 / (x - 1);
  return sum + digamma_between_1_and_2(x);
}

/// dⁿ/dxⁿ ψ for n ≥ 1 and x > 0: all terms have one sign.
[[nodiscard]] inline long double positive_polygamma(int n, long double x) {
  const auto order = static_cast<long double>(n);
  long double factorial = 1;  // (n − 1)!
  for (int k = 2; k < n; ++k) factorial *= static_cast<long double>(k);
  long double sum = 0;
  for (; x < 16 + order; x += 1) sum += factorial * order / std::pow(x, order + 1);
  const long double lead = factorial / std::pow(x, order);
  sum += lead + lead * order / (2 * x);
  long double factor = lead * order;  // (2k + n − 1)! / ((2k)! x^(2k + n))
  for (std::size_t k = 1; k <= even_bernoulli.size(); ++k) {
    const auto even = static_cast<long double>(2 * k);
    factor *= k == 1 ? (order + 1) / (2 * x * x)
                     : (even + order - 1) * (even + order - 2) / (even * (even - 1) * x * x);
    sum += even_bernoulli[k - 1] * factor;
  }
  return n % 2 == 0 ? -sum : sum;
}

/// dⁿ/dxⁿ cot πx = πⁿ · P(cot πx), where each derivative turns P into −(1 + c²) P′.
template <int N>
[[nodiscard]] long double cot_pi_derivative(long double x) {
  std::array<long double, static_cast<std::size_t>(N) + 2> p{};
  p[1] = 1;
  for (int n = 0; n < N; ++n) {
    std::array<long double, static_cast<std::size_t>(N) + 2> next{};
    for (std::size_t k = 1; k <= static_cast<std::size_t>(n) + 1; ++k) {
      const long double slope = static_cast<long double>(k) * p[k];
      next[k - 1] -= slope;
      next[k + 1] -= slope;
    }
    p = next;
  }
  const long double c = cot_pi(x);
  long double sum = 0;
  for (std::size_t k = p.size(); k-- > 0;) sum = sum * c + p[k];
  return sum * std::pow(std::numbers::pi_v<long double>, static_cast<long double>(N));
}

/// Roots of ψ between the poles −n − 1 and −n, rounded to 64 bits, and what that leaves: a long double of
/// more bits, as on ARM, must have the same roots.
inline constexpr std::array<std::array<long double, 2>, 20> negative_digamma_roots = {
    {{-0x8.10b9582f7130096p-4L, -2.27657687968468387e-20L},
     {-0xc.96865e144ea5091p-3L, -2.0925409733655729e-20L},
     {-0xa.7160cfb3cf2ce38p-2L, -5.96306608944825672e-20L},
     {-0xe.8a8a5820d953f04p-2L, -9.98278615390338507e-20L},
     {-0x9.4e752e0e65e824cp-1L, 7.74889539087002396e-20L},
     {-0xb.559650c73671807p-1L, -1.79539024535421023e-19L},
     {-0xd.5b59a1cc527f4ep-1L, 1.35177154162644041e-19L},
     {-0xf.6025ca9529b4138p-1L, 1.52181661823773717e-19L},
     {-0x8.b21d99a951fa97bp+0L, 1.31061534710470318e-19L},
     {-0x9.b3e258fb1af2177p+0L, -3.7113230836344004e-19L},
     {-0xa.b5700a21a4242d5p+0L, 1.160849875624473e-19L},
     {-0xb.b6d16c9ef881421p+0L, 2.69533087875479367e-19L},
     {-0xc.b80e7c325d4aa24p+0L, 8.29892069534838528e-20L},
     {-0xd.b92d4c8905bb5f6p+0L, 6.50419218591140174e-20L},
     {-0xe.ba32969a0e0a02ap+0L, -1.89206967626840022e-19L},
     {-0xf.bb2216c67043f86p+0L, -2.98568300926809279e-19L},
     {-0x8.5dff66b07e692b6p+1L, -5.20708521102834858e-20L},
     {-0x8.de659606dba9927p+1L, -8.34197659565407151e-19L},
     {-0x9.5ec49b2f4ddde41p+1L, 3.116936410487939e-19L},
     {-0x9.df1d4cdd0417689p+1L, 4.59481782199764988e-20L}}};

/// ψ beside a negative root r. There ψ(x) = ψ(1 − x) − π cot πx cancels. Subtracting the same equation at r,
/// where ψ is 0, leaves two differences that can be written without cancellation: with d = x − r,
///
///   ψ(x) = Σₖ ψ⁽ᵏ⁾(1 − r) (−d)ᵏ / k! + π sin πd / (sin πx · sin πr).
///
/// \returns 0 where no root of the list is within 2⁻¹⁰
[[nodiscard]] inline long double digamma_beside_root(long double x) {
  constexpr long double pi = std::numbers::pi_v<long double>;
  const auto place = static_cast<std::size_t>(std::min(-std::floor(x) - 1, 20.0L));
  if (place >= negative_digamma_roots.size()) return 0;
  const auto [root, rest] = negative_digamma_roots[place];
  const long double d = (x - root) - rest, pole = std::round(x);
  if (std::abs(d) > 0x1p-10L) return 0;
  long double sum = 0, factor = 1;
  for (int k = 1; k <= 6; ++k)
    sum += positive_polygamma(k, 1 - root) * (factor *= -d / static_cast<long double>(k));
  return sum + pi * std::sin(pi * d) / (std::sin(pi * (x - pole)) * std::sin(pi * (root - pole)));
}

/// ψ and its derivatives where there is no pole.
template <int N>
[[nodiscard]] long double regular_polygamma(long double x) {
  constexpr long double pi = std::numbers::pi_v<long double>;
  if constexpr (N == 0) {
    if (x > 0) return positive_digamma(x);
    const long double beside_root = digamma_beside_root(x);
    return beside_root != 0 ? beside_root : positive_digamma(1 - x) - pi * cot_pi(x);
  } else {
    if (x > 0) return positive_polygamma(N, x);
    const long double mirrored = positive_polygamma(N, 1 - x);
    return (N % 2 == 0 ? mirrored : -mirrored) - pi * cot_pi_derivative<N>(x);
  }
}

/// Γ′ = Γ · ψ.
template <std::floating_point T>
[[nodiscard]] T gamma_derivative(T x) {
  if (x <= 0 || !std::isfinite(x)) {
    if (x == 0) return -std::numeric_limits<T>::infinity();
    if (!std::isfinite(x) || x == std::floor(x)) return std::tgamma(x);
  }
  const auto wide = static_cast<long double>(x);
  const long double gamma = std::tgamma(wide);
  return static_cast<T>(gamma == 0 ? 0 : gamma * regular_polygamma<0>(wide));
}
}  // namespace detail

/// The N-th derivative of digamma(x), the derivative of log |Γ|; N = 0 is digamma itself. In double, where
/// long double is wider: digamma within 1 ulp, or 1e−18 beside its roots below −20; the others within 4
/// ulp, or as much beside their roots. At 0 it is infinite, with the sign of the side. At negative integers
/// it is NaN for even N, whose sides differ, and +∞ for odd N. At −∞ it is NaN.
template <int N, std::floating_point T>
[[nodiscard]] T polygamma(T x) {
  static_assert(N >= 0);
  constexpr T infinity = std::numeric_limits<T>::infinity();
  if (std::isnan(x) || x == -infinity) return std::numeric_limits<T>::quiet_NaN();
  if (x == infinity) return N == 0 ? infinity : T(0);
  if (x <= 0 && x == std::floor(x)) {
    if (N % 2 == 1) return infinity;
    return x < 0 ? std::numeric_limits<T>::quiet_NaN() : std::signbit(x) ? infinity : -infinity;
  }
  return static_cast<T>(detail::regular_polygamma<N>(static_cast<long double>(x)));
}

/// Γ′ / Γ, the derivative of log |Γ(x)|; see polygamma().
template <std::floating_point T>
[[nodiscard]] T digamma(T x) {
  return polygamma<0>(x);
}
}  // namespace tapestry
