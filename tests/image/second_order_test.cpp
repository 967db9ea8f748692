#include <tapestry/image/batch.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/over.hpp>

#include "../support/catch.hpp"
#include "../support/hessian_product_error.hpp"

using namespace tapestry;
using test::hessian_product_error, test::number, test::random_array;

TEST_CASE("operations on pictures have the Hessians that differences of their gradients give",
          "[image][second_order]") {
  const auto picture = random_array<double>({4, 5, 3}, 5, 0.1, 0.9);
  const auto check = [&](const auto& f) { CHECK(hessian_product_error(f, picture) < 1e-7); };
  check([](const auto& x) { return number(x, sum(sin(image::linearised(x)))); });
  check([](const auto& x) { return number(x, sum(sin(image::encoded(x)))); });
  check([](const auto& x) { return number(x, sum(sin(image::resize_bilinear(x, 7, 3)))); });
  check([](const auto& x) { return number(x, sum(sin(image::letterboxed(x, 9, 9, 0.5)))); });
  check([](const auto& x) { return number(x, sum(sin(image::crop(x, {1, 1, 2, 3})))); });
  check([](const auto& x) { return number(x, sum(sin(image::batch_of(std::vector{x, x})))); });
  const auto coverage = random_array<double>({4, 5}, 6);
  const auto photo = random_array<double>({8, 9, 3}, 7, 0.1, 0.9);
  const image::Backdrop<double> backdrop(photo, coverage, 1, 2);
  for (const auto space : image::colour_spaces) {
    const auto blend = [&](const auto& p, const auto& c, const auto& b) {
      return number(p, sum(sin(image::over(p, c, b, 2, 3, space))));
    };
    CHECK(hessian_product_error(blend, picture, coverage, photo) < 1e-7);
    check([&](const auto& x) {
      return number(x, sum(sin(image::over(std::vector{x, x}, std::vector{backdrop, backdrop}, space))));
    });
  }
}
