#pragma once
#include <string>
#include <tapestry/nn/network/description.hpp>
#include <vector>

namespace tapestry::nn {

/// The description with other outputs, and of its nodes and constants only those that they need.
///
/// \param outputs  names of values that the description has
[[nodiscard]] NetworkDescription pruned(NetworkDescription description, std::vector<std::string> outputs);

}  // namespace tapestry::nn
