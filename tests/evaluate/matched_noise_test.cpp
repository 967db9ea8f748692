#include <tapestry/evaluate/controls.hpp>

#include "../support/charts.hpp"
#include "../support/random_array.hpp"
#include "../support/threads.hpp"

using namespace tapestry;

namespace {
bool in_ellipse(std::size_t row, std::size_t column) {
  const double y = (static_cast<double>(row) - 15.5) / 16, x = (static_cast<double>(column) - 23.5) / 24;
  return x * x + y * y < 1;
}

/// A corner of a frame: a third of its box.
bool in_corner(std::size_t row, std::size_t column) { return row < 5 || column < 5; }

void check_same_values(const Array<float, 2>& a, const Array<float, 2>& b,
                       const raster::TextureChart& chart) {
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(test::sorted_values(a, chart, c) == test::sorted_values(b, chart, c));
}

/// \param band         of the spectra, so many frequencies wide
/// \param distance     the most of the spectra
/// \param correlation  the most that the correlations of channels, which go together in the original, differ
void check_noise(const raster::TextureChart& chart, std::uint64_t seed, std::size_t band, double distance,
                 double correlation) {
  const auto colours = test::blotched_colours(chart, seed);
  const auto noise = evaluate::matched_noise(colours, {chart}, Random(seed));
  check_same_values(noise, colours, chart);
  const double white = test::spectrum_distance(test::white_noise_of(colours, seed), colours, chart, band);
  const double found = test::spectrum_distance(noise, colours, chart, band);
  CHECK(found < distance);
  CHECK(found < white / 4);
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(std::abs(test::correlation(noise, c, noise, (c + 1) % 3, chart) -
                   test::correlation(colours, c, colours, (c + 1) % 3, chart)) < correlation);
}
}  // namespace

TEST_CASE("matched noise of a full box has its values exactly, and its spectrum nearly",
          "[evaluate][matched_noise]") {
  for (const std::array<std::size_t, 2> extent : {std::array<std::size_t, 2>{24, 40}, {21, 35}, {1, 400}})
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      CAPTURE(extent[0], extent[1], seed);
      check_noise(test::rectangle_chart(extent[0], extent[1]), seed, 1, 0.2, 0.05);
    }
}

TEST_CASE("matched noise of a chart within its box has its values exactly, and its spectrum in bands",
          "[evaluate][matched_noise]") {
  const auto chart = test::chart_of(32, 48, in_ellipse);
  for (const std::uint64_t seed : {1U, 2U, 3U}) check_noise(chart, seed, 3, 0.16, 0.15);
}

TEST_CASE("matched noise has nothing of the design", "[evaluate][matched_noise]") {
  // Blobs of a variance of 2 · 2/2 texels along each axis are about n = N/12 independent values a channel, so
  // that a correlation has a standard deviation of 1/√n: 0.11 and 0.22; the mean of 16 draws a quarter of it.
  const auto chart = GENERATE(test::rectangle_chart(24, 40), test::chart_of(24, 30, in_corner));
  const double deviation = std::sqrt(12 / static_cast<double>(chart.texels.size()));
  double sum = 0, largest = 0;
  const std::size_t draws = 16;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const auto colours = test::blotched_colours(chart, draw);
    const auto noise = evaluate::matched_noise(colours, {chart}, Random(draw));
    for (std::size_t c = 0; c < 3; ++c) {
      const double found = test::correlation(noise, c, colours, c, chart);
      sum += found / 3;
      largest = std::max(largest, std::abs(found));
    }
  }
  CHECK(std::abs(sum / draws) < 3 * deviation / std::sqrt(static_cast<double>(draws)));
  CHECK(largest < 4 * deviation);  // the rounds do not lead back to the design, where it would be 1
}

TEST_CASE("matched noise follows from its seed, for any number of threads", "[evaluate][matched_noise]") {
  const auto chart = test::rectangle_chart(9, 14);
  const auto second = test::chart_of(
      7, 5, [](std::size_t row, std::size_t column) { return row != column; }, chart.texels.size());
  const auto colours = test::random_array<float>({chart.texels.size() + second.texels.size() + 3, 3}, 4);
  const auto noise = test::same_by_threads({1, 2, 2}, [&] {
    return evaluate::matched_noise(colours, {chart, second}, Random(5));
  });
  CHECK((evaluate::matched_noise(colours, {chart, second}, Random(6)) != noise));

  check_same_values(noise, colours, chart);  // each chart for itself
  check_same_values(noise, colours, second);
  for (std::size_t texel = colours.shape(0) - 3; texel < colours.shape(0); ++texel)
    for (std::size_t c = 0; c < 3; ++c) CHECK(noise(texel, c) == colours(texel, c));  // in no chart
}

TEST_CASE("matched noise of charts without room for it", "[evaluate][matched_noise]") {
  const auto constant = tapestry::filled<float, 2>({20, 3}, 0.3F);
  CHECK((evaluate::matched_noise(constant, {test::rectangle_chart(4, 5)}, Random(1)) == constant));
  const auto colours = test::random_array<float>({20, 3}, 7);
  CHECK((evaluate::matched_noise(colours, {test::rectangle_chart(1, 1)}, Random(1)) == colours));
  CHECK((evaluate::matched_noise(colours, {}, Random(1)) == colours));
  CHECK((evaluate::matched_noise(colours, {raster::TextureChart{}}, Random(1)) == colours));
  for (const auto& narrow : {test::rectangle_chart(20, 1), test::rectangle_chart(1, 20),
                             test::chart_of(20, 20, [](auto row, auto column) { return row == column; })}) {
    const auto noise = evaluate::matched_noise(colours, {narrow}, Random(1));
    CHECK((noise != colours));
    check_same_values(noise, colours, narrow);
  }
}

TEST_CASE("matched noise refuses colours that are not finite or do not fit",
          "[evaluate][matched_noise][error]") {
  auto colours = test::random_array<float>({20, 3}, 7);
  const auto chart = test::rectangle_chart(4, 4);
  CHECK_THROWS_WITH(evaluate::matched_noise(colours, {test::rectangle_chart(4, 6)}, Random(1)),
                    "matched_noise: a chart has texel 20 of a texture of 20");
  CHECK_THROWS_WITH(evaluate::matched_noise(test::random_array<float>({20, 4}, 7), {chart}, Random(1)),
                    "matched_noise: colours are [20, 4], expected 3 channels");
  colours(17, 1) = std::numeric_limits<float>::quiet_NaN();  // in no chart: nobody sees it
  CHECK_NOTHROW(evaluate::matched_noise(colours, {chart}, Random(1)));
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    colours(5, 2) = value;
    CHECK_THROWS_AS(evaluate::matched_noise(colours, {chart}, Random(1)), NumericError);
    CHECK_THROWS_WITH(evaluate::matched_noise(colours, {chart}, Random(1)),
                      "matched_noise: texel 5 has a colour that is not finite");
  }
}
