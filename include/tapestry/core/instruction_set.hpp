#pragma once
#include <cstdlib>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>

namespace tapestry {

/// Instruction sets that kernels are compiled for; each includes the ones before it.
enum class InstructionSet { portable, avx2, avx512 };

/// The set of kernels that no target attribute compiles: portable; or, if TAPESTRY_ONE_INSTRUCTION_SET is
/// defined in all sources of a program, the best that the compiler's options allow, such as -march=native.
/// It is then the only one: this compiles sooner, and runs on such processors alone.
#if !defined(TAPESTRY_ONE_INSTRUCTION_SET)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::portable;
#elif defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::avx512;
#elif defined(__AVX2__) && defined(__FMA__)
inline constexpr InstructionSet plain_instruction_set = InstructionSet::avx2;
#else
inline constexpr InstructionSet plain_instruction_set = InstructionSet::portable;
#endif

/// The best instruction set of this processor that kernels are compiled for.
[[nodiscard]] inline InstructionSet best_instruction_set() {
#if defined(__x86_64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET) && \
    (!defined(__MINGW32__) || defined(__clang__) || defined(TAPESTRY_UNALIGNED_MOVES))
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return InstructionSet::avx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
#endif
  return plain_instruction_set;
}

/// "portable", "avx2" or "avx512".
[[nodiscard]] constexpr std::string_view name_of(InstructionSet set) {
  constexpr std::string_view names[] = {"portable", "avx2", "avx512"};
  return names[static_cast<int>(set)];
}

/// The instruction set that has this name_of().
/// \param best  the best one of the processor
/// \throws DomainError if there is none of that name, or the processor does not have it
[[nodiscard]] inline InstructionSet instruction_set_named(std::string_view name,
                                                          InstructionSet best = best_instruction_set()) {
  for (const auto set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
    if (name_of(set) != name) continue;
#if defined(TAPESTRY_ONE_INSTRUCTION_SET)
    if (set == best) return set;
    throw DomainError({"TAPESTRY_INSTRUCTION_SET: this program has no ", name, ", expected ", name_of(best)});
#endif
    if (set <= best) return set;
    throw DomainError(
        {"TAPESTRY_INSTRUCTION_SET: this processor has no ", name, ", expected at most ", name_of(best)});
  }
  throw DomainError(
      {"TAPESTRY_INSTRUCTION_SET: found ", in_quotes(name), ", expected portable, avx2 or avx512"});
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

}  // namespace tapestry
