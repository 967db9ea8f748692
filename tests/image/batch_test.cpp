#include <tapestry/image/batch.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;

TEST_CASE("a batch holds its pictures one behind the other", "[image][batch]") {
  std::vector<Array<float, 3>> pictures;
  for (std::uint64_t n = 0; n < 3; ++n) pictures.push_back(test::random_array<float>({4, 5, 3}, n + 1));
  const auto batch =
      image::batch_of(std::vector<const Array<float, 3>*>{&pictures[0], &pictures[1], &pictures[2]});
  CHECK(batch.shape() == Extents<4>{3, 4, 5, 3});
  for (std::size_t n = 0; n < 3; ++n) CHECK((image::picture_of(batch, n) == pictures[n]));
  CHECK((image::picture_of(image::batch_of(pictures[1]), 0) == pictures[1]));
}

TEST_CASE("a batch on the tape hands each picture its part of the adjoint", "[image][batch][gradient]") {
  test::ActiveTape<double> tape;
  std::vector<ArrayVariable<double, 3>> pictures;
  for (std::uint64_t n = 0; n < 2; ++n)
    pictures.push_back(tape.input(test::random_array<double>({4, 5, 3}, n + 1)));
  pictures.insert(pictures.begin() + 1, test::random_array<double>({4, 5, 3}, 3));  // passive
  const auto batch = image::batch_of(pictures);
  const auto seed = test::random_array<double>({3, 4, 5, 3}, 4);
  tape.reverse(batch, seed);
  for (const std::size_t n : {0U, 2U}) {
    CHECK((image::picture_of(batch.value(), n) == pictures[n].value()));
    CHECK((pictures[n].adjoint() == image::picture_of(seed, n)));
  }
}

TEST_CASE("a batch of nothing, of several sizes and a picture beyond it are refused", "[image][batch]") {
  const auto one = tapestry::zeros<float, 3>({4, 5, 3}), other = tapestry::zeros<float, 3>({4, 4, 3});
  CHECK_THROWS_AS(image::batch_of(std::vector<const Array<float, 3>*>{}), ShapeError);
  CHECK_THROWS_WITH(image::batch_of(std::vector<const Array<float, 3>*>{&one, &other}),
                    "batch_of: picture is [4, 4, 3], expected [4, 5, 3]");
  CHECK_THROWS_AS(image::picture_of(image::batch_of(one), 1), DomainError);
}
