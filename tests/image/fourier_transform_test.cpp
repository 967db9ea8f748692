#include <tapestry/image/fourier_transform.hpp>

#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

namespace image = tapestry::image;
using FourierTransform = image::FourierTransform<double>;

namespace {
FourierTransform::Plane random_plane(std::size_t size, std::uint64_t seed) {
  tapestry::Random random(seed);
  FourierTransform::Plane plane(size);
  for (double& value : plane) value = random.uniform(-1, 1);
  return plane;
}

/// F[k, l] by its definition.
std::complex<double> by_definition(const FourierTransform::Plane& plane, std::size_t height,
                                   std::size_t width, std::size_t k, std::size_t l) {
  std::complex<double> sum = 0;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      const double turns = static_cast<double>(k * y % height) / static_cast<double>(height) +
                           static_cast<double>(l * x % width) / static_cast<double>(width);
      sum += plane[y * width + x] * std::polar(1.0, -2 * std::numbers::pi * turns);
    }
  return sum;
}

const std::vector<std::array<std::size_t, 2>> extents{{1, 1},   {1, 2},  {2, 1},   {1, 7},  {5, 1},
                                                      {3, 4},   {4, 8},  {6, 6},   {7, 13}, {8, 10},
                                                      {11, 17}, {16, 9}, {35, 18}, {18, 35}};
}  // namespace

TEST_CASE("a Fourier transform equals its definition", "[image][fourier_transform]") {
  for (const auto [height, width] : extents) {
    CAPTURE(height, width);
    FourierTransform transform(height, width);
    const auto plane = random_plane(height * width, height * 31 + width);
    const auto spectrum = transform.forward(plane);
    REQUIRE(spectrum.size() == height * (width / 2 + 1));
    // Values below 1, each sum of H·W of them: rounding below a few ε times their number.
    const double tolerance = 1e-15 * static_cast<double>(height * width) + 4e-15;
    for (std::size_t k = 0; k < height; ++k)
      for (std::size_t l = 0; l <= width / 2; ++l)
        CHECK(std::abs(spectrum[k * (width / 2 + 1) + l] - by_definition(plane, height, width, k, l)) <=
              tolerance);
  }
}

TEST_CASE("the inverse Fourier transform gives the plane back", "[image][fourier_transform]") {
  for (const auto [height, width] : extents) {
    CAPTURE(height, width);
    FourierTransform transform(height, width);
    for (int call = 0; call < 2; ++call) {  // values kept between calls change nothing
      const auto plane = random_plane(height * width, height + width + static_cast<std::size_t>(call));
      const auto back = transform.inverse(transform.forward(plane));
      for (std::size_t i = 0; i < plane.size(); ++i) CHECK(std::abs(back[i] - plane[i]) <= 4e-15);
    }
  }
}

TEST_CASE("a Fourier transform in float is that in double to float's precision",
          "[image][fourier_transform]") {
  for (const auto [height, width] : extents) {
    CAPTURE(height, width);
    const auto plane = random_plane(height * width, height + 7 * width);
    const auto expected = FourierTransform(height, width).forward(plane);
    const image::FourierTransform<float> transform(height, width);
    const auto spectrum = transform.forward({plane.begin(), plane.end()});
    const auto back = transform.inverse(spectrum);
    for (std::size_t k = 0; k < expected.size(); ++k)
      CHECK(std::abs(std::complex<double>(spectrum[k]) - expected[k]) <=
            1e-6 * static_cast<double>(plane.size()));
    for (std::size_t i = 0; i < plane.size(); ++i)
      CHECK(std::abs(static_cast<double>(back[i]) - plane[i]) <= 1e-6);
  }
}

TEST_CASE("extents for Fourier transforms have small prime factors", "[image][fourier_transform]") {
  CHECK(image::fourier_extent(0) == 1);
  CHECK(image::fourier_extent(1) == 1);
  CHECK(image::fourier_extent(126) == 126);
  CHECK(image::fourier_extent(127) == 128);
  CHECK(image::fourier_extent(131) == 135);
  CHECK(image::fourier_extent(4097) == 4116);  // 2² · 3 · 7³
}

TEST_CASE("Fourier transforms name the extents that do not fit", "[image][fourier_transform]") {
  CHECK_THROWS_WITH(FourierTransform(0, 3),
                    "FourierTransform: found 0 rows and 3 columns, expected 1 to 1073741824");
  FourierTransform transform(2, 3);
  CHECK_THROWS_WITH(transform.forward(FourierTransform::Plane(5)),
                    "FourierTransform::forward: found 5 values, expected 6");
  CHECK_THROWS_WITH(transform.inverse(FourierTransform::Spectrum(6)),
                    "FourierTransform::inverse: found 6 values, expected 4");
  CHECK_THROWS_AS(transform.inverse({}), tapestry::ShapeError);
}
