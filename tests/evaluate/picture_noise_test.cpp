#include <tapestry/evaluate/controls.hpp>

#include "../support/charts.hpp"
#include "../support/threads.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
constexpr std::size_t side = 96;

camouflage::View<float> tiny_view(image::ColourSpace space, std::size_t number = 1) {
  auto car = test::tiny_car();
  car.space = space;
  return camouflage::make_view<float>(test::tiny_frame(number, side), car, side, side);
}

/// Texels of random colours, each as large as some pixels.
camouflage::Paint<float> checked_paint() {
  const auto car = test::tiny_car();
  Random random(4);
  return {camouflage::random_colours<float>(car.layout.texel_count(car.mesh), random)};
}

Array<float, 3> light_of(const camouflage::View<float>& view, const camouflage::Paint<float>& paint,
                         float colour) {
  auto colours = paint.colours;
  for (std::size_t texel = 0; texel < colours.shape(0); ++texel)
    for (std::size_t c = 0; c < 3; ++c)
      if (paint.painted.empty() || paint.painted[texel] != 0) colours(texel, c) = colour;
  return image::in_space(view.space, camouflage::picture_of(view, colours));
}

/// The paint that pixels show, in the view's space, from the same picture in white and in black: pixels where
/// these differ, as a chart whose texels begin at 0.
struct ShownPaint {
  raster::TextureChart chart{side, side};
  Array<float, 2> colours{};
};

ShownPaint shown_paint(const camouflage::View<float>& view, const camouflage::Paint<float>& paint,
                       const Array<float, 3>& encoded) {
  const auto dark = light_of(view, paint, 0), white = light_of(view, paint, 1);
  const auto picture = image::in_space(view.space, encoded);
  ShownPaint shown;
  std::vector<float> values;
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      if (white(y, x, 0) - dark(y, x, 0) < 0.02F) continue;
      shown.chart.texels.push_back({y, x, shown.chart.texels.size()});
      for (std::size_t c = 0; c < 3; ++c)
        values.push_back((picture(y, x, c) - dark(y, x, c)) / (white(y, x, c) - dark(y, x, c)));
    }
  shown.colours = Array<float, 2>(Extents<2>{shown.chart.texels.size(), 3});
  std::copy(values.begin(), values.end(), shown.colours.begin());
  return shown;
}
}  // namespace

TEST_CASE("noise in a picture has the paint's values there, in the same light", "[evaluate][picture_noise]") {
  for (const auto space : image::colour_spaces) {
    const auto view = tiny_view(space);
    const auto paint = checked_paint();
    const auto noisy = evaluate::picture_with_noise(view, paint, Random(1));
    const auto own = shown_paint(view, paint, camouflage::picture_of(view, paint.colours)),
               noise = shown_paint(view, paint, noisy);
    REQUIRE(own.chart.texels.size() > 1000);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto a = test::sorted_values(own.colours, own.chart, c),
                 b = test::sorted_values(noise.colours, noise.chart, c);
      // Pixels with little light are in the noise's chart and not in the test's, or the other way round.
      const std::size_t away = own.chart.texels.size() / 50;
      for (std::size_t i = away; i + away < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) < 0.03F);
    }
  }
}

TEST_CASE("noise in a picture has the paint's spectrum there and nothing of its design",
          "[evaluate][picture_noise]") {
  const auto view = tiny_view(image::ColourSpace::encoded);
  const auto paint = checked_paint();
  const auto own = shown_paint(view, paint, camouflage::picture_of(view, paint.colours));
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto noise = shown_paint(view, paint, evaluate::picture_with_noise(view, paint, Random(seed)));
    const auto white = test::white_noise_of(own.colours, seed);
    CHECK(test::spectrum_distance(noise.colours, own.colours, own.chart, 4) <
          test::spectrum_distance(white, own.colours, own.chart, 4) / 2);
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(std::abs(test::correlation(noise.colours, c, own.colours, c, own.chart)) < 0.2);
  }
}

TEST_CASE("noise in a picture leaves all else as it is", "[evaluate][picture_noise]") {
  const auto view = tiny_view(image::ColourSpace::linear);
  auto paint = checked_paint();
  paint.painted.assign(paint.colours.shape(0), 0);
  for (std::size_t texel = 0; texel < paint.painted.size(); texel += 24)  // the left half of the atlas
    std::fill_n(paint.painted.begin() + static_cast<std::ptrdiff_t>(texel), 12, std::uint8_t{1});
  const auto picture = camouflage::picture_of(view, paint.colours),
             noisy = evaluate::picture_with_noise(view, paint, Random(1));
  const auto dark = light_of(view, paint, 0), white = light_of(view, paint, 1);
  std::size_t kept = 0, changed = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (dark.data()[i] == white.data()[i]) {
      ++kept;
      CHECK(noisy.data()[i] == picture.data()[i]);
    }
    changed += noisy.data()[i] != picture.data()[i] ? 1U : 0U;
  }
  CHECK(kept > picture.size() / 2);
  CHECK(changed > 1000);
}

TEST_CASE("noise in a picture follows from its seed, for any number of threads",
          "[evaluate][picture_noise]") {
  const auto view = tiny_view(image::ColourSpace::linear);
  const auto paint = checked_paint();
  const auto noisy = evaluate::picture_with_noise(view, paint, Random(7));
  const test::Threads one(1);
  CHECK(noisy.storage() == evaluate::picture_with_noise(view, paint, Random(7)).storage());
  CHECK_FALSE(noisy.storage() == evaluate::picture_with_noise(view, paint, Random(8)).storage());
}

TEST_CASE("a picture that does not show its car has no noise", "[evaluate][picture_noise]") {
  auto frame = test::tiny_frame(1, side);
  frame.mask = tapestry::zeros<std::uint8_t, 2>({side, side});
  const auto view = camouflage::make_view<float>(frame, test::tiny_car(), side, side);
  REQUIRE(view.visible_pixels == 0);
  const auto paint = checked_paint();
  CHECK(evaluate::picture_with_noise(view, paint, Random(1)).storage() ==
        camouflage::picture_of(view, paint.colours).storage());
  const camouflage::Paint<float> other{tapestry::zeros<float, 2>({3, 3})};
  CHECK_THROWS_AS(evaluate::picture_with_noise(view, other, Random(1)), ShapeError);
}
