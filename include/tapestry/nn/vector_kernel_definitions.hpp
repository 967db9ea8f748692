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

namespace portable {
#define TAPESTRY_VECTOR_BYTES 16
#define TAPESTRY_TILE_ROWS 6
#include <tapestry/nn/vector_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
#undef TAPESTRY_TILE_ROWS
}  // namespace portable

#if defined(__x86_64__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
namespace avx2 {
#define TAPESTRY_VECTOR_BYTES 32
#define TAPESTRY_TILE_ROWS 6
#include <tapestry/nn/vector_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
#undef TAPESTRY_TILE_ROWS
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))), \
                             apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma")
#endif
namespace avx512 {
#define TAPESTRY_VECTOR_BYTES 64
#define TAPESTRY_TILE_ROWS 12
#include <tapestry/nn/vector_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
#undef TAPESTRY_TILE_ROWS
}  // namespace avx512
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
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512::make_kernels<T>();
  if (set == InstructionSet::avx2) return avx2::make_kernels<T>();
#endif
  return portable::make_kernels<T>();
}

}  // namespace tapestry::nn
