#include <tapestry/core/array.hpp>

#include <chrono>
#include <set>

#include "../support/threads.hpp"

using tapestry::test::Threads;

namespace {
/// True if a loop of this length visits every index once.
bool visits_each_once(std::size_t count) {
  std::vector<std::atomic<int>> visits(count);
  tapestry::parallel_for(count, [&](std::size_t i) { ++visits[i]; });
  for (const auto& visit : visits)
    if (visit != 1) return false;
  return true;
}
}  // namespace

TEST_CASE("parallel_for visits every index once, on any number of threads", "[core][parallel]") {
  for (const int threads : {1, 2, 3, 16}) {
    const Threads cap(threads);
    for (const std::size_t count : {0U, 1U, 2U, 3U, 17U, 1000U}) {
      INFO(threads << " threads, " << count << " indices");
      CHECK(visits_each_once(count));
    }
  }
}

TEST_CASE("parallel_for uses no more threads than it may, its caller among them", "[core][parallel]") {
  const Threads cap(3);
  std::mutex mutex;
  std::set<std::thread::id> seen;
  std::atomic<int> at_once{0}, most{0};
  tapestry::parallel_for(64, [&](std::size_t) {
    const int now = ++at_once;
    for (int before = most; before < now && !most.compare_exchange_weak(before, now);) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
    --at_once;
  });
  CHECK(most <= 3);
  CHECK(seen.size() >= 2);  // 64 ms are long enough for a helper to come
  CHECK(seen.contains(std::this_thread::get_id()));
}

TEST_CASE("a loop within a loop stays on its thread", "[core][parallel]") {
  const Threads cap(4);
  std::vector<int> sums(50, 0);
  std::atomic<int> strangers{0};
  tapestry::parallel_for(sums.size(), [&](std::size_t i) {
    const auto own = std::this_thread::get_id();
    if (tapestry::thread_count() != 1) ++strangers;
    tapestry::parallel_for(20, [&](std::size_t j) {
      if (std::this_thread::get_id() != own) ++strangers;
      sums[i] += static_cast<int>(j);
    });
  });
  CHECK(strangers == 0);
  CHECK(sums == std::vector<int>(50, 190));
  CHECK(tapestry::thread_count() == 4);
}

TEST_CASE("the exception of the smallest index reaches the caller, and loops go on to work",
          "[core][parallel]") {
  for (const int threads : {1, 2, 5}) {
    const Threads cap(threads);
    for (int round = 0; round < 20; ++round) {
      try {
        tapestry::parallel_for(100, [](std::size_t i) {
          if (i % 7 == 5) throw std::runtime_error(std::to_string(i));
        });
        FAIL_CHECK("nothing was thrown");
      } catch (const std::runtime_error& error) {
        CHECK(std::string(error.what()) == "5");
      }
    }
    CHECK(visits_each_once(100));
    CHECK(tapestry::thread_count() == threads);
  }
}

TEST_CASE("several threads run loops at once, each with its own cap", "[core][parallel]") {
  std::atomic<int> failures{0};
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 6; ++caller)
    callers.emplace_back([&, caller] {
      tapestry::limit_threads(1 + caller % 3);
      for (int round = 0; round < 300; ++round)
        if (!visits_each_once(static_cast<std::size_t>(1 + (round * 7 + caller) % 40))) ++failures;
      if (tapestry::thread_count() != 1 + caller % 3) ++failures;
    });
  for (auto& caller : callers) caller.join();
  CHECK(failures == 0);
}

TEST_CASE("thousands of short loops one after another lose no index", "[core][parallel]") {
  const Threads cap(2);
  std::vector<std::size_t> totals(8, 0);
  for (std::size_t round = 0; round < 20000; ++round)
    tapestry::parallel_for(totals.size(), [&](std::size_t i) { totals[i] += round; });
  CHECK(totals == std::vector<std::size_t>(8, 199990000));
}

TEST_CASE("results are used in order, whatever the number of threads that make them", "[core][parallel]") {
  for (const int threads : {1, 2, 5, 100}) {
    const Threads cap(threads);
    for (const std::size_t count : {0U, 1U, 7U, 41U, 500U}) {
      std::vector<std::size_t> used;
      std::atomic<std::size_t> made{0};
      std::size_t most_ahead = 0;
      tapestry::for_each_in_order(
          count,
          [&](std::size_t i) {
            ++made;
            return std::make_unique<std::size_t>(i * i);
          },
          [&](std::size_t i, std::unique_ptr<std::size_t> square) {
            CHECK(*square == i * i);
            most_ahead = std::max(most_ahead, made - i);
            used.push_back(i);
          });
      INFO(threads << " threads, " << count << " items");
      REQUIRE(used.size() == count);
      CHECK(std::is_sorted(used.begin(), used.end()));
      CHECK(most_ahead <= tapestry::items_at_a_time());
    }
    CHECK(tapestry::items_at_a_time() >= static_cast<std::size_t>(threads));
  }
  const Threads cap(1);
  CHECK(tapestry::items_at_a_time() == 1);
}

TEST_CASE("what was made before the first failure is used, on any number of threads", "[core][parallel]") {
  const Threads cap(GENERATE(1, 2, 8));
  std::vector<std::size_t> used;
  const auto use = [&](std::size_t i, bool is_even) {
    CHECK(is_even == (i % 2 == 0));
    used.push_back(i);
  };
  const auto make = [](std::size_t i) {
    if (i >= 13 && i % 3 == 1) throw std::runtime_error(std::to_string(i));
    return i % 2 == 0;
  };
  CHECK_THROWS_WITH(tapestry::for_each_in_order(100, make, use), "13");
  CHECK(used.size() == 13);
  CHECK(std::is_sorted(used.begin(), used.end()));
  const auto refuse = [](std::size_t i, bool) {
    if (i == 5) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(tapestry::for_each_in_order(14, make, refuse), "enough");  // before the 13th is made
}

TEST_CASE("fewer threads than one are one", "[core][parallel]") {
  const Threads cap(0);
  CHECK(tapestry::thread_count() == 1);
  tapestry::limit_threads(-3);
  CHECK(tapestry::thread_count() == 1);
}

TEST_CASE("threads share a pool without sharing a block", "[core][platform]") {
  const std::size_t before = tapestry::platform::PagePool::shared().use().in_use;
  std::vector<int> wrong(16, 0);
  tapestry::parallel_for(wrong.size(), [&](std::size_t i) {
    for (int round = 0; round < 20; ++round) {
      tapestry::Array<int, 1> array(
          tapestry::Extents<1>{tapestry::platform::PagePool::smallest / sizeof(int) + 64 * i});
      const int value = static_cast<int>(i) * 100 + round;
      std::fill(array.begin(), array.end(), value);
      for (const int element : array) wrong[i] += element != value ? 1 : 0;
    }
  });
  CHECK(std::all_of(wrong.begin(), wrong.end(), [](int count) { return count == 0; }));
  CHECK(tapestry::platform::PagePool::shared().use().in_use == before);
}
