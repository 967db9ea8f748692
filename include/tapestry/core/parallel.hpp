#pragma once
#include <optional>
#include <tapestry/core/block_loop.hpp>
#include <tapestry/core/detail/thread_pool.hpp>

namespace tapestry {
namespace detail {
/// Reads TAPESTRY_THREADS, then OMP_NUM_THREADS; else counts the processors that this process may run on.
[[nodiscard]] inline int default_thread_count() {
  for (const char* name : {"TAPESTRY_THREADS", "OMP_NUM_THREADS"})
    if (const char* const text = std::getenv(name); text != nullptr)
      if (const long count = std::strtol(text, nullptr, 10); count >= 1)
        return static_cast<int>(std::min(count, 1024L));
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// The thread limit of the calling thread.
[[nodiscard, gnu::visibility("default")]] inline int& thread_limit() {
  static const int otherwise = default_thread_count();
  static thread_local int limit = otherwise;
  return limit;
}
}  // namespace detail

/// Number of threads that parallel_for() will use, the caller included: the last limit_threads() on this
/// thread, else TAPESTRY_THREADS or OMP_NUM_THREADS in the environment, else the number of processors. 1
/// within a loop.
[[nodiscard]] inline int thread_count() {
  return detail::ThreadPool::is_inside() ? 1 : detail::thread_limit();
}

/// Caps the threads of the calling thread's parallel_for() at `count`, at least 1.
inline void limit_threads(int count) { detail::thread_limit() = std::max(1, count); }

/// Calls body(i) for i = 0 … count − 1, in any order, on up to thread_count() threads. Loops within loops run
/// on the thread that they are on; several threads may run loops at once.
///
/// Results are the same for any number of threads as long as body(i) writes only its own results. When bodies
/// throw, the exception of the smallest i reaches the caller; the others are dropped.
template <class Body>
void parallel_for(std::size_t count, Body body) {
  const int threads = thread_count();
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  const auto call = [](void* context, std::size_t index) { (*static_cast<Body*>(context))(index); };
  detail::ThreadPool::instance().run({call, &body, count},
                                     std::min<std::size_t>(static_cast<std::size_t>(threads), count) - 1);
}

/// The half-open range of items of block `index` when `count` items are cut into blocks of `size`.
struct BlockRange {
  std::size_t begin;
  std::size_t end;
};

[[nodiscard]] constexpr std::size_t block_count(std::size_t count, std::size_t size) {
  return (count + size - 1) / size;
}

[[nodiscard]] constexpr BlockRange block_range(std::size_t index, std::size_t count, std::size_t size) {
  const std::size_t begin = index * size;
  return {begin, begin + size < count ? begin + size : count};
}

/// Cuts `count` items into blocks of `size`, the last perhaps shorter, and calls body(begin, end) for each
/// block as parallel_for() does.
template <class Body>
void parallel_for_blocks(std::size_t count, std::size_t size, Body body) {
  parallel_for(block_count(count, size), [&](std::size_t index) {
    const BlockRange range = block_range(index, count, size);
    body(range.begin, range.end);
  });
}

/// Calls body(i) for i < count in vectors, as for_block() does, and on all threads where `count` is large.
/// \param body  inlined always, with few captures and those by value
template <class Body>
void parallel_for_vectors(std::size_t count, const Body& body) {
  constexpr std::size_t block = std::size_t(1) << 14U;
  parallel_for_blocks(count, block, [&](std::size_t begin, std::size_t end) {
    const auto from_begin = [ begin, body ](std::size_t i) __attribute__((always_inline)) {
      body(begin + i);
    };
    detail::for_block<16>(end - begin, from_begin);
  });
}

/// Number of items to compute before any is used: enough that no thread waits long for another one, and few
/// enough to hold. 1 on one thread.
[[nodiscard]] inline std::size_t items_at_a_time() {
  const auto threads = static_cast<std::size_t>(thread_count());
  return threads == 1 ? 1 : std::max(threads, std::min<std::size_t>(4 * threads, 64));
}

/// Calls make(i) for i = 0 … count − 1 on up to thread_count() threads, and use(i, result) with each result,
/// in order, on the calling thread; items_at_a_time() items at a time. When make() throws, the results of
/// smaller i are used, then the exception of the smallest i reaches the caller, as on one thread.
template <class Make, class Use>
void for_each_in_order(std::size_t count, Make make, Use use) {
  using Result = std::invoke_result_t<Make&, std::size_t>;
  const std::size_t size = items_at_a_time();
  for (std::size_t block = 0; block < block_count(count, size); ++block) {
    const BlockRange items = block_range(block, count, size);
    std::vector<std::optional<Result>> results(items.end - items.begin);
    std::atomic<std::size_t> failed_at = results.size();
    std::exception_ptr failure;
    const auto make_result = [&](std::size_t i) {
      if (i > failed_at) return;  // its result would not be used
      try {
        results[i].emplace(make(items.begin + i));
      } catch (...) {
        std::size_t least = failed_at;
        while (i < least && !failed_at.compare_exchange_weak(least, i)) {
        }
        throw;
      }
    };
    try {
      parallel_for(results.size(), make_result);
    } catch (...) {
      failure = std::current_exception();
    }
    for (std::size_t i = 0; i < failed_at; ++i) use(items.begin + i, std::move(*results[i]));
    if (failure) std::rethrow_exception(failure);
  }
}
}  // namespace tapestry
