#include <tapestry/core/pool.hpp>

#include "../support/threads.hpp"

using Pool = tapestry::Pool<std::vector<std::size_t>>;

TEST_CASE("a pool lends an object to one at a time, and the same again", "[core][pool]") {
  Pool pool;
  const auto* const first = pool.take().get();
  auto held = pool.take();
  CHECK(held.get() == first);
  const auto second = pool.take();
  CHECK(second.get() != first);
  const auto copy = held;
  held.reset();
  CHECK(pool.take().get() != first);  // the copy holds it
  CHECK(pool.size() == 3);
}

TEST_CASE("an object outlives its pool", "[core][pool]") {
  auto pool = std::make_unique<Pool>();
  const auto object = pool->take();
  pool.reset();
  object->resize(3);
  CHECK(object->size() == 3);
}

TEST_CASE("threads that take objects at once get different ones, and no more than they need",
          "[core][pool]") {
  const tapestry::test::Threads cap(4);
  const Pool pool_of_all;
  Pool pool = pool_of_all;  // a copy shares its objects
  std::atomic<int> shared{0};
  tapestry::parallel_for(2000, [&](std::size_t i) {
    const auto object = pool.take();
    object->assign(i % 3 + 1, i);
    if (object->size() != i % 3 + 1 || object->back() != i) ++shared;
  });
  CHECK(shared == 0);
  CHECK(pool_of_all.size() <= 4);
  CHECK(pool_of_all.size() >= 1);
}
