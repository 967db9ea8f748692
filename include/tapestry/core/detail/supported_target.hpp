#pragma once
/// \file
/// Refuses processors that were only tried with the scalar tape: the kernels, the random numbers and the
/// files need 64 bits and little-endian bytes.
#if !defined(__SIZEOF_INT128__) || __SIZEOF_POINTER__ < 8
#error "Tapestry needs a 64-bit processor; only the scalar tape, tapestry/autodiff.hpp, is for others"
#endif
#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Tapestry needs a little-endian processor; only the scalar tape, tapestry/autodiff.hpp, is for others"
#endif
