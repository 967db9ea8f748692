#pragma once
#include <string>
#include <tapestry/nn/network/description.hpp>
#include <vector>

namespace tapestry::detect {

/// The convolutions that an exported detector's outputs show, before they were rearranged and before the
/// logistic function: what losses need, since where that rounds to 1 no slope is left. Found by going back
/// from the outputs through operators that only present values; in the order in which they are joined there.
[[nodiscard]] std::vector<std::string> raw_outputs(const nn::NetworkDescription& description);

/// The last value on which all these values depend: of raw outputs, where everything that the heads see still
/// lies in one layer. Empty if there is none.
[[nodiscard]] std::string common_layer(const nn::NetworkDescription& description,
                                       const std::vector<std::string>& outputs);

}  // namespace tapestry::detect
