#include <tapestry/detect/box_decode_variable.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/small_exports.hpp"

using namespace tapestry;

TEST_CASE("the best score is the confidence of the surest candidate of all pictures",
          "[detect][best_score]") {
  for (const char* const name : {"yolox", "nanodet"}) {
    INFO(name);
    const detect::Detector<double> detector(
        std::string(name) == "yolox" ? test::yolox_like(64) : test::nanodet_like(64),
        detect::known_description(name));
    const auto images = test::pictures<double>(2, 64);
    const auto logits = detect::forward(detector, images);
    double expected = 0;
    for (std::size_t n = 0; n < 2; ++n)
      for (const auto& found : detect::decode(detector.heads(), logits, n, 0.0, 64, 64))
        expected = std::max(expected, found.confidence);
    REQUIRE(expected > 0);

    test::ActiveTape<double> tape;
    const auto input = tape.input(images);
    const auto score = detect::best_score(detector, detect::forward(detector, input));
    CHECK(score.value() == Approx(expected).epsilon(1e-12));
    tape.reverse(score);
    const auto direction = test::random_direction<double, 4>({2, 64, 64, 3}, 5);
    const double slope = test::dot(input.adjoint(), direction);
    CHECK(std::abs(slope) > 1e-8);
    const auto value = [&](const Array<double, 4>& at) {
      const ArrayVariable<double, 4> passive = at;
      return detect::best_score(detector, detect::forward(detector, passive)).value();
    };
    CHECK(slope == Approx(test::central_difference(value, images, direction)).epsilon(1e-6));
  }
}
