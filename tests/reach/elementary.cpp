// Elementary functions of sums, products and roots alone, less accurate than a C library's but with the same
// bits by every compiler. In their place a run has the same bits on two systems if nothing but these
// functions differs. See windows.sh and aarch64.sh.
#include <cstdint>
#include <cstring>
#include <limits>

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double log_2[] = {0.6931471803691238, 1.9082149292705877e-10};  // its first 33 bits, and the rest
constexpr double half_pi[] = {1.5707963267341256, 6.077100506506192e-11};

double power_of_two(long long k) {
  const auto bits = static_cast<std::uint64_t>(1023 + k) << 52U;
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
long long nearest(double x) { return static_cast<long long>(x + (x < 0 ? -0.5 : 0.5)); }
double root(double x) { return __builtin_sqrt(x); }
}  // namespace

extern "C" {
double exp(double x) {
  if (!(x > -708 && x < 709)) return x < 0 ? 0 : x > 0 ? infinity : x;
  const long long k = nearest(x / 0.6931471805599453);
  const auto count = static_cast<double>(k);
  const double rest = x - count * log_2[0] - count * log_2[1];
  double sum = 1;
  for (int i = 17; i > 0; --i) sum = 1 + sum * rest / i;
  return sum * power_of_two(k / 2) * power_of_two(k - k / 2);
}
double log(double x) {
  if (!(x > 0 && x < infinity)) return x == 0 ? -infinity : x > 0 ? x : nan;
  double exponent = 0, sum = 0;
  for (; x > 1.4142135623730951; ++exponent) x /= 2;
  for (; x < 0.7071067811865476; --exponent) x *= 2;
  const double t = (x - 1) / (x + 1);
  for (int i = 25; i > 0; i -= 2) sum = sum * t * t + 1.0 / i;
  return exponent * log_2[0] + (2 * t * sum + exponent * log_2[1]);
}
double sin(double x) {
  const long long k = nearest(x * 0.6366197723675814);
  const double rest = x - static_cast<double>(k) * half_pi[0] - static_cast<double>(k) * half_pi[1];
  double odd = 1, even = 1;
  for (int i = 20; i > 1; i -= 2) {
    odd = 1 - odd * rest * rest / (i * (i + 1));
    even = 1 - even * rest * rest / (i * (i - 1));
  }
  const double value = (k & 1) == 0 ? odd * rest : even;
  return (k & 2) == 0 ? value : -value;
}
double cos(double x) { return sin(x + half_pi[0] + half_pi[1]); }
double tan(double x) { return sin(x) / cos(x); }
double atan(double x) {
  if (x < 0) return -atan(-x);
  if (x > 1) return half_pi[0] + half_pi[1] - atan(1 / x);
  double y = x / (1 + root(1 + x * x)), sum = 0;
  y /= 1 + root(1 + y * y);
  for (int i = 31; i > 0; i -= 2) sum = 1.0 / i - sum * y * y;
  return 4 * y * sum;
}
double atan2(double y, double x) {
  if (x == 0) return y == 0 ? 0 : y > 0 ? half_pi[0] : -half_pi[0];
  return atan(y / x) + (x > 0 ? 0 : (y < 0 ? -2 : 2) * half_pi[0]);
}
double asin(double x) { return atan2(x, root((1 - x) * (1 + x))); }
double expm1(double x) {
  if (!(x > -0.3 && x < 0.3)) return exp(x) - 1;
  double sum = 1;
  for (int i = 17; i > 1; --i) sum = 1 + sum * x / i;
  return x * sum;
}
double log1p(double x) { return 1 + x == 1 ? x : log(1 + x) * x / (1 + x - 1); }
double asinh(double x) { return x < 0 ? -asinh(-x) : log(x + root(x * x + 1)); }
double hypot(double x, double y) { return root(x * x + y * y); }
double pow(double x, double y) {
  if (x == 0) return y == 0 ? 1 : y > 0 ? 0 : infinity;
  const bool is_odd = static_cast<double>(nearest(y)) == y && nearest(y) % 2 != 0;
  return x < 0 ? (is_odd ? -1 : 1) * pow(-x, y) : exp(y * log(x));
}
float expf(float x) { return static_cast<float>(exp(x)); }
float powf(float x, float y) { return static_cast<float>(pow(x, y)); }
float tanhf(float x) {
  const double e = expm1(2.0 * (x > 20 ? 20 : x < -20 ? -20 : x));
  return static_cast<float>(e / (e + 2));
}
}
