#pragma once
#include <concepts>
#include <memory>
#include <tapestry/detect/network/pass.hpp>
#include <vector>

namespace tapestry::detect {

/// Memory of a detector's passes, for loops that record again and again: the same from step to step.
template <std::floating_point T>
class PassPool {
 public:
  /// A pass that no tape holds any more.
  [[nodiscard]] std::shared_ptr<Pass<T>> take() {
    for (const auto& pass : passes_)
      if (pass.use_count() == 1) return pass;
    return passes_.emplace_back(std::make_shared<Pass<T>>());
  }

 private:
  std::vector<std::shared_ptr<Pass<T>>> passes_;
};

}  // namespace tapestry::detect
