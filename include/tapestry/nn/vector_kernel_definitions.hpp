#pragma once
#include <concepts>
#include <tapestry/nn/vector_kernels.hpp>

/// \file
/// The kernels of vector_kernels.hpp, compiled for each instruction set by target attributes, so that a build
/// with plain options has them all.

namespace tapestry::nn {

// At -O2 GCC leaves loops of the kernels rolled that -O3 does not, which costs small networks a tenth of
// their speed. Builds without optimisation and those under sanitizers stay as they are.
#if defined(__OPTIMIZE__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define TAPESTRY_OPTIMIZES_KERNELS
#pragma GCC push_options
#pragma GCC optimize("O3")
#endif

#define TAPESTRY_KERNELS <tapestry/nn/vector_kernels.inl>
#include <tapestry/core/for_each_instruction_set.inl>

#if defined(TAPESTRY_OPTIMIZES_KERNELS)
#pragma GCC pop_options
#undef TAPESTRY_OPTIMIZES_KERNELS
#endif

template <std::floating_point T>
Kernels<T> kernels_of([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512::make_kernels<T>();
  if (set == InstructionSet::avx2) return avx2::make_kernels<T>();
#endif
  return portable::make_kernels<T>();
}

}  // namespace tapestry::nn
