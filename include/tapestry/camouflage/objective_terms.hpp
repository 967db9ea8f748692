#pragma once
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

struct ObjectiveTerm;

/// The terms of one minibatch, before their weights, averaged over its views.
struct ObjectiveTerms {
  double iou = 0;
  double objectness = 0;
  double classification = 0;
  double max_score = 0;
  double smoothness = 0;    ///< sum of squared colour steps
  double printability = 0;  ///< non-printability score of the paint, 0 where no printer is known
  double total = 0;         ///< weighted sum, which is minimised

  /// Every term, a row each: checkpoints, reports and options of programs list them in this order.
  static const std::array<ObjectiveTerm, 7> all;

  /// Adds each term of others, divided by so much.
  void add(const ObjectiveTerms& others, double divisor = 1);
};

/// A term by its name, and the option of programs for its weight.
struct ObjectiveTerm {
  const char* name;
  double ObjectiveTerms::*value;
  const char* brief;             ///< short name for a line with all terms; empty: not in it
  const char* option = nullptr;  ///< null: no weight
  double& (*weight)(ObjectiveOptions& options) = nullptr;
  const char* help = nullptr;  ///< shown for the option
};
inline constexpr std::array<ObjectiveTerm, 7> ObjectiveTerms::all{
    {{"iou", &ObjectiveTerms::iou, "iou", "iou-weight",
      [](ObjectiveOptions& o) -> double& { return o.weights.iou; }, "weight alpha of the IoU term"},
     {"objectness", &ObjectiveTerms::objectness, "obj", "objectness-weight",
      [](ObjectiveOptions& o) -> double& { return o.weights.objectness; },
      "weight beta of the objectness term"},
     {"classification", &ObjectiveTerms::classification, "cls", "class-weight",
      [](ObjectiveOptions& o) -> double& { return o.weights.classification; },
      "weight gamma of the classification term"},
     {"max_score", &ObjectiveTerms::max_score, "max", "max-score-weight",
      [](ObjectiveOptions& o) -> double& { return o.weights.max_score; }, "weight of the max_score term"},
     {"smoothness", &ObjectiveTerms::smoothness, "smooth", "smoothness-weight",
      [](ObjectiveOptions& o) -> double& { return o.smoothness; },
      "weight mu of the smoothness term, in units of 1e-4"},
     {"printability", &ObjectiveTerms::printability, "", "printability",
      [](ObjectiveOptions& o) -> double& { return o.printability; },
      "weight of the non-printability score: how far the paint's colours are from those of --palette"},
     {"total", &ObjectiveTerms::total, ""}}};

inline void ObjectiveTerms::add(const ObjectiveTerms& others, double divisor) {
  for (const ObjectiveTerm& term : all) this->*term.value += others.*term.value / divisor;
}

/// Values of the terms of an adversarial loss, which are variables.
template <class Term>
[[nodiscard]] ObjectiveTerms numbers_of(const loss::AdversarialTerms<Term>& adversarial) {
  const auto number = [](const Term& term) { return static_cast<double>(term.value()); };
  return {.iou = number(adversarial.iou),
          .objectness = number(adversarial.objectness),
          .classification = number(adversarial.classification),
          .max_score = number(adversarial.max_score),
          .total = number(adversarial.total)};
}

/// Weights of a minibatch's views if only the worst share of them counts: they add up to one, and the
/// weighted sum of the losses is their conditional value at risk,
///
///   CVaR = Σ w[i]·L[i] = min over z of  z + 1/(share·n) · Σ max(0, L[i] − z).
///
/// The views of the largest losses count 1/(share·n) each, the last of them the rest; of equal losses the
/// earlier one counts first. A share of 1 is the mean, one of at most 1/n the largest loss alone. The
/// gradient of the sum with fixed weights is CVaR's if no two losses at its edge are equal, and
/// otherwise a subgradient. Source: Rockafellar and Uryasev, "Optimization of conditional value-at-risk"
/// (J. Risk 2, 2000), eq. 4 and 9.
///
/// \param losses  L, at least one, none NaN
/// \param share   above 0, at most 1
/// \throws DomainError for a share out of range or without losses
[[nodiscard]] std::vector<double> worst_view_weights(std::span<const double> losses, double share);
}  // namespace tapestry::camouflage
