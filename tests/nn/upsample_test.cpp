#include <tapestry/nn/detail/layout.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace nn = tapestry::nn;
using tapestry::test::random_array;

TEMPLATE_TEST_CASE("upsampling repeats each pixel, and its adjoint sums the copies up", "[nn][upsample]",
                   float, double) {
  constexpr std::size_t images = 2, height = 3, width = 5, channels = 7;
  for (const std::size_t factor : {1U, 2U, 3U}) {
    CAPTURE(factor);
    const auto in = random_array<TestType>({images, height, width, channels}, 1, -1, 1);
    const auto out_adjoint =
        random_array<TestType>({images, height * factor, width * factor, channels}, 2, -1, 1);
    auto out = out_adjoint;
    auto in_adjoint = random_array<TestType>({images, height, width, channels}, 3, -1, 1);
    auto expected = in_adjoint;  // adjoints add
    nn::upsample(images, height, width, channels, factor, in.data(), out.data());
    nn::upsample_adjoint(images, height, width, channels, factor, out_adjoint.data(), in_adjoint.data());
    for (std::size_t n = 0; n < images; ++n)
      for (std::size_t y = 0; y < height * factor; ++y)
        for (std::size_t x = 0; x < width * factor; ++x)
          for (std::size_t c = 0; c < channels; ++c) {
            REQUIRE(out(n, y, x, c) == in(n, y / factor, x / factor, c));
            expected(n, y / factor, x / factor, c) += out_adjoint(n, y, x, c);
          }
    for (std::size_t i = 0; i < in.size(); ++i)  // a fused multiplication may round once less
      REQUIRE(in_adjoint.data()[i] == Approx(expected.data()[i]).epsilon(1e-5));
  }
}
