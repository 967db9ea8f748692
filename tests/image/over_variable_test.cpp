#include <tapestry/image/over.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
using Fronts = std::vector<ArrayVariable<double, 3>>;

std::vector<image::Backdrop<double>> two_backdrops() {
  const auto share = [](auto array) { return std::make_shared<const decltype(array)>(std::move(array)); };
  return {{share(random_array<double>({6, 7, 3}, 1)), share(random_array<double>({2, 3}, 2)), 1, 2},
          {share(random_array<double>({6, 7, 3}, 3)), share(random_array<double>({6, 7}, 4)), 0, 0}};
}
}  // namespace

TEST_CASE("over on the tape is over_adjoint() for each of its arrays", "[image][over][gradient]") {
  ActiveTape<double> tape;
  const auto front = tape.input(random_array<double>({4, 5, 3}, 1));
  const auto coverage = tape.input(random_array<double>({4, 5}, 2));
  const auto background = tape.input(random_array<double>({7, 8, 3}, 3));
  const auto seed = random_array<double>({7, 8, 3}, 4);
  const auto picture = image::over(front, coverage, background, 2, 1);
  CHECK((picture.value() == image::over(front.value(), coverage.value(), background.value(), 2, 1)));
  tape.reverse(picture, seed);
  Array<double, 3> by_front = xt::zeros_like(front.value()), by_background = xt::zeros_like(seed);
  Array<double, 2> by_coverage = xt::zeros_like(coverage.value());
  image::over_adjoint(front.value(), coverage.value(), background.value(), seed, &by_front, &by_coverage,
                      &by_background, 2, 1);
  CHECK((front.adjoint() == by_front));
  CHECK((coverage.adjoint() == by_coverage));
  CHECK((background.adjoint() == by_background));
}

TEST_CASE("a batch of pictures over backdrops equals one by one, both ways", "[image][over][gradient]") {
  const auto backdrops = two_backdrops();
  ActiveTape<double> tape;
  const Fronts fronts{tape.input(random_array<double>({2, 3, 3}, 5)),
                      tape.input(random_array<double>({6, 7, 3}, 6))};
  const auto batch = image::over(fronts, backdrops);
  const auto seed = random_array<double>({2, 6, 7, 3}, 7);
  tape.reverse(batch, seed);
  for (std::size_t n = 0; n < 2; ++n) {
    const auto& backdrop = backdrops[n];
    const auto alone =
        image::over(fronts[n].value(), *backdrop.coverage, *backdrop.background, backdrop.top, backdrop.left);
    Array<double, 3> part(alone.shape());
    CHECK(std::equal(alone.data(), alone.data() + alone.size(), batch.value().data() + n * alone.size()));
    std::copy_n(seed.data() + n * part.size(), part.size(), part.data());
    Array<double, 3> expected = xt::zeros_like(fronts[n].value());
    image::over_adjoint<double>(fronts[n].value(), *backdrop.coverage, *backdrop.background, part, &expected,
                                nullptr, nullptr, backdrop.top, backdrop.left);
    CHECK((fronts[n].adjoint() == expected));
  }
}

TEST_CASE("pixels of a batch that no picture covers have no adjoint", "[image][over][gradient]") {
  auto coverage = random_array<double>({2, 3}, 2);
  coverage(0, 1) = 0;
  ActiveTape<double> tape;
  const Fronts fronts{tape.input(random_array<double>({2, 3, 3}, 5))};
  const std::vector<image::Backdrop<double>> backdrops{{random_array<double>({6, 7, 3}, 6), coverage}};
  tape.reverse(image::over(fronts, backdrops, image::ColourSpace::linear),
               random_array<double>({1, 6, 7, 3}, 7));
  for (std::size_t i = 0; i < 18; ++i) CHECK((fronts[0].adjoint().data()[i] != 0) == (i / 3 != 1));
}

TEST_CASE("a batch of passive pictures records nothing, and a wrong number is refused", "[image][over]") {
  const auto backdrops = two_backdrops();
  Fronts fronts{random_array<double>({2, 3, 3}, 5), random_array<double>({6, 7, 3}, 6)};
  ActiveTape<double> tape;
  CHECK_FALSE(image::over(fronts, backdrops).is_active());
  CHECK(tape.record_count() == 0);
  std::swap(fronts[0], fronts[1]);
  CHECK_THROWS_WITH(image::over(fronts, backdrops), "over: premultiplied is [6, 7, 3], expected [2, 3, 3]");
  fronts.pop_back();
  CHECK_THROWS_WITH(image::over(fronts, backdrops), "over: 1 pictures over 2 backdrops");
}

TEST_CASE("one picture over two backdrops receives both adjoints", "[image][over][gradient]") {
  auto backdrops = two_backdrops();
  backdrops[0] = {backdrops[0].background, backdrops[1].coverage};
  ActiveTape<double> tape;
  const auto front = tape.input(random_array<double>({6, 7, 3}, 5));
  const auto seed = random_array<double>({2, 6, 7, 3}, 7);
  tape.reverse(image::over(Fronts{front, front}, backdrops), seed);
  for (std::size_t i = 0; i < front.size(); ++i)
    REQUIRE(front.adjoint().data()[i] == seed.data()[i] + seed.data()[front.size() + i]);
}

namespace {
struct ViewWithCoverage {
  Array<double, 2> coverage;
};
}  // namespace

TEST_CASE("a backdrop takes plain arrays, or a photograph and a view that it keeps", "[image][over]") {
  const auto photo = random_array<double>({6, 7, 3}, 1);
  const auto coverage = random_array<double>({2, 3}, 2);
  const image::Backdrop plain(photo, coverage, 1, 2);
  CHECK((*plain.background == photo));
  CHECK((*plain.coverage == coverage));
  CHECK((plain.top == 1 && plain.left == 2));
  auto view = std::make_shared<const ViewWithCoverage>(ViewWithCoverage{coverage});
  const auto* const place = &view->coverage;
  std::vector<image::Backdrop<double>> backdrops;
  backdrops.emplace_back(photo, view, 4, 3);
  view.reset();
  CHECK(backdrops[0].coverage.get() == place);  // not copied
  CHECK((*backdrops[0].coverage == coverage));
  CHECK((backdrops[0].top == 4 && backdrops[0].left == 3));
  ActiveTape<double> tape;
  const Fronts front{tape.input(random_array<double>({2, 3, 3}, 5))};
  CHECK((image::over(front, backdrops).value() ==
         image::over(front, {image::Backdrop<double>(photo, coverage, 4, 3)}).value()));
  CHECK_THROWS_AS(image::over(front, {image::Backdrop<double>(photo, coverage, 5, 3)}), ShapeError);
}
