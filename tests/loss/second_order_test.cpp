#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/cross_entropy.hpp>
#include <tapestry/loss/smoothness.hpp>

#include "../support/catch.hpp"
#include "../support/hessian_product_error.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using loss::AdversarialLoss;
using test::hessian_product_error, test::number, test::random_array;

namespace {
struct OwnHeads : test::TinyHeads {
  std::vector<detect::Head> all;
  explicit OwnHeads(std::vector<detect::Head> own) : all(std::move(own)) {}
  [[nodiscard]] const std::vector<detect::Head>& heads() const { return all; }
};
}  // namespace

TEST_CASE("adversarial losses have the Hessians that differences of their gradients give",
          "[loss][second_order]") {
  using enum detect::DecodeFamily;
  const auto family = GENERATE(darknet, ultralytics, yolox, distance);
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::max_score, AdversarialLoss::vanish);
  const bool is_exclusive = family == darknet && GENERATE(false, true);
  OwnHeads detector(test::TinyHeads(family).heads());
  for (auto& head : detector.all) {
    head.exclusive_classes = is_exclusive;
    if (family == distance) head.bins = 8;
  }
  const auto logits_of = [&](std::size_t h) {
    const auto& head = detector.all[h];
    return random_array<double>({2, head.channel_count(), head.grid_height, head.grid_width}, h + 5, -1, 1);
  };
  const std::vector<loss::Target> cars{{0, {50, 30, 26, 17}}, {2, {20, 40, 30, 22}}};
  const auto total = [&](const auto& coarse, const auto& middle, const auto& fine) {
    return loss::adversarial(detector, std::vector{coarse, middle, fine}, std::span(cars), kind,
                             {0.7, 1.3, 0.9, 1.1})
        .total;
  };
  CHECK(hessian_product_error(total, logits_of(0), logits_of(1), logits_of(2)) < 1e-7);
}

TEST_CASE("a sure find, an overflowing extent, no meeting box and as_coded in second order",
          "[loss][second_order]") {
  const test::TinyHeads detector;
  const auto product = [&](double level, AdversarialLoss kind, const detect::Box& box) {
    const std::vector<loss::Target> car{{0, box}};
    const auto f = [&](const auto& coarse) {
      return loss::adversarial(OwnHeads{{detector.heads()[0]}}, std::vector{coarse}, std::span(car), kind)
          .total;
    };
    auto logits = detector.logits<double>(1, 3, -1, 1)[0];
    for (double& logit : logits.storage()) logit += level;
    auto along = logits;
    for (double& entry : along.storage()) entry = 1;
    return std::get<0>(hessian_product(f, logits, along).product);
  };
  for (const double level : {-100.0, 40.0, 100.0})
    for (const double entry : product(level, AdversarialLoss::max_score, {50, 30, 26, 17}))
      CHECK(std::isfinite(entry));
  for (const double entry : product(0, AdversarialLoss::vanish, {5000, 30, 26, 17})) CHECK(entry == 0);
  CHECK_THROWS_AS(product(0, AdversarialLoss::as_coded, {50, 30, 26, 17}), DomainError);
}

TEST_CASE("cross entropies and smoothness have the Hessians of differences", "[loss][second_order]") {
  const auto wanted = std::make_shared<const Array<double, 4>>(random_array<double>({2, 3, 1, 2}, 9));
  const auto logits = random_array<double>({2, 3, 1, 2}, 10, -1, 1);
  const auto binary = [&](const auto& x) { return exp(loss::binary_cross_entropy(x, wanted)); };
  auto shares = *wanted;
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t at = 0; at < 2; ++at) {
      const double sum = shares(n, 0, 0, at) + shares(n, 1, 0, at) + shares(n, 2, 0, at);
      for (std::size_t k = 0; k < 3; ++k) shares(n, k, 0, at) /= sum;
    }
  const auto of_sum_1 = std::make_shared<const Array<double, 4>>(shares);
  const auto exclusive = [&](const auto& x) { return exp(loss::cross_entropy(x, of_sum_1)); };
  CHECK(hessian_product_error([&](const auto& x) { return number(x, binary(x)); }, logits) < 1e-8);
  CHECK(hessian_product_error([&](const auto& x) { return number(x, exclusive(x)); }, logits) < 1e-8);
  const auto mask = std::make_shared<const Array<double, 2>>(random_array<double>({3, 4}, 8, 0.2, 1));
  const auto of_pictures = [&](const auto& x) {
    return number(x, sin(loss::smoothness(x, {loss::PlacedMask<double>{mask, 1, 1}})));
  };
  CHECK(hessian_product_error(of_pictures, random_array<double>({1, 4, 5, 3}, 5)) < 1e-7);
  const auto of_texels = [&](const auto& x) { return number(x, sin(loss::atlas_smoothness(x, mask))); };
  CHECK(hessian_product_error(of_texels, random_array<double>({12, 3}, 9)) < 1e-7);
}
