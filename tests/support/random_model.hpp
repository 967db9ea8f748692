#pragma once
#include <tapestry/detect/darknet_model.hpp>
#include "cfg_text.hpp"

namespace tapestry::test {
inline const std::string common_layers = cfg_text("common_layers");
inline const std::string relatives_layers = cfg_text("relatives_layers");
inline const std::string unequal_layers = cfg_text("unequal_layers");
inline const std::string classifier_layers = cfg_text("classifier_layers");
inline const std::string product_layers = cfg_text("product_layers");
inline const std::string region_layers = cfg_text("region_layers");

/// The model of a cfg with random weights, shifts, scales and running statistics.
template <class T>
detect::DarknetModel<T> random_model(detect::NetworkConfig config, std::uint64_t seed, std::size_t size = 0) {
  detect::DarknetModel<T> model(std::move(config), size, size);
  Random random(seed);
  model.initialise(random);
  auto& parameters = model.parameters();
  for (const auto& block : model.layout().blocks) {
    if (block.role == detect::ParameterRole::weight) continue;
    const bool is_positive =
        block.role == detect::ParameterRole::scale || block.role == detect::ParameterRole::variance;
    for (std::size_t i = 0; i < block.count; ++i)
      parameters[block.offset + i] =
          static_cast<T>(random.uniform(is_positive ? 0.5 : -0.3, is_positive ? 1.5 : 0.3));
  }
  return model;
}
}  // namespace tapestry::test
