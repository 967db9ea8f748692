#pragma once
#include <cstdlib>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <type_traits>
#include <vector>

namespace tapestry {
/// Instruction sets that kernels are compiled for: `portable` for any processor; for x86 `avx2`, and
/// `avx512`, which includes it; `neon` for 64-bit ARM. All but `portable` round a product and its sum once.
enum class InstructionSet { portable, avx2, avx512, neon };

/// The set of kernels that no target attribute compiles: portable; or, if TAPESTRY_ONE_INSTRUCTION_SET is
/// defined in all sources of a program, the best that the compiler's options allow, such as -march=native.
/// It is then the only one: this compiles sooner, and runs on such processors alone.
#if defined(TAPESTRY_ONE_INSTRUCTION_SET) && defined(__AVX512F__) && defined(__AVX512DQ__) && \
    defined(__AVX512VL__)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::avx512;
#define TAPESTRY_PLAIN_VECTOR_BYTES 64
#elif defined(TAPESTRY_ONE_INSTRUCTION_SET) && defined(__AVX2__) && defined(__FMA__)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::avx2;
#define TAPESTRY_PLAIN_VECTOR_BYTES 32
#elif defined(TAPESTRY_ONE_INSTRUCTION_SET) && defined(__aarch64__)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::neon;
#define TAPESTRY_PLAIN_VECTOR_BYTES 16
#else
inline constexpr InstructionSet plain_instruction_set = InstructionSet::portable;
#define TAPESTRY_PLAIN_VECTOR_BYTES 16
#endif

/// The best instruction set of this processor that kernels are compiled for.
[[nodiscard]] inline InstructionSet best_instruction_set() {
#if defined(TAPESTRY_ONE_INSTRUCTION_SET)
  return plain_instruction_set;
#elif defined(__x86_64__) && \
    (!defined(__MINGW32__) || defined(__clang__) || defined(TAPESTRY_UNALIGNED_MOVES))
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return InstructionSet::avx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
  return InstructionSet::portable;
#elif defined(__aarch64__)
  return InstructionSet::neon;  // which no such processor lacks
#else
  return InstructionSet::portable;
#endif
}

/// "portable", "avx2", "avx512" or "neon".
[[nodiscard]] constexpr std::string_view name_of(InstructionSet set) {
  constexpr std::string_view names[] = {"portable", "avx2", "avx512", "neon"};
  return names[static_cast<int>(set)];
}

/// The instruction sets of this processor that kernels are compiled for, the best one last.
[[nodiscard]] inline std::vector<InstructionSet> instruction_sets(
    InstructionSet best = best_instruction_set()) {
  std::vector<InstructionSet> sets;
#if !defined(TAPESTRY_ONE_INSTRUCTION_SET)
  if (best != InstructionSet::portable) sets.push_back(InstructionSet::portable);
  if (best == InstructionSet::avx512) sets.push_back(InstructionSet::avx2);
#endif
  sets.push_back(best);
  return sets;
}

/// The instruction set that has this name_of().
/// \param best  the best one of the processor
/// \throws DomainError if there is none of that name, or the processor does not have it
[[nodiscard]] inline InstructionSet instruction_set_named(std::string_view name,
                                                          InstructionSet best = best_instruction_set()) {
  const std::vector<InstructionSet> sets = instruction_sets(best);
  std::string expected;
  for (const auto set : sets) {
    if (name_of(set) == name) return set;
    if (set != sets.front()) expected += set == best ? " or " : ", ";
    expected += name_of(set);
  }
  throw DomainError({"TAPESTRY_INSTRUCTION_SET: found ", in_quotes(name), ", expected ", expected,
                     " by this program on this processor"});
}

/// The instruction set of all computation: the one that the environment variable TAPESTRY_INSTRUCTION_SET
/// names when this is first called, for tests and comparisons; the best one if it is not set or empty.
/// \throws DomainError as instruction_set_named()
[[nodiscard]] inline InstructionSet instruction_set() {
  static const InstructionSet chosen = [] {
    const char* const name = std::getenv("TAPESTRY_INSTRUCTION_SET");
    return name == nullptr || *name == '\0' ? best_instruction_set() : instruction_set_named(name);
  }();
  return chosen;
}

namespace detail {
/// Argument of the body of run_with().
template <std::size_t Bytes>
using VectorBytes = std::integral_constant<std::size_t, Bytes>;

#if defined(__x86_64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
template <class Body>
[[gnu::target("avx512f,avx512dq,avx512vl,avx2,fma")]] void run_avx512(const Body& body) {
  body(VectorBytes<64>{});
}
template <class Body>
[[gnu::target("avx2,fma")]] void run_avx2(const Body& body) {
  body(VectorBytes<32>{});
}
#elif defined(__aarch64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
template <class Body>
#if !defined(__clang__)  // which fuses where the body's own source file is compiled so
[[gnu::optimize("fp-contract=fast")]]
#endif
void run_neon(const Body& body) {
  body(VectorBytes<16>{});
}
#endif

/// Calls body(VectorBytes<size of a vector>), which must be inlined always, compiled for an instruction set
/// of this processor.
template <class Body>
void run_with(InstructionSet set, const Body& body) {
  switch (set) {
#if defined(__x86_64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
    case InstructionSet::avx512:
      return run_avx512(body);
    case InstructionSet::avx2:
      return run_avx2(body);
#elif defined(__aarch64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
    case InstructionSet::neon:
      return run_neon(body);
#endif
    default:
      return body(VectorBytes<TAPESTRY_PLAIN_VECTOR_BYTES>{});
  }
}
}  // namespace detail
}  // namespace tapestry
