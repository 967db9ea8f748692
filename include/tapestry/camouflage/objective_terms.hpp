#pragma once
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/loss/adversarial.hpp>

namespace tapestry::camouflage {

/// μ = 1 stands for this factor before the sum of squared colour steps. The paper prints μ = 1 and its
/// published program multiplies the sum by 1e-4; without the factor the sum, some thousands at 416
/// pixels, drowns adversarial terms that never exceed ten.
inline constexpr double smoothness_unit = 1e-4;

/// The loss to minimise, and its weights.
struct ObjectiveOptions {
  loss::AdversarialLoss kind = loss::AdversarialLoss::paper;
  loss::AdversarialWeights weights{};  ///< α, β, γ of the paper
  double smoothness = 1;               ///< μ, in units of smoothness_unit
  double printability = 1;             ///< weight of the non-printability score, after print_by()
  std::size_t class_index = 0;         ///< the class that the car should no longer be found as
};

/// The terms of one minibatch, before their weights, averaged over its views.
struct ObjectiveTerms {
  double iou = 0;
  double objectness = 0;
  double classification = 0;
  double max_score = 0;
  double smoothness = 0;    ///< sum of squared colour steps
  double printability = 0;  ///< non-printability score of the paint, 0 where no printer is known
  double total = 0;         ///< weighted sum, which is minimised

  /// Name and member of each term, in this order.
  static const std::array<std::pair<const char*, double ObjectiveTerms::*>, 7> all;

  /// Adds each term of others, divided by so much.
  void add(const ObjectiveTerms& others, double divisor = 1);
};
inline constexpr std::array<std::pair<const char*, double ObjectiveTerms::*>, 7> ObjectiveTerms::all{
    {{"iou", &ObjectiveTerms::iou},
     {"objectness", &ObjectiveTerms::objectness},
     {"classification", &ObjectiveTerms::classification},
     {"max_score", &ObjectiveTerms::max_score},
     {"smoothness", &ObjectiveTerms::smoothness},
     {"printability", &ObjectiveTerms::printability},
     {"total", &ObjectiveTerms::total}}};

inline void ObjectiveTerms::add(const ObjectiveTerms& others, double divisor) {
  for (const auto& [name, term] : all) this->*term += others.*term / divisor;
}

/// Values of the terms; those of the loss are variables.
template <class Term>
[[nodiscard]] ObjectiveTerms numbers_of(const loss::AdversarialTerms<Term>& adversarial,
                                        const Term& smoothness, const Term& printability, const Term& total) {
  const auto number = [](const Term& term) { return static_cast<double>(term.value()); };
  return {number(adversarial.iou),
          number(adversarial.objectness),
          number(adversarial.classification),
          number(adversarial.max_score),
          number(smoothness),
          number(printability),
          number(total)};
}

/// Weights of a minibatch's views if only the worst share of them counts: they add up to one, and the
/// weighted sum of the losses is their conditional value at risk,
///
///   CVaR = Σ w[i]·L[i] = min over z of  z + 1/(share·n) · Σ max(0, L[i] − z).
///
/// The views of the largest losses count 1/(share·n) each, the last of them the rest; of equal losses the
/// earlier one counts first. A share of 1 is the mean, one of at most 1/n the largest loss alone. The
/// gradient of the sum with fixed weights is that of CVaR if no two losses at its edge are equal, and
/// otherwise a subgradient. Source: Rockafellar and Uryasev, "Optimization of conditional value-at-risk" (J.
/// Risk 2, 2000), eq. 4 and 9.
///
/// \param losses  L, at least one, none NaN
/// \param share   above 0, at most 1
/// \throws DomainError for a share out of range or without losses
[[nodiscard]] std::vector<double> worst_view_weights(std::span<const double> losses, double share);

}  // namespace tapestry::camouflage
