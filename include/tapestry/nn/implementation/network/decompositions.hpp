#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/decompositions/einsum.hpp>
#include <tapestry/nn/detail/network/decompositions/fused.hpp>
#include <tapestry/nn/detail/network/decompositions/recurrent.hpp>

namespace tapestry::nn {

const std::map<std::string, Decompose, std::less<>>& decompositions() {
  static const std::map<std::string, Decompose, std::less<>> table{
      {"Attention", detail::decompose_attention},
      {"Col2Im", detail::decompose_col2im},
      {"Einsum", detail::decompose_einsum},
      {"GRU", detail::decompose_gru},
      {"LSTM", detail::decompose_lstm},
      {"RNN", detail::decompose_rnn},
      {"RMSNormalization", detail::decompose_rms_normalization},
      {"com.microsoft.QuickGelu", detail::decompose_quick_gelu},
  };
  return table;
}

}  // namespace tapestry::nn
