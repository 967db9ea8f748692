#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

#if defined(__SIZEOF_INT128__)
TEST_CASE("an index is the upper half of its bits times the count", "[core][random]") {
  __extension__ using Wide = unsigned __int128;
  for (const std::size_t count :
       {std::size_t(1), std::size_t(10), std::size_t(0xFFFFFFFFU), std::size_t(0x100000001U),
        std::size_t(0x123456789ABCDEFU), ~std::size_t(0)}) {
    tapestry::Random drawn(count), bits(count);
    for (int i = 0; i < 1000; ++i)
      REQUIRE(drawn.index(count) == static_cast<std::uint64_t>(Wide(bits.bits()) * count >> 64U));
  }
}
#endif

TEST_CASE("streams of one generator differ", "[core][random]") {
  CHECK(tapestry::Random(1).fork(1).bits() != tapestry::Random(1).fork(2).bits());
}
