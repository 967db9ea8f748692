#include <tapestry/nn/detail/batch_norm.hpp>

#include "../support/catch.hpp"

namespace nn = tapestry::nn;

TEST_CASE("batch normalisation of a constant, a nearly constant and a huge channel stays finite",
          "[nn][batch_norm]") {
  // Channel 0 does not vary, channel 1 has variance 1e-30 about 0, channel 2 about 1e30.
  const std::size_t pixels = 8;
  nn::Buffer<float> in(3 * pixels);
  for (std::size_t p = 0; p < pixels; ++p) {
    const float sign = p % 2 == 0 ? 1.0F : -1.0F;
    in.data()[3 * p] = 5;
    in.data()[3 * p + 1] = sign * 1e-15F;
    in.data()[3 * p + 2] = sign * 1e15F;
  }
  const auto statistics = nn::batch_statistics(in.data(), pixels, 3, 1e-6);
  CHECK(statistics.mean[0] == 5);
  CHECK(statistics.variance[0] == 0);
  CHECK(statistics.variance[1] == Approx(1e-30).epsilon(1e-6));
  CHECK(statistics.variance[2] == Approx(1e30).epsilon(1e-6));
  const std::vector<float> scale{2, 2, 2}, bias{7, 7, 7};
  nn::Buffer<float> out(3 * pixels);
  nn::batch_norm(statistics, scale.data(), bias.data(), in.data(), pixels, out.data());
  CHECK(out.data()[0] == 7);
  CHECK(out.data()[1] == Approx(7 + 2 * 1e-15 / 1e-3));
  CHECK(out.data()[2] == Approx(9));
  CHECK(out.data()[5] == Approx(5));

  // A constant channel's deviation is √ε, so its adjoint is large but finite, and sums to 0.
  nn::Buffer<float> adjoint(3 * pixels);
  for (std::size_t i = 0; i < adjoint.size(); ++i) adjoint.data()[i] = i < 3 ? 1.0F : 0.0F;
  nn::batch_norm_adjoint<float>(statistics, scale.data(), in.data(), pixels, adjoint.data(), nullptr,
                                nullptr);
  double sum = 0;
  for (std::size_t p = 0; p < pixels; ++p) sum += static_cast<double>(adjoint.data()[3 * p]);
  CHECK(adjoint.data()[0] == Approx(2 * 1e3 * (1 - 1.0 / 8)));
  CHECK(std::abs(sum) < 1e-2);
}
