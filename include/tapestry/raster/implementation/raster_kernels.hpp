#pragma once
#include <tapestry/raster/detail/raster_kernels.hpp>

/// \file
/// The kernels of raster_kernels.hpp, compiled for each instruction set by target attributes, so that a build
/// with plain options has them all.

namespace tapestry::raster {
#if defined(__clang__)
#pragma clang fp contract(off)
#else
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

#define TAPESTRY_WIDE_LOOPS
#define TAPESTRY_KERNELS <tapestry/raster/detail/raster_kernels.inl>
#include <tapestry/core/for_each_instruction_set.inl>
#undef TAPESTRY_WIDE_LOOPS

#if defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#else
#pragma GCC pop_options
#endif

RasterKernels raster_kernels_of([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
  if (set == InstructionSet::avx512) return avx512::make_kernels();
  if (set == InstructionSet::avx2) return avx2::make_kernels();
#endif
  return portable::make_kernels();
}
}  // namespace tapestry::raster
