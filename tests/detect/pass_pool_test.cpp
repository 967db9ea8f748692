#include <tapestry/detect/pass.hpp>

#include <atomic>
#include <memory>
#include <set>
#include <tapestry/core/parallel.hpp>

#include "../support/catch.hpp"
#include "../support/threads.hpp"

using Pool = tapestry::detect::PassPool<float>;

TEST_CASE("a pool lends a pass to one at a time, and the same again", "[detect][pass_pool]") {
  Pool pool;
  const auto* const first = pool.take().get();
  auto held = pool.take();
  CHECK(held.get() == first);
  const auto second = pool.take();
  CHECK(second.get() != first);
  const auto copy = held;
  held.reset();
  CHECK(pool.take().get() != first);  // the copy holds it
}

TEST_CASE("a pass outlives its pool", "[detect][pass_pool]") {
  auto pool = std::make_unique<Pool>();
  const auto pass = pool->take();
  pool.reset();
  pass->images = 3;
  CHECK(pass->images == 3);
}

TEST_CASE("threads that take passes at once get different ones, and no more than they need",
          "[detect][pass_pool]") {
  const tapestry::test::Threads cap(4);
  Pool pool;
  std::atomic<int> shared{0};
  tapestry::parallel_for(2000, [&](std::size_t i) {
    const auto pass = pool.take();
    pass->images = i + 1;
    pass->logits.resize(i % 3);
    if (pass->images != i + 1 || pass->logits.size() != i % 3) ++shared;
  });
  CHECK(shared == 0);
  std::set<const void*> passes;
  std::vector<std::shared_ptr<tapestry::detect::Pass<float>>> held;
  while (passes.size() == held.size() && held.size() < 5) {
    held.push_back(pool.take());
    if (held.back()->images > 0) passes.insert(held.back().get());  // one that was used
  }
  CHECK(passes.size() <= 4);
  CHECK(passes.size() >= 1);
}
