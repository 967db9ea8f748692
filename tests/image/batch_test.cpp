#include <tapestry/image/batch.hpp>
#include <vector>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace image = tapestry::image;
using tapestry::Array;

TEST_CASE("a batch holds its pictures one behind the other", "[image][batch]") {
  std::vector<Array<float, 3>> pictures;
  for (std::uint64_t n = 0; n < 3; ++n)
    pictures.push_back(tapestry::test::random_array<float>({4, 5, 3}, n + 1));
  const auto batch = image::batch_of(std::span<const Array<float, 3>>(pictures));
  CHECK(batch.shape() == tapestry::Extents<4>{3, 4, 5, 3});
  for (std::size_t n = 0; n < 3; ++n) CHECK((image::picture_of(batch, n) == pictures[n]));
  CHECK((image::picture_of(image::batch_of(pictures[1]), 0) == pictures[1]));
}

TEST_CASE("a batch of nothing, of several sizes and a picture beyond it are refused", "[image][batch]") {
  const std::vector<Array<float, 3>> none;
  const std::vector<Array<float, 3>> mixed{tapestry::zeros<float, 3>({4, 5, 3}),
                                           tapestry::zeros<float, 3>({4, 4, 3})};
  CHECK_THROWS_AS(image::batch_of(std::span<const Array<float, 3>>(none)), tapestry::ShapeError);
  CHECK_THROWS_WITH(image::batch_of(std::span<const Array<float, 3>>(mixed)),
                    "batch_of: picture is [4, 4, 3], expected [4, 5, 3]");
  CHECK_THROWS_AS(image::picture_of(image::batch_of(mixed[0]), 1), tapestry::DomainError);
}
