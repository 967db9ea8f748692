#pragma once
#include <tapestry/loss/adversarial.hpp>

namespace tapestry::loss {
AdversarialLoss adversarial_loss_by_name(const std::string& name) {
  const auto* const found = std::ranges::find(adversarial_losses, name, &NamedLoss::name);
  if (found != adversarial_losses.end()) return found->kind;
  throw DomainError({"no adversarial loss is called '", name, "'; there are ",
                     listed(adversarial_losses, &NamedLoss::name)});
}

std::string name_of(AdversarialLoss kind) {
  return std::ranges::find(adversarial_losses, kind, &NamedLoss::kind)->name;
}
}  // namespace tapestry::loss
