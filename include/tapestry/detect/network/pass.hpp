#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/network_pass.hpp>
#include <tapestry/nn/vector_kernels.hpp>
#include <tapestry/nn/window.hpp>
#include <tapestry/nn/workspace.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

using nn::Mode;

namespace detail {
struct WindowPlan;

/// What a forward pass keeps of one value. Activations are [image, row, column, channel].
template <class T>
struct LayerState {
  nn::Buffer<T> output{};
  nn::Buffer<T> unnormalised{};          ///< training with batch normalisation: the convolution's sums
  nn::Buffer<T> argument{};              ///< of an activation whose slope needs it
  nn::Buffer<std::uint8_t> positive{};   ///< of an activation whose slope needs only a sign: one bit a value
  nn::Buffer<nn::Position<T>> choice{};  ///< maxpool
  nn::BatchStatistics statistics{};      ///< training with batch normalisation
};
}  // namespace detail

/// The result of one forward pass and what its adjoint needs. A pass may be used again, and then keeps its
/// memory; two threads must not share one.
template <class T>
struct Pass {
  Pass();
  Pass(Pass&&) noexcept;
  Pass& operator=(Pass&&) noexcept;
  ~Pass();

  /// For each head [N, A·(5+K), H, W]; see Head.
  std::vector<Array<T, 4>> logits{};

  Mode mode = Mode::inference;
  std::size_t images = 0;
  std::vector<detail::LayerState<T>> layers{};  ///< one for each layer, then the image
  nn::Workspace<T> workspace{};
  nn::Buffer<T> partial_sums{};  ///< of weight gradients

  // After Detector::forward_within():
  std::vector<Pass> within{};  ///< one for each image, whose logits are in this one
  std::shared_ptr<const detail::WindowPlan>
      plan{};                          ///< of such a pass: where it is computed; null: everywhere
  std::optional<nn::Window> window{};  ///< of such a pass: where the image may have changed

  std::vector<nn::NetworkPass<T>> graph{};  ///< of a GraphDetector: one for each image
  std::vector<nn::Buffer<T>> inputs{};      ///< likewise: the image as the network takes it

  /// Takes the side of every kink, the signs of leaky units and the choices of max-pooling, from another pass
  /// over the same network and images. A forward pass in float flips a few signs next to zero, each of which
  /// changes the gradient by a step; with the sides of the float pass a pass in double is the reference that
  /// leaves only rounding. \throws DomainError unless both passes are forward()'s for a gradient of the same
  /// number of images
  template <class U>
  void take_kinks(const Pass<U>& other) {
    if (mode == Mode::inference || other.mode == Mode::inference || images != other.images ||
        layers.size() != other.layers.size() || !within.empty() || !other.within.empty())
      throw DomainError("Pass::take_kinks: the passes are not both for a gradient of the same images");
    for (std::size_t i = 0; i < layers.size(); ++i) {
      std::copy_n(other.layers[i].positive.data(), layers[i].positive.size(), layers[i].positive.data());
      for (std::size_t k = 0; k < layers[i].choice.size(); ++k)
        layers[i].choice.data()[k] = static_cast<nn::Position<T>>(other.layers[i].choice.data()[k]);
    }
  }
};

extern template struct Pass<float>;
extern template struct Pass<double>;

namespace detail {
/// \throws DomainError unless the pass was for training; ShapeError unless count is as expected
template <class T>
void require_parameters_adjoint(const char* operation, const Pass<T>& pass, std::size_t count,
                                std::size_t expected) {
  if (pass.mode != Mode::training)
    throw DomainError(std::string(operation) + ": the pass was not for training");
  if (count != expected)
    throw ShapeError(std::string(operation) + ": parameters_adjoint is [" + std::to_string(count) +
                     "], expected [" + std::to_string(expected) + "]");
}
}  // namespace detail

}  // namespace tapestry::detect
