#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/decompositions/einsum.hpp>
#include <tapestry/nn/detail/network/decompositions/fused.hpp>

namespace tapestry::nn {

const std::map<std::string, Decompose, std::less<>>& decompositions() {
  static const std::map<std::string, Decompose, std::less<>> table{
      {"Einsum", detail::decompose_einsum},
      {"RMSNormalization", detail::decompose_rms_normalization},
      {"com.microsoft.QuickGelu", detail::decompose_quick_gelu},
  };
  return table;
}

}  // namespace tapestry::nn
