// Compiles the file TAPESTRY_KERNELS for each instruction set by target attributes, so that a plain build has
// them all: in the namespaces portable, avx2 and avx512, or portable and neon, with TAPESTRY_VECTOR_BYTES
// defined. With TAPESTRY_WIDE_LOOPS, GCC vectorises the file's plain loops with the whole width of AVX-512,
// too; the file's products are rounded before they are added, so that neon would be portable once more. With
// TAPESTRY_ONE_INSTRUCTION_SET, the namespace portable is compiled for the set of the compiler's options,
// alone.
#ifndef TAPESTRY_KERNELS  // an editor reads this file alone
#include <tapestry/core/instruction_set.hpp>
#define TAPESTRY_KERNELS <tapestry/core/vector_memory.inl>
#endif

#if defined(__aarch64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
#define TAPESTRY_NEON_SET
#if defined(__clang__)
#pragma clang fp contract(off)
#else
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif
#endif

namespace portable {
#define TAPESTRY_VECTOR_BYTES TAPESTRY_PLAIN_VECTOR_BYTES
#include TAPESTRY_KERNELS
#undef TAPESTRY_VECTOR_BYTES
}  // namespace portable

#if defined(TAPESTRY_NEON_SET)
#if !defined(TAPESTRY_WIDE_LOOPS)
#if defined(__clang__)
#pragma clang fp contract(on)
#else
#pragma GCC optimize("fp-contract=fast")
#endif
namespace neon {
#define TAPESTRY_VECTOR_BYTES 16
#include TAPESTRY_KERNELS
#undef TAPESTRY_VECTOR_BYTES
}  // namespace neon
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#else
#pragma GCC pop_options
#endif
#undef TAPESTRY_NEON_SET
#endif

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
