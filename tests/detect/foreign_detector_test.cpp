#include <tapestry/detect/detector.hpp>

#include <tapestry/detect/box_decode.hpp>
#include <vector>

#include "../support/catch.hpp"

namespace detect = tapestry::detect;
using Foreign = detect::Detector<double>;
using Outputs = std::vector<detect::ForeignOutput>;

namespace {
detect::DetectorDescription two_outputs() {
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::boxes_and_scores};
  kind.decoded = {"boxes", "scores"};
  return kind;
}

/// Two candidates of one class, whose probabilities are the first red and the first blue of the picture.
Outputs red_and_blue(const std::vector<float>& picture) {
  return {{{1, 2, 4}, {10, 12, 6, 4, 20, 22, 8, 2}}, {{1, 2, 1}, {picture.front(), picture[2 * 4 * 6]}}};
}
}  // namespace

TEST_CASE("a foreign engine sees planes of the encoded picture, and its boxes are decoded",
          "[detect][foreign]") {
  const Foreign detector(red_and_blue, two_outputs(), 4, 6);
  CHECK(detector.input_height() == 4);
  CHECK(detector.input_width() == 6);
  auto images = tapestry::zeros<double, 4>({2, 4, 6, 3});
  images(0, 0, 0, 0) = 0.75;
  images(0, 0, 0, 2) = 0.5;
  images(1, 0, 0, 2) = 0.875;
  detect::Pass<double> pass;
  detector.forward(images, pass);
  const auto first = detect::decode(detector.heads(), pass.logits, 0, 0.1, 4, 6);
  REQUIRE(first.size() == 2);
  CHECK(first[0].confidence == Approx(0.75));
  CHECK(first[0].box.cx == 10);
  CHECK(first[0].box.h == 4);
  CHECK(first[1].confidence == Approx(0.5));
  CHECK(first[1].box.cy == 22);
  const auto second = detect::decode(detector.heads(), pass.logits, 1, 0.1, 4, 6);
  REQUIRE(second.size() == 1);
  CHECK(second[0].confidence == Approx(0.875));
  CHECK(second[0].candidate == 1);
}

TEST_CASE("a foreign engine gets every pixel in its place, encoded", "[detect][foreign]") {
  auto kind = two_outputs();
  kind.encoding = {detect::ColourOrder::bgr, 1, {1, 2, 3}, {2, 4, 8}};
  kind.decoded.score_form = detect::ScoreForm::logits;  // the encoded colours lie below 0
  std::vector<float> seen;
  const Foreign detector(
      [&seen](const std::vector<float>& picture) {
        seen = picture;
        return red_and_blue(picture);
      },
      kind, 4, 6);
  tapestry::Array<double, 4> images(tapestry::Extents<4>{1, 4, 6, 3});
  for (std::size_t i = 0; i < images.size(); ++i) images.data()[i] = static_cast<double>(i) / 255;
  detect::Pass<double> pass;
  detector.forward(images, pass);
  REQUIRE(seen.size() == 72);
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t column = 0; column < 6; ++column) {
      const double red = static_cast<double>(3 * (6 * row + column));
      const std::size_t at = 6 * row + column;
      CHECK(seen[at] == Approx((red + 2 - 1) / 2));
      CHECK(seen[24 + at] == Approx((red + 1 - 2) / 4));
      CHECK(seen[48 + at] == Approx((red - 3) / 8));
    }
}

TEST_CASE("what a foreign detector does not have is refused", "[detect][foreign][error]") {
  const Foreign detector(red_and_blue, two_outputs(), 4, 6);
  detect::Pass<double> pass;
  auto images = tapestry::zeros<double, 4>({1, 4, 6, 3});
  CHECK_THROWS_WITH(detector.forward(images, pass, detect::Mode::input_gradient),
                    "Detector::forward: a foreign engine runs forward only");
  detector.forward(images, pass);
  CHECK_THROWS_AS(detector.input_adjoint(pass, {pass.logits[0]}, images), tapestry::DomainError);
  CHECK_THROWS_AS(detector.layer_values(pass, 0, 0), tapestry::DomainError);
  CHECK_THROWS_AS(detector.layer_adjoint(pass, {&pass.logits[0]}, 0, 0), tapestry::DomainError);
  CHECK_THROWS_AS(detector.forward(tapestry::zeros<double, 4>({1, 4, 5, 3}), pass), tapestry::ShapeError);
}

TEST_CASE("outputs of a foreign engine that are not as described are refused", "[detect][foreign][error]") {
  auto kind = two_outputs();
  CHECK_THROWS_WITH(Foreign(
                        [](const auto&) {
                          return Outputs{{{1, 2, 4}, std::vector<float>(8)}};
                        },
                        kind, 4, 6),
                    contains("outputs of one picture; expected 2, found 1"));
  CHECK_THROWS_WITH(Foreign(
                        [](const auto&) {
                          return Outputs{{{1, 2, 4}, std::vector<float>(7)}};
                        },
                        kind, 4, 6),
                    contains("values of an output; expected 8, found 7"));
  CHECK_THROWS_AS(Foreign(
                      [](const auto&) {
                        return Outputs{{{1, 2, 4}, std::vector<float>(8)}, {{1, 3, 1}, {1, 1, 1}}};
                      },
                      kind, 4, 6),
                  tapestry::FileError);  // boxes of two candidates, scores of three
  kind.decoded.channels_first = true;
  CHECK_THROWS_WITH(Foreign(
                        [](const auto&) {
                          return Outputs{{{1, 4, 2}, std::vector<float>(8)}, {{1, 1, 3}, {1, 1, 1}}};
                        },
                        kind, 4, 6),
                    contains("output 'scores'; expected [1, classes, 2], found [1, 1, 3]"));
  kind.decoded.channels_first = false;
  std::size_t calls = 0;
  const Foreign growing(
      [&calls](const auto&) {
        const std::size_t count = ++calls;
        return Outputs{{{1, count, 4}, std::vector<float>(4 * count)},
                       {{1, count, 1}, std::vector<float>(count)}};
      },
      kind, 4, 6);
  detect::Pass<double> pass;
  CHECK_THROWS_WITH(growing.forward(tapestry::zeros<double, 4>({1, 4, 6, 3}), pass),
                    contains("extents that change from picture to picture"));
  CHECK_THROWS_WITH(Foreign(
                        [](const auto&) {
                          return Outputs{{{2, 4}, std::vector<float>(8)}, {{2, 1}, {1, 1}}};
                        },
                        kind, 4, 6),
                    contains("output 'boxes'; expected [1, candidates, 4], found [2, 4]"));
  CHECK_THROWS_WITH(Foreign(detect::ForeignEngine{}, kind, 4, 6),
                    "Detector: the engine is an empty function");
  kind.head = detect::HeadKind::yolox;
  CHECK_THROWS_WITH(Foreign(red_and_blue, kind, 4, 6),
                    "Detector: heads of a foreign engine are yolox, expected boxes_and_scores or end_to_end");
}

TEST_CASE("values of a foreign engine that are not as described are refused at the first pass",
          "[detect][foreign][decoded][error]") {
  const Foreign detector(red_and_blue, two_outputs(), 4, 6);
  auto images = tapestry::zeros<double, 4>({1, 4, 6, 3});
  images(0, 0, 0, 2) = 1.5;
  detect::Pass<double> pass;
  for (int i = 0; i < 2; ++i)  // a refusal is no pass
    CHECK_THROWS_WITH(detector.forward(images, pass),
                      "outputs of a foreign engine: output 'scores' is not as described: the probability of "
                      "candidate 1 in channel 0; expected 0 to 1, found 1.500000");
}
