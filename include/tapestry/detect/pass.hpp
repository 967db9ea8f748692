#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <mutex>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/network_pass.hpp>
#include <tapestry/nn/workspace.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

using nn::Mode;

/// The result of one forward pass and what its adjoint needs. A pass may be used again, and then keeps its
/// memory; two threads must not share one.
template <std::floating_point T>
struct Pass {
  Pass();
  Pass(Pass&&) noexcept;
  Pass& operator=(Pass&&) noexcept;
  ~Pass();

  /// For each head [N, A·(5+K), H, W]; see Head.
  std::vector<Array<T, 4>> logits{};

  Mode mode = Mode::inference;
  std::size_t images = 0;
  std::vector<nn::NetworkPass<T>> graph{};  ///< one for each image, or one for all
  std::vector<nn::Buffer<T>> inputs{};      ///< likewise: images as the network takes them

  nn::PassTimes* times = nullptr;  ///< takes the time of each operation, unless null

  /// NetworkPass::take_kinks() of each image.
  /// \throws DomainError unless both passes are forward()'s for a gradient of the same number of images
  template <class U>
  void take_kinks(const Pass<U>& other) {
    if (graph.size() != other.graph.size() || images != other.images)
      throw DomainError("Pass::take_kinks: the passes are not both for a gradient of the same images");
    for (std::size_t i = 0; i < graph.size(); ++i) graph[i].take_kinks(other.graph[i]);
  }
};

extern template struct Pass<float>;
extern template struct Pass<double>;

/// Memory of a detector's passes, for steps that record again and again, and for threads that examine
/// pictures. A copy of a pool shares its passes.
template <std::floating_point T>
class PassPool {
 public:
  /// A pass that no tape and no other thread holds. It returns to the pool when it is released, even if the
  /// pool is gone. May be called by several threads at once.
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
