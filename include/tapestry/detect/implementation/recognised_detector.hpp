#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/raw_outputs.hpp>
#include <tapestry/detect/recognised_detector.hpp>
#include <tapestry/nn/network/description.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Filters of the convolution that makes each of these values, looking through a Cast of its weights; 0 where
/// they are not constant.
[[nodiscard]] inline std::vector<std::size_t> filter_counts(const nn::NetworkDescription& network,
                                                            const std::vector<std::string>& values) {
  std::vector<std::size_t> counts;
  for (const std::string& value : values) {
    const nn::Node* const maker = nn::maker_of(network, value);
    std::string weights = maker == nullptr ? "" : maker->inputs.at(1);
    const nn::Node* const cast = nn::maker_of(network, weights);
    if (cast != nullptr && cast->operation == "Cast") weights = cast->inputs.at(0);
    const auto found = network.constants.find(weights);
    const bool is_known = found != network.constants.end() && !found->second.shape.empty();
    counts.push_back(is_known ? found->second.shape.front() : 0);
  }
  return counts;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

std::optional<DetectorDescription> recognised_detector(const nn::NetworkDescription& network) {
  constexpr std::size_t grids = 3, nanodet_bins = 32;
  std::vector<std::size_t> filters = detail::filter_counts(network, raw_outputs(network));
  const auto count = [&](std::size_t wanted) {
    return static_cast<std::size_t>(std::ranges::count(filters, wanted));
  };
  if (filters.size() == 3 * grids && count(4) == grids && count(1) == grids)
    return known_description("yolox");
  const bool is_joined = filters.size() == grids && network.outputs.size() == 2 * grids &&
                         filters.front() > nanodet_bins && count(filters.front()) == grids;
  const bool is_apart = filters.size() == 2 * grids && count(nanodet_bins) == grids;
  if (is_joined || is_apart) return known_description("nanodet");
  return std::nullopt;
}

}  // namespace tapestry::detect
