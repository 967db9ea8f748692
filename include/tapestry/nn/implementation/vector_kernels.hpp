#pragma once
#include <tapestry/nn/detail/vector_kernels.hpp>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

/// \file
/// The kernels of vector_kernels.hpp, compiled for each instruction set by target attributes, so that a build
/// with plain options has them all. For double, a reference, the portable ones serve every set.

namespace tapestry::nn {
#if defined(__x86_64__) && \
    (!defined(TAPESTRY_ONE_INSTRUCTION_SET) || (defined(__AVX512BF16__) && defined(__AVX512BW__)))
#define TAPESTRY_BFLOAT16_SET
#endif

// At -O2 GCC does not unroll loops of the kernels that -O3 does, which makes small networks a tenth slower.
// Builds without optimisation and under sanitizers keep their options.
#if defined(__OPTIMIZE__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define TAPESTRY_OPTIMIZES_KERNELS
#pragma GCC push_options
#pragma GCC optimize("O3")
#endif

#define TAPESTRY_KERNELS <tapestry/nn/detail/vector_kernels.inl>
#include <tapestry/core/for_each_instruction_set.inl>

#if defined(TAPESTRY_BFLOAT16_SET)  // the last set: only its bfloat16 kernels are used
#if defined(__clang__)
#pragma clang attribute push( \
    __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,avx512bf16,avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw,avx512bf16,avx2,fma")
#endif
namespace avx512_bf16 {
#define TAPESTRY_BFLOAT16
#define TAPESTRY_VECTOR_BYTES 64
#include <tapestry/nn/detail/vector_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
#undef TAPESTRY_BFLOAT16
}  // namespace avx512_bf16
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#if defined(TAPESTRY_OPTIMIZES_KERNELS)
#pragma GCC pop_options
#undef TAPESTRY_OPTIMIZES_KERNELS
#endif

template <std::floating_point T>
Kernels<T> kernels_of([[maybe_unused]] InstructionSet set) {
  Kernels<T> kernels = [&] {
#if !defined(TAPESTRY_ONE_INSTRUCTION_SET)
    if constexpr (std::is_same_v<T, float>) {
#if defined(__x86_64__)
      if (set == InstructionSet::avx512) return avx512::make_kernels<T>();
      if (set == InstructionSet::avx2) return avx2::make_kernels<T>();
#elif defined(__aarch64__)
      if (set == InstructionSet::neon) return neon::make_kernels<T>();
#endif
    }
#endif
    return portable::make_kernels<T>();
  }();
#if defined(TAPESTRY_BFLOAT16_SET)
  if constexpr (std::is_same_v<T, float>)
    if (set == InstructionSet::avx512 && has_bfloat16()) avx512_bf16::fill_bfloat16(kernels);
#endif
  return kernels;
}

#undef TAPESTRY_BFLOAT16_SET
}  // namespace tapestry::nn
