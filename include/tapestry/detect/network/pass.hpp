#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/vector_kernels.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

/// What a forward pass is for, which decides what it keeps.
enum class Mode {
  inference,       ///< running statistics; nothing is kept but the logits
  input_gradient,  ///< running statistics; slopes and choices are kept for input_adjoint()
  training,        ///< statistics of the batch; everything is kept for either adjoint
};

namespace detail {

/// Memory that layers hand to one another, kept between passes.
template <class T>
class Workspace {
 public:
  /// The smallest free buffer that is large enough, else the largest one, grown.
  [[nodiscard]] nn::Buffer<T> take(std::size_t count) {
    std::size_t best = free_.size();
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (best == free_.size()) {
        best = i;
        continue;
      }
      const bool fits = free_[i].capacity() >= count;
      const bool best_fits = free_[best].capacity() >= count;
      const bool is_smaller = free_[i].capacity() < free_[best].capacity();
      if (fits ? !best_fits || is_smaller : !best_fits && !is_smaller) best = i;
    }
    nn::Buffer<T> buffer;
    if (best < free_.size()) {
      buffer = std::move(free_[best]);
      free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(best));
    }
    buffer.resize(count);
    return buffer;
  }

  void give(nn::Buffer<T>&& buffer) {
    if (buffer.capacity() > 0) free_.push_back(std::move(buffer));
    buffer = nn::Buffer<T>();
  }

 private:
  std::vector<nn::Buffer<T>> free_;
};

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
  /// For each head [N, A·(5+K), H, W]; see Head.
  std::vector<Array<T, 4>> logits{};

  Mode mode = Mode::inference;
  std::size_t images = 0;
  std::vector<detail::LayerState<T>> layers{};  ///< one for each layer, then the image
  detail::Workspace<T> workspace{};
  nn::Buffer<T> partial_sums{};  ///< of weight gradients

  /// Takes the side of every kink, the signs of leaky units and the choices of max-pooling, from another pass
  /// over the same network and images. A forward pass in float flips a few signs next to zero, each of which
  /// changes the gradient by a step; with the sides of the float pass a pass in double is the reference that
  /// leaves only rounding. \throws DomainError unless both passes are for a gradient of the same number of
  /// images
  template <class U>
  void take_kinks(const Pass<U>& other) {
    if (mode == Mode::inference || other.mode == Mode::inference || images != other.images ||
        layers.size() != other.layers.size())
      throw DomainError("Pass::take_kinks: the passes are not both for a gradient of the same images");
    for (std::size_t i = 0; i < layers.size(); ++i) {
      std::copy_n(other.layers[i].positive.data(), layers[i].positive.size(), layers[i].positive.data());
      for (std::size_t k = 0; k < layers[i].choice.size(); ++k)
        layers[i].choice.data()[k] = static_cast<nn::Position<T>>(other.layers[i].choice.data()[k]);
    }
  }
};

}  // namespace tapestry::detect
