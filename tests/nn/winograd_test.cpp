#include <tapestry/nn/engine.hpp>

#include "../support/random_buffer.hpp"
#include "../support/relative_distance.hpp"

namespace nn = tapestry::nn;
using tapestry::test::random_buffer;

namespace {
const nn::Engine engines[] = {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                              nn::Engine::winograd_f4};

template <class T>
nn::Buffer<T> convolved(nn::Engine engine, const nn::ConvolutionShape& s, const nn::Buffer<double>& in,
                        const nn::Buffer<double>& weights) {
  nn::Buffer<T> from(in.size());
  for (std::size_t i = 0; i < in.size(); ++i) from.data()[i] = static_cast<T>(in.data()[i]);
  const auto packed = nn::pack_convolution<T>(s, [&](std::size_t i) { return weights.data()[i]; });
  nn::Buffer<T> out(s.out_size());
  nn::convolve<T>(engine, packed, 1, from.data(), {}, out.data(), s.out_size());
  return out;
}

double error_of(nn::Engine engine, const nn::ConvolutionShape& s) {
  const auto in = random_buffer<double>(s.in_size(), 1);
  const auto weights = random_buffer<double>(s.weight_count(), 2);
  const auto expected = convolved<double>(nn::Engine::direct, s, in, weights);
  const auto found = convolved<float>(engine, s, in, weights);
  return tapestry::test::relative_distance(found.data(), expected.data(), expected.size());
}
}  // namespace

TEST_CASE("every engine's rounding is bounded, whatever the number of channels", "[nn][winograd]") {
  const std::size_t stride = GENERATE(1U, 2U);
  for (const std::size_t channels : {16U, 64U, 256U}) {
    const auto shape = nn::square_convolution(13, 13, channels, 20, 3, stride, 1);
    CAPTURE(channels, stride);
    CHECK(error_of(nn::Engine::direct, shape) < 6e-7);
    CHECK(error_of(nn::Engine::winograd_f2, shape) < 6e-7);
    CHECK(error_of(nn::Engine::winograd_f4, shape) < 1.2e-6);
  }
}

TEST_CASE("a reduction of 9216 products is as accurate as a short one", "[nn][winograd]") {
  const auto shape = nn::square_convolution(6, 5, 1024, 17, 3, 1, 1);
  for (const auto engine : engines) {
    CAPTURE(nn::name_of(engine));
    CHECK(error_of(engine, shape) < 1.2e-6);
  }
}

TEST_CASE("NaN reaches every output that reads it, by any engine", "[nn][winograd]") {
  const auto shape = nn::square_convolution(11, 14, 5, 6, 3, 1, 1);
  auto in = random_buffer<double>(shape.in_size(), 1);
  const auto weights = random_buffer<double>(shape.weight_count(), 2);
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  in.data()[(4 * 14 + 7) * 5 + 2] = bad;
  for (const auto engine : engines) {
    CAPTURE(nn::name_of(engine), bad);
    const auto out = convolved<float>(engine, shape, in, weights);
    bool is_visible = true, is_finite_elsewhere = true;
    for (std::size_t y = 0; y < 11; ++y)
      for (std::size_t x = 0; x < 14; ++x)
        for (std::size_t m = 0; m < 6; ++m) {
          const bool is_finite = std::isfinite(out.data()[(y * 14 + x) * 6 + m]);
          const bool reads = y >= 3 && y <= 5 && x >= 6 && x <= 8;
          const bool is_far = y > 4 + 8 || x > 7 + 5 || x + 5 < 7;  // no tile reaches further
          is_visible = is_visible && !(reads && is_finite);
          is_finite_elsewhere = is_finite_elsewhere && (!is_far || is_finite);
        }
    CHECK(is_visible);
    CHECK(is_finite_elsewhere);
  }
}

