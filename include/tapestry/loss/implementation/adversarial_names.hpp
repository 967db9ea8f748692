#pragma once
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/detail/adversarial_terms.hpp>
#include <tapestry/loss/detail/box_assignment.hpp>
#include <tapestry/loss/detail/prediction_variable.hpp>
#include <tapestry/loss/detail/responsible.hpp>

namespace tapestry::loss {

AdversarialLoss adversarial_loss_by_name(const std::string& name) {
  if (name == "paper") return AdversarialLoss::paper;
  if (name == "as_coded") return AdversarialLoss::as_coded;
  if (name == "max_score") return AdversarialLoss::max_score;
  if (name == "vanish") return AdversarialLoss::vanish;
  throw DomainError(
      {"no adversarial loss is called '", name, "'; there are paper, as_coded, max_score and vanish"});
}

std::string name_of(AdversarialLoss kind) {
  constexpr const char* names[] = {"paper", "as_coded", "max_score", "vanish"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace tapestry::loss
