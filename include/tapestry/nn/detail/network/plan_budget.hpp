#pragma once
#include <set>
#include <tapestry/core/error.hpp>

namespace tapestry::nn {
/// Amounts left to the plans of one network, all its stages together. Counts: every machine refuses the same
/// files. Each is checked before its objects are made. docs/SECURITY.md states them.
struct PlanBudget {
  std::size_t nodes = std::size_t(3) << 15U;    ///< nodes that others are taken apart into
  std::size_t planned = std::size_t(1) << 19U;  ///< nodes that later stages plan anew
  std::size_t stages = std::size_t(1) << 10U;
  std::size_t bytes = std::size_t(1) << 27U;   ///< results and weights in the bodies of loops
  std::size_t reads = std::size_t(1) << 30U;   ///< elements that these read
  std::size_t folded = std::size_t(1) << 22U;  ///< elements computed beforehand; and 4 for each of a constant
  std::size_t values = std::size_t(1) << 28U;  ///< elements of all results; and 4,096 for each of an input or
                                               ///< a constant

  bool is_begun = false;             ///< whether the network's inputs and constants have been added
  std::set<std::string> repeated{};  ///< values of loops' rounds that a later stage makes

  /// Takes an amount of one of these. \throws Error (limit)
  void take(std::size_t PlanBudget::*what, std::size_t amount, const char* of) {
    if (amount > this->*what)
      throw Error(ErrorKind::limit,
                  {"more ", of, " than a network's budget: ", amount, " where ", this->*what, " are left"});
    this->*what -= amount;
  }
  /// Takes a node; its operands count if there are many. \throws Error (limit)
  void take_node(std::size_t operands) {
    take(&PlanBudget::nodes, 1 + operands / 16, "nodes, with those of loops,");
  }
};
}  // namespace tapestry::nn
