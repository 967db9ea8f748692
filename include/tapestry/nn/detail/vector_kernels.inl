// Kernels for one instruction set; implementation/vector_kernels.hpp includes this file once for each of
// them, inside a namespace of its own and with TAPESTRY_VECTOR_BYTES set. Generic vectors must be parsed
// under the target they are meant for, so nothing here may be a lambda or come from outside. The parts are a
// chain of files: each includes the one before it.
#include <tapestry/nn/detail/bfloat16_kernels.inl>

template <std::floating_point T, int V, int P>
void fill_rows(Kernels<T>& kernels) {
  kernels.reduce[V - 1][P - 1] = &reduce_tile<T, V, P>;
  if constexpr (P > 1) fill_rows<T, V, P - 1>(kernels);
}

template <std::floating_point T>
Kernels<T> make_kernels() {
  Kernels<T> kernels;
  kernels.lanes = Vector<T>::lanes;
  kernels.tile_rows = tile_rows;
  fill_rows<T, 1, tile_rows>(kernels);
  fill_rows<T, 2, tile_rows>(kernels);
  fill_winograd<T, WinogradForm::f2_taps3>(kernels);
  fill_winograd<T, WinogradForm::f4_taps3>(kernels);
  fill_winograd<T, WinogradForm::f4_taps2>(kernels);
  if constexpr (std::is_same_v<T, float>) fill_bfloat16(kernels);
  kernels.gather_row = &gather_row<T>;
  kernels.depthwise_row = &depthwise_row<T>;
  kernels.depthwise_weight_adjoint_row = &depthwise_weight_adjoint_row<T>;
  kernels.add = &add<T>;
  kernels.positive_bits = &positive_bits<T>;
  kernels.leaky_adjoint = &leaky_adjoint<T>;
  kernels.apply_curve = &apply_curve<T>;
  kernels.multiply = &multiply<T>;
  kernels.affine = &affine<T>;
  kernels.combine = &combine<T>;
  kernels.periodic_sums = &periodic_sums<T>;
  kernels.interleave = &interleave<T>;
  kernels.interleave_adjoint = &interleave_adjoint<T>;
  kernels.max_pool_pixel = &max_pool_pixel<T>;
  return kernels;
}
