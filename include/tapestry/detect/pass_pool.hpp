#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <mutex>
#include <tapestry/detect/pass.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

/// Memory of a detector's passes, for what runs it again and again: steps that record, and threads that
/// examine pictures. A copy of a pool shares its passes.
template <std::floating_point T>
class PassPool {
 public:
  /// A pass that nobody else holds, no tape and no thread. It comes back when it is let go, if need be after
  /// the pool. May be called by several threads at once.
  [[nodiscard]] std::shared_ptr<Pass<T>> take() {
    return {idle_->take().release(),
            [idle = idle_](Pass<T>* pass) { idle->give_back(std::unique_ptr<Pass<T>>(pass)); }};
  }

 private:
  class Idle {
   public:
    std::unique_ptr<Pass<T>> take() {
      const std::lock_guard lock(mutex_);
      if (passes_.empty()) {
        passes_.reserve(++count_);  // so that none has to be thrown away
        return std::make_unique<Pass<T>>();
      }
      auto pass = std::move(passes_.back());
      passes_.pop_back();
      return pass;
    }
    void give_back(std::unique_ptr<Pass<T>> pass) {
      const std::lock_guard lock(mutex_);
      passes_.push_back(std::move(pass));
    }

   private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Pass<T>>> passes_;
    std::size_t count_ = 0;
  };

  std::shared_ptr<Idle> idle_ = std::make_shared<Idle>();
};

}  // namespace tapestry::detect
