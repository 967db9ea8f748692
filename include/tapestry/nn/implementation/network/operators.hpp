#pragma once
/// \file
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/batch_normalization.hpp>
#include <tapestry/nn/detail/network/operators/channel_shuffle.hpp>
#include <tapestry/nn/detail/network/operators/convolution_transpose.hpp>
#include <tapestry/nn/detail/network/operators/gemm.hpp>
#include <tapestry/nn/detail/network/operators/grid_sample.hpp>
#include <tapestry/nn/detail/network/operators/group_normalization.hpp>
#include <tapestry/nn/detail/network/operators/layer_normalization.hpp>
#include <tapestry/nn/detail/network/operators/non_max_suppression.hpp>
#include <tapestry/nn/detail/network/operators/non_zero.hpp>
#include <tapestry/nn/detail/network/operators/order.hpp>
#include <tapestry/nn/detail/network/operators/pad.hpp>
#include <tapestry/nn/detail/network/operators/pixel_unshuffle.hpp>
#include <tapestry/nn/detail/network/operators/pooling.hpp>
#include <tapestry/nn/detail/network/operators/reduce.hpp>
#include <tapestry/nn/detail/network/operators/resize.hpp>
#include <tapestry/nn/detail/network/operators/roi_align.hpp>
#include <tapestry/nn/detail/network/operators/scatter.hpp>
#include <tapestry/nn/detail/network/operators/tangent.hpp>
#include <tapestry/nn/detail/network/operators/variadic.hpp>

/// The table of operators.hpp. It includes every operator and so takes a compiler long.

namespace tapestry::nn {
template <std::floating_point T>
const OperatorTable<T>& operators() {
  static const OperatorTable<T> table = [] {
    OperatorTable<T> all;
    add_pass_on(all);
    add_convolution(all);
    add_channel_shuffle(all);
    add_pixel_unshuffle(all);
    add_interleave_channels(all);
    add_unary_operators(all);
    add_binary_operators(all);
    add_variadic_operators(all);
    add_max_pool(all);
    add_average_pool(all);
    add_resize(all);
    add_grid_sample(all);
    add_roi_align(all);
    add_local_response_normalization(all);
    add_layer_normalization(all);
    add_group_normalization(all);
    add_batch_normalization(all);
    add_matmul(all);
    add_gemm(all);
    add_convolution_transpose(all);
    add_reshape_operators(all);
    add_view_operators(all);
    add_pad_operators(all);
    add_gather_operators(all);
    add_scatter_operators(all);
    add_cast_operators(all);
    add_generators(all);
    add_reduce_operators(all);
    add_softmax_operators(all);
    add_order_operators(all);
    add_non_max_suppression(all);
    add_non_zero(all);
    add_tangent(all);
    return all;
  }();
  return table;
}
}  // namespace tapestry::nn
