#pragma once
#include <tapestry/nn/detail/network/decompositions/control.hpp>
#include <tapestry/nn/detail/network/decompositions/deformable.hpp>
#include <tapestry/nn/detail/network/decompositions/einsum.hpp>
#include <tapestry/nn/detail/network/decompositions/fused.hpp>
#include <tapestry/nn/detail/network/decompositions/losses.hpp>
#include <tapestry/nn/detail/network/decompositions/quantised.hpp>
#include <tapestry/nn/detail/network/decompositions/recurrent.hpp>
#include <tapestry/nn/detail/network/decompositions/three_axes.hpp>

namespace tapestry::nn {
const std::map<std::string, Decomposable, std::less<>>& decompositions() {
  const Decomposable odd_axes{{}, detail::decompose_odd_axes, detail::has_odd_axes},
      one_axis{{}, detail::decompose_along_one_axis, detail::has_one_axis};
  static const std::map<std::string, Decomposable, std::less<>> table{
      {"Attention", {{{3, 6}}, detail::decompose_attention}},
      {"AveragePool", odd_axes},
      {"Col2Im", {{{3, 3}}, detail::decompose_col2im}},
      {"Compress", {{{2, 2}}, detail::decompose_compress}},
      {"Conv", odd_axes},
      {"ConvTranspose", odd_axes},
      {"ConvInteger", {{{2, 4}}, detail::decompose_conv_integer}},
      {"DeformConv", {{{3, 5}}, detail::decompose_deform_conv}},
      {"DequantizeLinear", {{{2, 3}}, detail::decompose_dequantize}},
      {"DynamicQuantizeLinear", {{{1, 1}}, detail::decompose_dynamic_quantize}},
      {"Einsum", {{{1, all_inputs}}, detail::decompose_einsum}},
      {"GRU", {{{3, 6}}, detail::decompose_gru}},
      {"GlobalAveragePool", one_axis},
      {"GlobalMaxPool", one_axis},
      {"If", {{{1, all_inputs}}, detail::decompose_if}},
      {"LSTM", {{{3, 8}}, detail::decompose_lstm}},
      {"Loop", {{{2, all_inputs}}, detail::decompose_loop}},
      {"MatMulInteger", {{{2, 4}}, detail::decompose_matmul_integer}},
      {"MaxPool", odd_axes},
      {"NegativeLogLikelihoodLoss", {{{2, 3}}, detail::decompose_negative_log_likelihood}},
      {"QLinearConv", {{{8, 9}}, detail::decompose_qlinear_conv}},
      {"QLinearMatMul", {{{8, 8}}, detail::decompose_qlinear_matmul}},
      {"QuantizeLinear", {{{2, 3}}, detail::decompose_quantize}},
      {"RMSNormalization", {{{2, 2}}, detail::decompose_rms_normalization}},
      {"RNN", {{{3, 6}}, detail::decompose_rnn}},
      {"SoftmaxCrossEntropyLoss", {{{2, 3}}, detail::decompose_softmax_cross_entropy}},
      {"com.microsoft.QuickGelu", {{{1, 1}}, detail::decompose_quick_gelu}},
  };
  return table;
}
}  // namespace tapestry::nn
