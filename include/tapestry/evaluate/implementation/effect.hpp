#pragma once
#include <string>
#include <tapestry/evaluate/effect.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <vector>

namespace tapestry::evaluate {

Effect effect_beyond(const Measurement& control, const Measurement& adversarial,
                     const BootstrapSettings& settings) {
  const auto compare = [&](const auto& of_control, const auto& of_adversarial) {
    return paired_bootstrap(detail::means_of_views(of_control, control.draws),
                            detail::means_of_views(of_adversarial, adversarial.draws), settings);
  };
  return {control.name, compare(control.best_confidence, adversarial.best_confidence),
          compare(control.found, adversarial.found)};
}

}  // namespace tapestry::evaluate
