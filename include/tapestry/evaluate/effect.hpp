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

namespace detail {

/// The mean of each view's pictures, so that a view counts once however often it was photographed.
template <class Value>
std::vector<double> means_of_views(const std::vector<Value>& of_pictures, std::size_t draws) {
  std::vector<double> means(of_pictures.size() / draws);
  for (std::size_t i = 0; i < of_pictures.size(); ++i)
    means[i / draws] += static_cast<double>(of_pictures[i]) / static_cast<double>(draws);
  return means;
}

}  // namespace detail

/// \param control, adversarial  measured in the same views, in the same order
/// \throws ShapeError if they do not have as many views; DomainError as paired_bootstrap()
[[nodiscard]] Effect effect_beyond(const Measurement& control, const Measurement& adversarial,
                                   const BootstrapSettings& settings = {});

}  // namespace tapestry::evaluate
