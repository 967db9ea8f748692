// Compiles the file TAPESTRY_KERNELS for each instruction set by target attributes, so that a plain build has
// them all: in the namespaces portable, avx2 and avx512, with TAPESTRY_VECTOR_BYTES defined. With
// TAPESTRY_WIDE_LOOPS, GCC vectorises the file's plain loops with the whole width of AVX-512, too. With
// TAPESTRY_ONE_INSTRUCTION_SET, the namespace portable is compiled for the set of the compiler's options,
// alone.
#ifndef TAPESTRY_KERNELS  // an editor reads this file alone
#include <cstddef>
#define TAPESTRY_KERNELS <tapestry/core/vector_memory.inl>
#endif

namespace portable {
#if !defined(TAPESTRY_ONE_INSTRUCTION_SET)
#define TAPESTRY_VECTOR_BYTES 16
#elif defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
#define TAPESTRY_VECTOR_BYTES 64
#elif defined(__AVX2__) && defined(__FMA__)
#define TAPESTRY_VECTOR_BYTES 32
#else
#define TAPESTRY_VECTOR_BYTES 16
#endif
#include TAPESTRY_KERNELS
#undef TAPESTRY_VECTOR_BYTES
}  // namespace portable

#if defined(__x86_64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
namespace avx2 {
#define TAPESTRY_VECTOR_BYTES 32
#include TAPESTRY_KERNELS
#undef TAPESTRY_VECTOR_BYTES
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))), \
                             apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma")
#if defined(TAPESTRY_WIDE_LOOPS)
#pragma GCC target("prefer-vector-width=512")
#endif
#endif
namespace avx512 {
#define TAPESTRY_VECTOR_BYTES 64
#include TAPESTRY_KERNELS
#undef TAPESTRY_VECTOR_BYTES
}  // namespace avx512
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#undef TAPESTRY_KERNELS
