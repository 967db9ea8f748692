#pragma once
#include <tapestry/loss/detail/box_assignment.hpp>

namespace tapestry::loss::detail {

ClassCost::ClassCost(double class_logit, std::optional<double> objectness_logit) {
  constexpr double most = 100;
  if_present = softplus(-class_logit);
  if (objectness_logit) if_present = (if_present + softplus(-*objectness_logit)) / 2;
  if_absent = std::min(most, -std::log(-std::expm1(-if_present)));
  if_present = std::min(most, if_present);
}

void require_free_heads(const char* operation, const std::vector<detect::Head>& heads) {
  for (const auto& head : heads)
    if (detect::has_anchors(head.decode) || head.decode == detect::DecodeFamily::decoded)
      throw DomainError({operation, ": heads of the decode family ", detect::name_of(head.decode),
                         ", whose candidates are no cells without anchors; expected yolox or distance"});
}

}  // namespace tapestry::loss::detail
