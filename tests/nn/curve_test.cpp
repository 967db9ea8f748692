#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/pointwise.hpp>

#include "../support/catch.hpp"
#include "../support/random_buffer.hpp"

namespace nn = tapestry::nn;
using nn::CurveKind, tapestry::test::random_buffer;

namespace {
constexpr CurveKind all[] = {CurveKind::logistic,      CurveKind::swish,      CurveKind::mish,
                             CurveKind::hard_logistic, CurveKind::hard_swish, CurveKind::clip};

template <class T>
nn::Curve<T> curve_of(CurveKind kind) {
  return kind == CurveKind::clip ? nn::Curve<T>{kind, T(-0.5), T(1.25)}
                                 : nn::Curve<T>{kind, T(0.125), T(0.5)};
}

/// The definition, in long double.
long double value_of(CurveKind kind, long double x) {
  const long double flat = std::min(std::max(x * 0.125L + 0.5L, 0.0L), 1.0L);
  switch (kind) {
    case CurveKind::logistic:
      return 1 / (1 + std::exp(-x));
    case CurveKind::swish:
      return x / (1 + std::exp(-x));
    case CurveKind::mish:
      return x * std::tanh(std::log1p(std::exp(x)));
    case CurveKind::hard_logistic:
      return flat;
    case CurveKind::hard_swish:
      return x * flat;
    default:
      return std::min(std::max(x, -0.5L), 1.25L);
  }
}

/// Arguments away from every kink, −4, −0.5, 1.25 and 4.
template <class T>
std::vector<T> arguments() {
  std::vector<T> x;
  for (int i = -400; i <= 400; ++i) x.push_back(static_cast<T>(i) * T(0.1) + T(0.03));
  for (const double huge : {-1e30, -800.0, -95.0, 95.0, 800.0, 1e30}) x.push_back(static_cast<T>(huge));
  return x;
}
}  // namespace

