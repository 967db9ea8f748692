#pragma once
#include <tapestry/core/instruction_set.hpp>

namespace tapestry::detail {
// clang warns of loops that it did not vectorise. That is no mistake: bodies that call functions of <cmath>
// never do. It warns at the function that the loop was inlined into, so functions that hold loops of any
// bodies stand here and are never inlined.
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

/// Elements of a row that are computed at once: small enough for all of an expression's blocks to stay in the
/// first-level cache.
inline constexpr std::size_t array_block = 256;

/// Calls body(i) for Count i from `first` on, where the bodies may run in any order and side by side.
template <std::size_t Count, class Body>
[[gnu::always_inline]] inline void plain_group(std::size_t first, const Body& body) {
#if defined(__clang__)
#pragma clang loop vectorize(assume_safety)
#elif defined(__GNUC__)
#pragma GCC ivdep
#endif
  for (std::size_t i = 0; i < Count; ++i) body(first + i);
}

/// Calls body(i) for i < count, in the same way. Most calls run in loops of constant length,
/// which compilers vectorise even at low optimisation; with groups of 16 alone long bodies take a
/// third of the time to compile.
template <std::size_t Largest = 64, class Body>
[[gnu::always_inline]] inline void plain_block(std::size_t count, const Body& body) {
  std::size_t first = 0;
  if constexpr (Largest == 64)
    for (; first + 64 <= count; first += 64) plain_group<64>(first, body);
  for (; first + 16 <= count; first += 16) plain_group<16>(first, body);
  for (; first < count; ++first) body(first);
}

/// plain_block() as a separate function.
template <std::size_t Largest = 64, class Body>
[[gnu::noinline]] void portable_block(std::size_t count, const Body& body) {
  const Body own = body;
  plain_block<Largest>(count, own);
}

// Sanitizers make these loops large and slow to compile, and also check all memory in the plain loop.
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
#if defined(__x86_64__)
template <std::size_t Largest, class Body>
#if !defined(__clang__)  // at every level of the file; clang has no such attribute
[[gnu::optimize("O3")]]
#endif
[[gnu::target("avx512f,avx512dq,avx512vl,avx2,fma"), gnu::noinline]] void
avx512_block(std::size_t count, const Body& body) {
  const Body own = body;
  plain_block<Largest>(count, own);
}
template <std::size_t Largest, class Body>
#if !defined(__clang__)  // at every level of the file; clang has no such attribute
[[gnu::optimize("O3")]]
#endif
[[gnu::target("avx2,fma"), gnu::noinline]] void
avx2_block(std::size_t count, const Body& body) {
  const Body own = body;
  plain_block<Largest>(count, own);
}
#elif defined(__aarch64__) && !defined(__clang__)
template <std::size_t Largest, class Body>
[[gnu::optimize("fp-contract=fast"), gnu::noinline]] void neon_block(std::size_t count, const Body& body) {
  const Body own = body;
  plain_block<Largest>(count, own);
}
#endif
#endif

/// plain_block() in the best instructions that this processor has, whatever the program was compiled for. A
/// product and its sum may be rounded once (fused), so the last bits differ among processors.
template <std::size_t Largest = 64, class Body>
inline void for_block(std::size_t count, const Body& body) {
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
  switch (instruction_set()) {
#if defined(__x86_64__)
    case InstructionSet::avx512:
      return avx512_block<Largest>(count, body);
    case InstructionSet::avx2:
      return avx2_block<Largest>(count, body);
#elif defined(__aarch64__) && !defined(__clang__)
    case InstructionSet::neon:
      return neon_block<Largest>(count, body);
#endif
    default:
      break;
  }
#endif
  portable_block<Largest>(count, body);
}

#if defined(__clang__)
#pragma clang diagnostic pop
#endif
}  // namespace tapestry::detail
