#pragma once
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/loss/adversarial.hpp>

namespace tapestry::loss {

AdversarialLoss adversarial_loss_by_name(const std::string& name) {
  std::string names;
  for (const NamedLoss& loss : adversarial_losses) {
    if (name == loss.name) return loss.kind;
    names += (names.empty() ? "" : ", ") + std::string(loss.name);
  }
  throw DomainError({"no adversarial loss is called '", name, "'; there are ", names});
}

std::string name_of(AdversarialLoss kind) {
  return std::ranges::find(adversarial_losses, kind, &NamedLoss::kind)->name;
}

}  // namespace tapestry::loss