TEMPLATE_TEST_CASE("curves keep to their stated error", "[nn][curve]", float, double) {
  const auto x = arguments<TestType>();
  std::vector<TestType> y(x.size());
  const auto least = static_cast<long double>(std::numeric_limits<TestType>::min());
  const auto epsilon = static_cast<long double>(std::numeric_limits<TestType>::epsilon());
  for (const CurveKind kind : all) {
    nn::apply_curve(curve_of<TestType>(kind), x.data(), y.data(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      CAPTURE(static_cast<int>(kind), x[i], y[i]);
      const long double exact = value_of(kind, static_cast<long double>(x[i]));
      // the error where e^x is cut at the least normal number
      const long double cut = 3 * least * std::max(1.0L, std::abs(static_cast<long double>(x[i])));
      CHECK(std::abs(static_cast<long double>(y[i]) - exact) <= 6 * epsilon * std::abs(exact) + cut);
    }
  }
}

TEST_CASE("slopes in float keep to their stated error", "[nn][curve]") {
  const auto x = arguments<float>();
  const std::vector<double> wide(x.begin(), x.end());
  std::vector<float> value(x.size()), slope(x.size());
  std::vector<double> ignored(x.size()), exact(x.size());
  for (const auto set : tapestry::instruction_sets())
    for (const CurveKind kind : all) {
      nn::kernels_of<float>(set).apply_curve(curve_of<float>(kind), x.data(), value.data(), slope.data(),
                                             x.size());
      nn::apply_curve(curve_of<double>(kind), wide.data(), ignored.data(), x.size(), exact.data());
      double worst = 0;
      for (std::size_t i = 0; i + 6 < x.size(); ++i)  // without the huge ones
        worst = std::max(worst, std::abs(static_cast<double>(slope[i]) - exact[i]));
      CAPTURE(set, static_cast<int>(kind));
      CHECK(worst <= 8 * static_cast<double>(std::numeric_limits<float>::epsilon()));
    }
}

TEST_CASE("a curve's adjoint agrees with central differences", "[nn][curve][gradient]") {
  auto x = arguments<double>();
  x.resize(x.size() - 6);
  const double h = std::cbrt(std::numeric_limits<double>::epsilon());
  std::vector<double> ahead = x, behind = x;
  for (std::size_t i = 0; i < x.size(); ++i) ahead[i] += h, behind[i] -= h;
  for (const CurveKind kind : all) {
    const auto curve = curve_of<double>(kind);
    std::vector<double> up(x.size()), down(x.size()), slope(x.size());
    nn::apply_curve(curve, ahead.data(), up.data(), x.size());
    nn::apply_curve(curve, behind.data(), down.data(), x.size());
    std::vector<double> value(x.size());
    nn::apply_curve(curve, x.data(), value.data(), x.size(), slope.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      CAPTURE(static_cast<int>(kind), x[i]);
      // Truncation h²/6·f''' and rounding ε|f|/h, both about ε^(2/3) of |x|.
      CHECK(std::abs(slope[i] - (up[i] - down[i]) / (2 * h)) <= 4 * h * h * std::max(1.0, std::abs(x[i])));
    }
  }
}

TEMPLATE_TEST_CASE("curves keep NaN, and their slopes are finite everywhere", "[nn][curve]", float, double) {
  const TestType nan = std::numeric_limits<TestType>::quiet_NaN();
  for (const CurveKind kind : all) {
    CAPTURE(static_cast<int>(kind));
    TestType y = 0;
    nn::apply_curve(curve_of<TestType>(kind), &nan, &y, 1);
    CHECK(std::isnan(y));
    for (const double huge : {-1e30, -800.0, 800.0, 1e30}) {
      const auto x = static_cast<TestType>(huge);
      TestType slope = 0;
      nn::apply_curve(curve_of<TestType>(kind), &x, &y, 1, &slope);
      CHECK(std::isfinite(slope));
    }
  }
}

TEMPLATE_TEST_CASE("a convolution with a curve is the convolution and then the curve", "[nn][curve]", float,
                   double) {
  const std::vector<nn::ConvolutionShape> shapes = {
      nn::square_convolution(13, 11, 24, 40, 3, 1, 1), nn::square_convolution(13, 11, 300, 58, 1, 1, 0),
      nn::square_convolution(12, 9, 33, 33, 3, 2, 1, 1, 33), nn::square_convolution(9, 9, 16, 3, 3, 1, 1)};
  for (const auto& s : shapes)
    for (const CurveKind kind : all) {
      CAPTURE(static_cast<int>(kind), s.out_channels);
      const auto in = random_buffer<TestType>(s.in_size(), 1),
                 weights = random_buffer<TestType>(s.weight_count(), 2);
      const auto bias = random_buffer<TestType>(s.out_channels, 3),
                 addend = random_buffer<TestType>(s.out_size(), 4);
      const auto packed = nn::pack_convolution<TestType>(s, [&](std::size_t i) { return weights.data()[i]; });
      nn::Buffer<TestType> plain(s.out_size()), curved(s.out_size()), slopes(s.out_size()),
          expected(s.out_size());
      // The direct engine for few channels, too, so that sums are the same to the bit.
      nn::Epilogue<TestType> end{bias.data()};
      nn::convolve<TestType>(packed, 1, in.data(), end, plain.data(), s.out_size());
      end.curve = curve_of<TestType>(kind);
      end.slopes = slopes.data();
      end.addend = addend.data();
      nn::convolve<TestType>(packed, 1, in.data(), end, curved.data(), s.out_size());
      nn::apply_curve(end.curve, plain.data(), plain.data(), plain.size(), expected.data());
      CHECK(std::equal(expected.data(), expected.data() + expected.size(), slopes.data()));
      nn::add(addend.data(), plain.data(), plain.size());
      CHECK(std::equal(plain.data(), plain.data() + plain.size(), curved.data()));
    }
}
