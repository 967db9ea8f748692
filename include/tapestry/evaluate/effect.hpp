#pragma once
#include <string>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <vector>

namespace tapestry::evaluate {

/// What a camouflage does beyond a control: the control's figures minus its own, over the same views. The
/// intervals are those of the views; another draw of a control that is random moves the means as well.
struct Effect {
  std::string control;                 ///< its name
  PairedDifference best_confidence{};  ///< of the means of best_confidence()
  PairedDifference p_at_50{};          ///< of the shares of views in which the car is found
};

/// \param control, adversarial  measured in the same views, in the same order
/// \throws ShapeError if they do not have as many views; DomainError as paired_bootstrap()
[[nodiscard]] inline Effect effect_beyond(const Measurement& control, const Measurement& adversarial,
                                          const BootstrapSettings& settings = {}) {
  const auto shares = [](const std::vector<bool>& found) {
    return std::vector<double>(found.begin(), found.end());
  };
  return {control.name, paired_bootstrap(control.best_confidence, adversarial.best_confidence, settings),
          paired_bootstrap(shares(control.found), shares(adversarial.found), settings)};
}

}  // namespace tapestry::evaluate
