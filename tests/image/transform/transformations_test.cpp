#include <tapestry/image/colour_space.hpp>
#include <tapestry/image/detail/transform/camera_effects.hpp>
#include <tapestry/image/detail/transform/warp.hpp>
#if defined(TAPESTRY_JPEG)
#include <turbojpeg.h>
#endif

#include "../../support/random_array.hpp"
#include "../../support/relative_distance.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// A smooth picture: waves, whose values everywhere are known.
double wave(double x, double y, std::size_t c) {
  return 0.5 + 0.2 * std::sin(0.11 * x + 0.05 * y + static_cast<double>(c)) + 0.1 * std::cos(0.09 * y);
}

Array<double, 3> waves(std::size_t height, std::size_t width) {
  Array<double, 3> picture(Extents<3>{height, width, 3});
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        picture(y, x, c) = wave(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, c);
  return picture;
}
}  // namespace

TEST_CASE("a camera that does not move sees the same picture", "[image][transform][warp]") {
  const auto picture = random_array<double>({7, 9, 3}, 1);
  const auto same = image::transformed(picture, image::warp_of({}));
  for (std::size_t i = 0; i < picture.size(); ++i)
    CHECK(same.data()[i] == Approx(picture.data()[i]).epsilon(1e-12));
}

TEST_CASE("a moved camera sees a point of the world where it projects it", "[image][transform][warp]") {
  image::CameraMotion motion;
  motion.pan_rad = 0.06;
  motion.tilt_rad = 0.03;
  motion.roll_rad = -0.08;
  motion.zoom = 1.1;
  motion.focal = 1.4;
  const std::size_t height = 80, width = 120;
  const auto warp = image::warp_of(motion);
  const double half = 60;
  for (const auto& [x, y, z] :
       {std::array{0.2, -0.1, 1.0}, std::array{-3.0, 1.0, 9.0}, std::array{0.0, 0.0, 2.0}}) {
    // Undo the motion by hand: pan about y, then tilt about x, then roll about z, each by its angle.
    const double x1 = std::cos(motion.pan_rad) * x - std::sin(motion.pan_rad) * z;
    const double z1 = std::sin(motion.pan_rad) * x + std::cos(motion.pan_rad) * z;
    const double y2 = std::cos(motion.tilt_rad) * y - std::sin(motion.tilt_rad) * z1;
    const double z2 = std::sin(motion.tilt_rad) * y + std::cos(motion.tilt_rad) * z1;
    const double x3 = std::cos(motion.roll_rad) * x1 + std::sin(motion.roll_rad) * y2;
    const double y3 = -std::sin(motion.roll_rad) * x1 + std::cos(motion.roll_rad) * y2;
    const double focal = motion.focal * half;
    const auto moved =
        image::WarpedPoint(warp, height, width)(half + focal * x / z, 40 + focal * y / z).value();
    CHECK(moved[0] == Approx(half + motion.zoom * focal * x3 / z2).epsilon(1e-12));
    CHECK(moved[1] == Approx(40 + motion.zoom * focal * y3 / z2).epsilon(1e-12));
  }
  motion.pan_rad = 1.5;
  CHECK_FALSE(image::WarpedPoint(image::warp_of(motion), height, width)(0, 40));  // behind the camera
}

TEST_CASE("a warped picture shows at a point what was where it came from", "[image][transform][warp]") {
  const std::size_t height = 60, width = 90;
  const auto warp = image::warp_of({0.03, -0.02, 0.05, 1.1, 1});
  const auto out = image::transformed(waves(height, width), warp);
  std::size_t inside = 0;
  for (double y = 12.5; y < 48; y += 5)
    for (double x = 12.5; x < 78; x += 5) {
      const auto at = image::WarpedPoint(warp, height, width)(x, y).value();
      const auto column = static_cast<std::size_t>(at[0]), row = static_cast<std::size_t>(at[1]);
      if (at[0] < 1 || at[1] < 1 || column + 1 >= width || row + 1 >= height) continue;
      ++inside;
      CHECK(std::abs(out(row, column, 1) - wave(x, y, 1)) <= 0.03);  // at most 0.7 pixels away, slope 0.033
    }
  CHECK(inside > 50);
}

TEST_CASE("warps look at the edge beyond it, and behind the camera", "[image][transform][warp][hard]") {
  const auto grey = tapestry::filled<float, 3>({6, 6, 3}, 0.25F);
  for (const double pan : {0.5, 1.5, 3.0}) {
    image::CameraMotion motion;
    motion.pan_rad = pan;
    const auto out = image::transformed(grey, image::warp_of(motion));
    for (const float value : out.storage()) CHECK(value == Approx(0.25F));
  }
  const auto one = tapestry::filled<double, 3>({1, 1, 3}, 0.7);
  CHECK(image::transformed(one, image::warp_of({0.1, 0.1, 0.1, 2, 1}))(0, 0, 0) == Approx(0.7));
}

