#pragma once
#include <cstddef>
#include <exception>
#include <limits>
#if defined(_OPENMP)
#include <omp.h>
#endif

namespace tapestry {

/// Threads that parallel_for() will use: OpenMP's maximum, or 1 when built without OpenMP.
[[nodiscard]] inline int thread_count() {
#if defined(_OPENMP)
  return omp_in_parallel() != 0 ? 1 : omp_get_max_threads();
#else
  return 1;
#endif
}

/// Caps the threads of the calling thread's parallel_for() at `count`, at least 1.
inline void limit_threads([[maybe_unused]] int count) {
#if defined(_OPENMP)
  omp_set_num_threads(count < 1 ? 1 : count);
#endif
}

/// Calls body(i) for i = 0 … count − 1, in any order, on up to thread_count() threads.
///
/// Results are the same for any number of threads as long as body(i) writes only what belongs to i.
/// When bodies throw, the exception of the smallest i reaches the caller; the others are dropped.
template <class Body>
void parallel_for(std::size_t count, Body body) {
#if defined(_OPENMP)
  if (thread_count() > 1 && count > 1) {
    std::exception_ptr failure;
    std::size_t failed_at = std::numeric_limits<std::size_t>::max();
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t i = 0; i < count; ++i) {
      try {
        body(i);
      } catch (...) {
#pragma omp critical(tapestry_parallel_for)
        if (i < failed_at) {
          failed_at = i;
          failure = std::current_exception();
        }
      }
    }
    if (failure) std::rethrow_exception(failure);
    return;
  }
#endif
  for (std::size_t i = 0; i < count; ++i) body(i);
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

}  // namespace tapestry
