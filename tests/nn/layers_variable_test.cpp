#include <tapestry/nn/network_variable.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// The definition, element by element.
Array<double, 4> convolved(const Array<double, 4>& x, const Array<double, 4>& w,
                           const nn::ConvolutionLayer& layer, std::size_t rows, std::size_t columns) {
  auto y = tapestry::zeros<double, 4>({x.shape(0), rows, columns, w.shape(0)});
  const std::size_t of_group = w.shape(0) / layer.groups;
  for (std::size_t n = 0; n < x.shape(0); ++n)
    for (std::size_t m = 0; m < w.shape(0); ++m)
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j)
          for (std::size_t c = 0; c < w.shape(1); ++c)
            for (std::size_t r = 0; r < w.shape(2); ++r)
              for (std::size_t s = 0; s < w.shape(3); ++s) {
                const std::size_t row = i * layer.stride + r * layer.dilation;
                const std::size_t column = j * layer.stride + s * layer.dilation;
                if (row < layer.padding || row - layer.padding >= x.shape(1)) continue;
                if (column < layer.padding || column - layer.padding >= x.shape(2)) continue;
                y(n, i, j, m) += w(m, c, r, s) * x(n, row - layer.padding, column - layer.padding,
                                                   m / of_group * w.shape(1) + c);
              }
  return y;
}

/// Σ weight · y² / 2 of the results of `network` for computed operands: its value, the largest difference
/// between its gradient by x and central differences, and the largest slope.
template <class Network>
double gradient_error(const Array<double, 4>& x0, const Network& network) {
  const auto value_of = [&](const Array<double, 4>& at, Array<double, 4>* gradient) {
    ActiveTape<double> tape;
    const auto x = tape.input(at);
    const ArrayVariable<double, 4> computed = 1.5 * x;  // an operand that is a result
    const ArrayVariable<double, 4> y = network(computed);
    auto weight = y.value();
    Random random(9);
    for (double& w : weight.storage()) w = random.uniform(0.5, 1.5);
    const auto loss = sum(weight * y * y) / 2.0;
    if (gradient != nullptr) {
      tape.reverse(loss);
      *gradient = x.adjoint();
    }
    return loss.value();
  };
  Array<double, 4> gradient;
  static_cast<void>(value_of(x0, &gradient));
  double worst = 0, largest = 1;
  auto x = x0;
  const double step = test::central_difference_step<double>();
  for (std::size_t i = 0; i < x0.size(); ++i) {
    const double slope = test::slope_by(x.data()[i], step, [&] { return value_of(x, nullptr); });
    worst = std::max(worst, std::abs(slope - gradient.data()[i]));
    largest = std::max(largest, std::abs(slope));
  }
  return worst / largest;
}
}  // namespace

TEST_CASE("convolve equals its definition, and its pullback is its transpose", "[nn][layers][variable]") {
  struct Case {
    nn::ConvolutionLayer layer;
    std::size_t rows, columns;
  };
  const auto x0 = random_array<double>({2, 5, 7, 4}, 1, -1, 1);
  for (const auto& [layer, rows, columns] :
       {Case{{}, 3, 6}, Case{{2, 1}, 3, 4}, Case{{1, 3}, 9, 12}, Case{{3, 2}, 3, 4}, Case{{1, 1, 2}, 3, 7},
        Case{{1, 0, 1, 2}, 3, 6}, Case{{1, 0, 1, 4}, 3, 6}}) {
    CAPTURE(layer.stride, layer.padding, layer.dilation, layer.groups);
    const auto w0 = random_array<double>({8, 4 / layer.groups, 3, 2}, 2, -1, 1);
    const auto b0 = random_array<double>({8}, 4, -1, 1);
    ActiveTape<double> tape;
    const auto x = tape.input(x0);
    const auto w = tape.input(w0);
    const auto b = tape.input(b0);
    const ArrayVariable<double, 4> y = nn::convolve(x, w, b, layer);
    const auto expected = convolved(x0, w0, layer, rows, columns);
    REQUIRE(y.shape() == expected.shape());
    for (std::size_t i = 0; i < expected.size(); ++i)
      CHECK(std::abs(y.value().data()[i] - expected.data()[i] - b0.data()[i % 8]) <= 1e-13);
    // ⟨g, y − b⟩ is linear in x and in w: with either's adjoint it is the same sum.
    auto g = expected;
    Random random(3);
    for (double& value : g.storage()) value = random.uniform(-1, 1);
    tape.reverse(y, g);
    const double through = test::dot(g, expected);
    CHECK(std::abs(test::dot(x.adjoint(), x0) - through) <= 1e-12);
    CHECK(std::abs(test::dot(w.adjoint(), w0) - through) <= 1e-12);
    auto sums = tapestry::zeros<double, 1>({8});
    for (std::size_t i = 0; i < g.size(); ++i) sums.data()[i % 8] += g.data()[i];
    CHECK(test::dot(b.adjoint(), b0) == Approx(test::dot(sums, b0)).epsilon(1e-12));
    const ArrayVariable<double, 4> plain = nn::convolve(ArrayVariable<double, 4>(x0), w, layer);
    CHECK(plain.value()(0, 0, 0, 0) == Approx(expected(0, 0, 0, 0)));
  }
}