TEST_CASE("a stop of exposure is nearly what the sRGB curve says", "[image][transform][light]") {
  const auto decode = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  const auto encode = [](double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  };
  for (const double gain : {0.5, 2.0}) {
    double worst = 0;
    for (int i = 0; i <= 255; ++i) {
      const double value = i / 255.0;
      const auto out = image::transformed(tapestry::filled<double, 3>({1, 1, 3}, value),
                                          image::LightChange{{gain, gain, gain}});
      worst = std::max(worst, std::abs(out(0, 0, 0) - std::min(1.0, encode(gain * decode(value)))));
    }
    CHECK(worst <= 0.018);
  }
}

TEST_CASE("a shadow is dark on its side only, and soft between", "[image][transform][light]") {
  const auto picture = tapestry::filled<double, 3>({20, 40, 3}, 0.8);
  const image::LightChange shadow{{1, 1, 1}, 0.5, 0, 0.25, 0.1};  // from 5 pixels right of the middle on
  const auto out = image::transformed(picture, shadow);
  const double dark = 0.8 * std::pow(0.5, 1 / 2.2);
  CHECK(out(3, 0, 0) == 0.8);
  CHECK(out(3, 22, 1) == 0.8);
  CHECK(out(3, 27, 1) == Approx(dark).epsilon(1e-14));
  CHECK(out(19, 39, 2) == Approx(dark).epsilon(1e-14));
  CHECK(out(3, 24, 0) > out(3, 25, 0));
}

TEST_CASE("contrast turns about mid grey and saturation about luma", "[image][transform][colour]") {
  const Array<double, 3> picture = {{{0.2, 0.6, 0.4}}};
  const auto flat = image::transformed(picture, image::contrast_and_saturation(0, 1));
  const auto grey = image::transformed(picture, image::contrast_and_saturation(1, 0));
  const auto same = image::transformed(picture, image::contrast_and_saturation(1, 1));
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(flat(0, 0, c) == Approx(0.5));
    CHECK(grey(0, 0, c) == Approx(0.299 * 0.2 + 0.587 * 0.6 + 0.114 * 0.4));
    CHECK(same(0, 0, c) == Approx(picture(0, 0, c)));
  }
}

TEST_CASE("blur keeps a constant, and spreads a point as a Gaussian", "[image][transform][blur]") {
  const auto constant = image::transformed(tapestry::filled<double, 3>({5, 40, 3}, 0.3), image::Blur{9, 2});
  for (const double value : constant.storage()) CHECK(value == Approx(0.3).epsilon(1e-13));
  Array<double, 3> point = tapestry::zeros<double, 3>({41, 51, 3});
  point(20, 25, 1) = 1;
  const auto spread = image::transformed(point, image::Blur{2.5, 1.5});
  double sum = 0, across = 0, down = 0;
  for (std::size_t y = 0; y < 41; ++y)
    for (std::size_t x = 0; x < 51; ++x) {
      sum += spread(y, x, 1);
      across += spread(y, x, 1) * std::pow(static_cast<double>(x) - 25, 2);
      down += spread(y, x, 1) * std::pow(static_cast<double>(y) - 20, 2);
      CHECK(spread(y, x, 0) == 0);
    }
  CHECK(sum == Approx(1).epsilon(1e-13));
  CHECK(across == Approx(2.5 * 2.5).epsilon(0.03));  // cut at 3σ
  CHECK(down == Approx(1.5 * 1.5).epsilon(0.03));
  CHECK((image::transformed(point, image::Blur{0, 0}) == point));
}

TEST_CASE("sensor noise has the mean and the variance that its model says", "[image][transform][noise]") {
  const double value = 0.3;
  const image::SensorNoise noise{0.004, 0.02, 5};
  const auto picture = tapestry::filled<double, 3>({200, 200, 3}, value);
  const auto out = image::transformed(picture, noise);
  double mean = 0, variance = 0, kurtosis = 0;
  for (const double v : out.storage()) mean += (v - value) / static_cast<double>(out.size());
  for (const double v : out.storage()) variance += std::pow(v - value, 2) / static_cast<double>(out.size());
  for (const double v : out.storage())
    kurtosis += std::pow(v - value, 4) / (variance * variance) / static_cast<double>(out.size());
  const double expected = 0.004 * value + 0.02 * 0.02;
  CHECK(std::abs(mean) <= 4 * std::sqrt(expected / 120000));
  CHECK(variance == Approx(expected).epsilon(0.015));
  CHECK(kurtosis == Approx(2.7).epsilon(0.02));  // 3 − 6/5 / 4 for four uniform numbers
  CHECK((image::transformed(picture, noise) == out));
  CHECK_FALSE((image::transformed(picture, image::SensorNoise{0.004, 0.02, 6}) == out));
}

