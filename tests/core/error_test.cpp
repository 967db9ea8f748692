#include <tapestry/core/error.hpp>

#include <array>
#include <limits>
#include <type_traits>
#include <vector>

#include "../support/catch.hpp"

using tapestry::MessagePart;

TEST_CASE("a message is written from texts, numbers and extents in their order", "[core][error]") {
  const std::string operation = "solve";
  const std::vector<std::size_t> extents{2, 30};
  const std::array<std::size_t, 0> none{};
  const tapestry::ShapeError error(
      {operation, ": b is ", extents, " of ", none, ", expected ", 3U, " or ", -7});
  CHECK(error.what() == std::string("solve: b is [2, 30] of [], expected 3 or -7"));
  CHECK(error.kind() == tapestry::ErrorKind::mismatch);
  CHECK(tapestry::DomainError({std::numeric_limits<std::uint64_t>::max(), " > ",
                               std::numeric_limits<std::int64_t>::min(), ", ", 0.25F, ", ", true})
            .what() == std::string("18446744073709551615 > -9223372036854775808, 0.250000, 1"));
  CHECK(tapestry::NumericError("as it is").what() == std::string("as it is"));
  CHECK(tapestry::Error(tapestry::ErrorKind::limit, {"at most ", 5, " cars"}).what() ==
        std::string("at most 5 cars"));
  STATIC_REQUIRE_FALSE(std::is_constructible_v<MessagePart, char>);
}
