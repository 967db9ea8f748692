#pragma once

namespace tapestry {

/// What kernels are compiled for; each includes the ones before it.
enum class InstructionSet { portable, avx2, avx512 };

/// The best instruction set of this processor that kernels are compiled for.
[[nodiscard]] inline InstructionSet best_instruction_set() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return InstructionSet::avx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
#endif
  return InstructionSet::portable;
}

}  // namespace tapestry
