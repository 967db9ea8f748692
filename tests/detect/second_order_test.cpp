#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/loss/adversarial.hpp>

#include "../support/catch.hpp"
#include "../support/hessian_product_error.hpp"
#include "../support/small_exports.hpp"

using namespace tapestry;
using test::hessian_product_error, test::number;

TEST_CASE("the adversarial loss of a detector has the Hessian by its pictures of differences",
          "[detect][second_order]") {
  auto description = detect::known_description("yolox");
  description.encoding.mean = {3, 7, 11};
  const detect::Detector<double> detector(test::yolox_like(64), description);
  const auto images = test::pictures<double>(2, 64);
  const std::vector<loss::Target> cars{{0, {30, 30, 26, 17}}, {1, {20, 40, 30, 22}}};
  const auto total = [&](const auto& pictures) {
    return number(pictures, loss::adversarial(detector, detect::forward(detector, pictures), std::span(cars),
                                              loss::AdversarialLoss::max_score)
                                .total);
  };
  CHECK(hessian_product_error(total, images) < 1e-7);
  const auto mixed = [&](const auto& pictures) {
    const auto logits = detect::forward(detector, pictures);
    return number(pictures, mean(sin(logits[0])) + mean(square(logits.back())));
  };
  CHECK(hessian_product_error(mixed, images) < 1e-7);
}