TEST_CASE("layers of a network of one's own have the gradients of central differences",
          "[nn][layers][variable]") {
  const auto x = random_array<double>({2, 6, 6, 3}, 1, -1, 1);
  const ArrayVariable<double, 4> weights = random_array<double>({4, 3, 3, 3}, 2, -1, 1);
  const ArrayVariable<double, 1> scale = random_array<double>({3}, 3, 0.5, 1.5);
  const ArrayVariable<double, 1> bias = random_array<double>({3}, 4, -1, 1);
  CHECK(gradient_error(x, [&](const auto& of) { return nn::convolve(of, weights, {2, 1}); }) < 1e-8);
  CHECK(gradient_error(x, [&](const auto& of) { return nn::max_pool(of); }) < 1e-8);
  CHECK(gradient_error(x, [&](const auto& of) { return nn::average_pool(of, {3, 2, 1}); }) < 1e-8);
  CHECK(gradient_error(x, [&](const auto& of) { return nn::batch_norm(of, scale, bias); }) < 1e-7);
  CHECK(gradient_error(x, [&](const auto& of) {  // its own weights: both ways of an operand meet
          const ArrayVariable<double, 4> own = reshape(of, Extents<4>{8, 3, 3, 3});
          return nn::max_pool(nn::convolve(of, own, {1, 1}));
        }) < 1e-7);
}

TEST_CASE("layers without a tape record nothing, and pool as defined", "[nn][layers][variable]") {
  Array<double, 4> x0(Extents<4>{1, 2, 4, 1});
  for (std::size_t i = 0; i < 8; ++i) x0.data()[i] = static_cast<double>(i);
  const ArrayVariable<double, 4> x = x0;
  const auto largest = nn::max_pool(x), mean = nn::average_pool(x);
  CHECK_FALSE(largest.is_active());
  CHECK(std::vector<double>(largest.value().begin(), largest.value().end()) == std::vector<double>{5, 7});
  CHECK(std::vector<double>(mean.value().begin(), mean.value().end()) == std::vector<double>{2.5, 4.5});
}

TEST_CASE("layers name what does not fit", "[nn][layers][variable][error]") {
  const ArrayVariable<double, 4> x = random_array<double>({1, 3, 3, 2}, 1);
  const auto weights = [](const Extents<4>& extents) {
    return ArrayVariable<double, 4>(tapestry::zeros<double, 4>(extents));
  };
  CHECK_THROWS_WITH(nn::convolve(x, weights({1, 3, 2, 2})),
                    "nn::convolve: weights [1, 3, 2, 2] in 1 groups do not fit 2 channels");
  CHECK_THROWS_AS(nn::convolve(x, weights({1, 2, 4, 1})), Error);
  CHECK_THROWS_AS(nn::convolve(x, weights({1, 2, 1, 1}), {0, 0}), Error);
  CHECK_THROWS_AS(nn::max_pool(x, {4, 1, 0}), Error);
  const ArrayVariable<double, 1> three = random_array<double>({3}, 3);
  CHECK_THROWS_AS(nn::batch_norm(x, three, three), ShapeError);
}
