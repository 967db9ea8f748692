#pragma once
#include <tapestry/raster/raster_kernels.hpp>

/// \file
/// The kernels of raster_kernels.hpp, compiled for each instruction set by target attributes, so that a build
/// with plain options has them all.

namespace tapestry::raster {

#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

namespace portable {
#define TAPESTRY_VECTOR_BYTES 16
#include <tapestry/raster/raster_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
}  // namespace portable

#if defined(__x86_64__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace avx2 {
#define TAPESTRY_VECTOR_BYTES 32
#include <tapestry/raster/raster_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl,avx2"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,prefer-vector-width=512")
#endif
namespace avx512 {
#define TAPESTRY_VECTOR_BYTES 64
#include <tapestry/raster/raster_kernels.inl>
#undef TAPESTRY_VECTOR_BYTES
}  // namespace avx512
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
#if !defined(__clang__)
#pragma GCC pop_options
#endif

RasterKernels raster_kernels_of([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512::make_kernels();
  if (set == InstructionSet::avx2) return avx2::make_kernels();
#endif
  return portable::make_kernels();
}

}  // namespace tapestry::raster
