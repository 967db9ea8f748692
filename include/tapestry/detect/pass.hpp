#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/pool.hpp>
#include <tapestry/nn/network/staged_network.hpp>

namespace tapestry::detect {
using nn::Mode;

/// The result of one forward pass and the values that its adjoint needs. A pass may be used again, and then
/// keeps its memory; two threads must not share one.
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
  std::vector<nn::NetworkPass<T>> graph{};  ///< one pass for each image, or one for all
  std::vector<nn::StagedPass<T>> stages{};  ///< of a network in stages, instead of `graph`
  std::vector<nn::Buffer<T>> inputs{};      ///< images as the network takes them

  nn::PassTimes* times = nullptr;  ///< takes the time of each operation, unless null

  /// NetworkPass::copy_branches() of each image.
  /// \throws DomainError unless both passes are forward()'s for a gradient of the same number of images
  template <class U>
  void copy_branches(const Pass<U>& other) {
    if (graph.size() != other.graph.size() || images != other.images)
      throw DomainError("Pass::copy_branches: the passes are not both for a gradient of the same images");
    for (std::size_t i = 0; i < graph.size(); ++i) graph[i].copy_branches(other.graph[i]);
  }
};

extern template struct Pass<float>;
extern template struct Pass<double>;

/// Memory of a detector's passes, for steps that record again and again, and for threads that examine
/// pictures.
template <std::floating_point T>
using PassPool = Pool<Pass<T>>;
}  // namespace tapestry::detect
