#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/decompositions/einsum.hpp>
#include <tapestry/nn/detail/network/decompositions/fused.hpp>
#include <tapestry/nn/detail/network/decompositions/one_axis.hpp>
#include <tapestry/nn/detail/network/decompositions/recurrent.hpp>

namespace tapestry::nn {

const std::map<std::string, Decomposable, std::less<>>& decompositions() {
  static const std::map<std::string, Decomposable, std::less<>> table{
      {"Attention", {detail::decompose_attention}},
      {"AveragePool", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"Col2Im", {detail::decompose_col2im}},
      {"Conv", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"ConvTranspose", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"Einsum", {detail::decompose_einsum}},
      {"GRU", {detail::decompose_gru}},
      {"GlobalAveragePool", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"GlobalMaxPool", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"LSTM", {detail::decompose_lstm}},
      {"RNN", {detail::decompose_rnn}},
      {"MaxPool", {detail::decompose_along_one_axis, detail::has_one_axis}},
      {"RMSNormalization", {detail::decompose_rms_normalization}},
      {"com.microsoft.QuickGelu", {detail::decompose_quick_gelu}},
  };
  return table;
}

}  // namespace tapestry::nn
