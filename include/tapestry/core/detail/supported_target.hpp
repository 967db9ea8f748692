#pragma once
/// \file
/// Refuses processors that were only tried with the scalar tape: the kernels, the random numbers and the
/// files need little-endian bytes and, for 64-bit pointers or 32-bit ones as WebAssembly's, a compiler with
/// integers of 128 bits.
#if !defined(__SIZEOF_INT128__)
#error "Tapestry needs integers of 128 bits; only the scalar tape, tapestry/autodiff.hpp, does without"
#endif
#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Tapestry needs a little-endian processor; only the scalar tape, tapestry/autodiff.hpp, is for others"
#endif
