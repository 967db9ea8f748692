#include <tapestry/autodiff/arrays/convolution.hpp>

#include <cmath>
#include <cstddef>

#include "../../support/catch.hpp"
#include "../../support/finite_difference.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::ConvolutionWindow;
using tapestry::Tape;
using tapestry::test::random_array;

namespace {
/// The definition, element by element.
Array<double, 3> convolved(const Array<double, 3>& x, const Array<double, 4>& w,
                           const ConvolutionWindow& window, std::size_t rows, std::size_t columns) {
  Array<double, 3> y = tapestry::zeros<double, 3>({w.shape(0), rows, columns});
  for (std::size_t o = 0; o < w.shape(0); ++o)
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j)
        for (std::size_t c = 0; c < x.shape(0); ++c)
          for (std::size_t r = 0; r < w.shape(2); ++r)
            for (std::size_t s = 0; s < w.shape(3); ++s) {
              const std::size_t row = i * window.stride + r, column = j * window.stride + s;
              if (row < window.padding || row - window.padding >= x.shape(1)) continue;
              if (column < window.padding || column - window.padding >= x.shape(2)) continue;
              y(o, i, j) += w(o, c, r, s) * x(c, row - window.padding, column - window.padding);
            }
  return y;
}
}  // namespace

TEST_CASE("convolve equals its definition, and its pullback is its transpose", "[autodiff][convolution]") {
  struct Case {
    ConvolutionWindow window;
    std::size_t rows, columns;
  };
  const auto x0 = random_array<double>({2, 5, 7}, 1, -1, 1);
  const auto w0 = random_array<double>({3, 2, 3, 2}, 2, -1, 1);
  for (const auto& [window, rows, columns] :
       {Case{{1, 0}, 3, 6}, Case{{2, 1}, 3, 4}, Case{{1, 3}, 9, 12}, Case{{3, 2}, 3, 4}}) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const auto x = tape.input(x0);
    const auto w = tape.input(w0);
    const ArrayVariable<double, 3> y = convolve(x, w, window);
    const auto expected = convolved(x0, w0, window, rows, columns);
    REQUIRE(y.shape() == expected.shape());
    for (std::size_t i = 0; i < expected.size(); ++i)
      CHECK(std::abs(y.value().data()[i] - expected.data()[i]) <= 1e-14);
    // ⟨g, y⟩ is linear in x and in w: with either's adjoint it is the same sum.
    const auto g = random_array<double>({3, rows, columns}, 3, -1, 1);
    tape.reverse(y, g);
    const double through = tapestry::test::dot(g, expected);
    CHECK(std::abs(tapestry::test::dot(x.adjoint(), x0) - through) <= 1e-13);
    CHECK(std::abs(tapestry::test::dot(w.adjoint(), w0) - through) <= 1e-13);
  }
}

TEST_CASE("convolve names what does not fit", "[autodiff][convolution]") {
  const ArrayVariable<double, 3> x = random_array<double>({2, 3, 3}, 1);
  CHECK_THROWS_WITH(convolve(x, random_array<double>({1, 3, 2, 2}, 2)),
                    "convolve: weights is [1, 3, 2, 2], expected [1, 2, 2, 2]");
  CHECK_THROWS_WITH(convolve(x, random_array<double>({1, 2, 4, 1}, 2)),
                    "convolve: 4 taps for 3 elements with their padding");
  CHECK_THROWS_WITH(convolve(x, random_array<double>({1, 2, 1, 1}, 2), {0, 0}), "convolve: stride 0");
}