TEST_CASE("JPEG of quality 100 and of a constant change little", "[image][transform][jpeg]") {
  const auto picture = waves(24, 40);
  const auto out = image::transformed(picture, image::JpegCompression{100, false});
  CHECK(test::largest_difference(out, picture) <= 3.0 / 255);
  const auto grey = tapestry::filled<double, 3>({3, 5, 3}, 128.0 / 255);
  const auto same = image::transformed(grey, image::JpegCompression{10});
  for (const double value : same.storage()) CHECK(value == Approx(128.0 / 255).epsilon(1e-12));
}

TEST_CASE("smooth rounding stays within an eighth of a step and a half", "[image][transform][jpeg]") {
  // Takes two pictures that differ in their rounding only. The smooth one lies between the exact one and its
  // input: at equal cosines their luma differs by at most (1/2)³ of a step for each coefficient.
  const auto picture = random_array<double>({8, 8, 3}, 3, 0.3, 0.7);
  const auto hard = image::transformed(picture, image::JpegCompression{50, false, false});
  const auto smooth = image::transformed(picture, image::JpegCompression{50, false, true});
  double to_hard = 0, to_picture = 0, hard_to_picture = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    to_hard += std::pow(smooth.data()[i] - hard.data()[i], 2);
    to_picture += std::pow(smooth.data()[i] - picture.data()[i], 2);
    hard_to_picture += std::pow(hard.data()[i] - picture.data()[i], 2);
  }
  CHECK(to_hard > 0);
  CHECK(to_hard < 0.1 * hard_to_picture);
  CHECK(to_picture < hard_to_picture);
}

#if defined(TAPESTRY_JPEG)
TEST_CASE("JPEG equals libjpeg-turbo's compression and decompression", "[image][transform][jpeg][peer]") {
  const int quality = GENERATE(20, 50, 75, 95);
  const bool is_halved = GENERATE(false, true);
  const std::size_t height = 45, width = 61;
  auto picture = waves(height, width);
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.data()[i] += random_array<double>({1}, i, -0.05, 0.05).data()[0];
  const auto bytes = image::to_bytes(picture);
  const tjhandle compressor = tjInitCompress(), decompressor = tjInitDecompress();
  unsigned char* file = nullptr;
  unsigned long size = 0;
  REQUIRE(tjCompress2(compressor, bytes.data(), static_cast<int>(width), 0, static_cast<int>(height),
                      TJPF_RGB, &file, &size, is_halved ? TJSAMP_420 : TJSAMP_444, quality,
                      TJFLAG_ACCURATEDCT) == 0);
  Array<std::uint8_t, 3> theirs(bytes.shape());
  REQUIRE(tjDecompress2(decompressor, file, size, theirs.data(), static_cast<int>(width), 0,
                        static_cast<int>(height), TJPF_RGB, TJFLAG_ACCURATEDCT | TJFLAG_FASTUPSAMPLE) == 0);
  tjFree(file);
  tjDestroy(compressor);
  tjDestroy(decompressor);
  const auto ours = image::to_bytes(
      image::transformed(image::from_bytes<double>(bytes), image::JpegCompression{quality, is_halved}));
  double to_theirs = 0, to_picture = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    to_theirs += std::pow(int(ours.data()[i]) - int(theirs.data()[i]), 2);
    to_picture += std::pow(int(ours.data()[i]) - int(bytes.data()[i]), 2);
  }
  // libjpeg also rounds luma, chroma and colours to whole numbers: a few coefficients become their
  // neighbours. A wrong table, scale or order of coefficients differs as much as the picture does.
  INFO("quality " << quality << ", halved " << is_halved << ": rms from theirs "
                  << std::sqrt(to_theirs / static_cast<double>(ours.size())) << ", from the picture "
                  << std::sqrt(to_picture / static_cast<double>(ours.size())));
  CHECK(std::sqrt(to_theirs) <=
        0.3 * std::sqrt(to_picture) + 1.3 * std::sqrt(static_cast<double>(ours.size())));
}
#endif