TEST_CASE("zeros, constants and denormals go through every engine", "[nn][winograd]") {
  const auto shape = nn::square_convolution(7, 9, 5, 6, 3, 1, 1);
  nn::Buffer<double> in(shape.in_size()), weights(shape.weight_count());
  for (std::size_t i = 0; i < weights.size(); ++i) weights.data()[i] = 0.25;
  for (const auto engine : engines) {
    CAPTURE(nn::name_of(engine));
    for (const double value : {0.0, 1.0, 1e-41, 1e36}) {
      for (std::size_t i = 0; i < in.size(); ++i) in.data()[i] = value;
      const auto out = convolved<float>(engine, shape, in, weights);
      CAPTURE(value);
      const auto centre = static_cast<double>(out.data()[(3 * 9 + 4) * 6 + 1]);
      const auto corner = static_cast<double>(out.data()[0]);
      const double ulp = 1.5e-45;  // the denormals' spacing
      CHECK(centre == Approx(45 * value / 4).epsilon(2e-6).margin(90 * ulp));
      CHECK(corner == Approx(20 * value / 4).epsilon(4e-6).margin(90 * ulp));
    }
  }
}

TEMPLATE_TEST_CASE("every instruction set of this machine transforms alike", "[nn][vector_kernels]", float,
                   double) {
  constexpr double epsilon = static_cast<double>(std::numeric_limits<TestType>::epsilon());
  constexpr std::size_t channels = 16;  // whole vectors of every set
  const auto in = random_buffer<TestType>(36 * channels, 1);
  const auto weights = random_buffer<TestType>(9 * channels, 2);
  for (const auto set : tapestry::instruction_sets())
    for (std::size_t which = 0; which < nn::winograd_form_count; ++which) {
      const auto kernels = nn::kernels_of<TestType>(set);
      const auto axis = nn::extents_of(static_cast<nn::WinogradForm>(which));
      const std::size_t tile = axis.outputs, points = axis.points;
      const std::size_t count = points * points;
      const TestType* pixels[36];
      for (std::size_t i = 0; i < count; ++i) pixels[i] = in.data() + i * channels;
      nn::Buffer<TestType> filters(count * channels), inputs(count * channels);
      nn::Buffer<TestType> out(tile * tile * channels);
      kernels.winograd_filters[which]({weights.data(), channels, 1, channels, filters.data(), channels});
      kernels.winograd_input[which]({pixels, 0, channels, inputs.data(), channels});
      for (std::size_t i = 0; i < count * channels; ++i) inputs.data()[i] *= filters.data()[i];
      kernels.winograd_output[which](
          {inputs.data(), channels, tile, tile, out.data(), tile * channels, channels, channels, {}});
      for (std::size_t y = 0; y < tile; ++y)
        for (std::size_t x = 0; x < tile; ++x)
          for (std::size_t lane = 0; lane < channels; ++lane) {
            double expected = 0;
            for (std::size_t t = 0; t < axis.taps * axis.taps; ++t) {
              const std::size_t row = y + t / axis.taps;
              const std::size_t column = x + t % axis.taps;
              expected += static_cast<double>(weights.data()[t * channels + lane]) *
                          static_cast<double>(pixels[row * points + column][lane]);
            }
            CHECK(out.data()[(y * tile + x) * channels + lane] == Approx(expected).margin(450 * epsilon));
          }
    }
}

TEST_CASE("the automatic engine sums directly where tiles would be mostly empty", "[nn][winograd]") {
  const auto form_of = [](std::size_t size, std::size_t in, std::size_t out, std::size_t stride) {
    const auto shape = nn::square_convolution(size, size, in, out, 3, stride, 1);
    return nn::detail::winograd_form(nn::Engine::automatic,
                                     nn::pack_convolution<float>(shape, [](std::size_t) { return 0; }));
  };
  CHECK(!form_of(1, 64, 64, 1));
  CHECK(!form_of(208, 3, 2 * nn::kernels<float>().lanes, 1));
  CHECK(form_of(52, 128, 256, 1) == nn::WinogradForm::f4_taps3);
  CHECK(form_of(13, 512, 1024, 1) == nn::WinogradForm::f4_taps3);
  CHECK(!form_of(104, 128, 256, 2));
}
