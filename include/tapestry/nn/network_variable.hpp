#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/nn/network/network.hpp>

namespace tapestry::nn {
/// Results of a network of one input for a batch, as one record on the active tape.
///
/// \param network  its input has four axes, the first of extent 1; it must outlive the tape's last reverse(),
///                 unchanged
/// \param x        [N, …], N inputs of shape network.input_shape(0)
/// \param pass     memory for loops that record again and again. Use it for nothing else before the tape's
///                 last reverse(). Null takes new memory.
/// \returns        for each result of four axes, the first of extent 1, N of them
/// \throws ShapeError unless input, x and results are so; DomainError if x is on no active tape
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network,
                                                       const ArrayVariable<T, 4>& x,
                                                       std::shared_ptr<NetworkPass<T>> pass = nullptr);

/// The same in training mode, also differentiable with respect to the weights. The network takes over the
/// weights' values, which must stay until the tape's last reverse().
///
/// \param weights  in the order of network.weights()
/// \throws ShapeError also for another number of weights; if anything is thrown, they are not taken over
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& x,
                                                       const ArrayVariable<T, 1>& weights,
                                                       std::shared_ptr<NetworkPass<T>> pass = nullptr);

// Layers for your own networks, on the tape. Each is one record, runs the same kernels as detectors, and uses
// all threads. Pictures and maps are [N, H, W, C]. All throw DomainError if an operand is active but on no
// active tape.

/// Step, padding and dilation of a convolution's filters, along both axes.
struct ConvolutionLayer {
  std::size_t stride = 1;
  std::size_t padding = 0;   ///< rows and columns of zeros on each side
  std::size_t dilation = 1;  ///< pixels from one tap to the next
  std::size_t groups = 1;    ///< parts that channels are cut into, each with filters of its own
};

/// Cross-correlation, which networks call convolution:
///
///   y[n, i, j, m] = bias[m] + Σ over r, s, c of weights[m, c, r, s] · x[n, i·stride + r·dilation − p, …, c]
///
/// \param x        [N, H, W, C]
/// \param weights  [M, C / groups, R, S]
/// \param bias     [M]
/// \returns        [N, H', W', M]
/// \throws ShapeError if weights do not fit the channels or the window the picture, DomainError for a stride,
///         dilation or number of groups of 0
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> convolve(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 4>& weights,
                                           const ArrayVariable<T, 1>& bias,
                                           const ConvolutionLayer& layer = {});

/// The same without a bias.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> convolve(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 4>& weights,
                                           const ConvolutionLayer& layer = {});

/// Window of a pooling, along both axes.
struct PoolingLayer {
  std::size_t size = 2;
  std::size_t stride = 2;
  std::size_t padding = 0;  ///< on each side; padding is not counted
};

/// The largest value of each window in each channel, [N, H', W', C]. The first of equal ones in reading order
/// gets the derivative.
/// \throws ShapeError if the window does not fit
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> max_pool(const ArrayVariable<T, 4>& x, const PoolingLayer& layer = {});

/// The mean of each window in each channel, [N, H', W', C]. \throws ShapeError if the window does not fit
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> average_pool(const ArrayVariable<T, 4>& x, const PoolingLayer& layer = {});

/// Batch normalisation by the statistics of the batch itself; the derivative includes the statistics':
///
///   y = scale · (x − mean(x)) / √(variance(x) + ε) + bias      for each channel
///
/// \param x            [N, H, W, C]
/// \param scale, bias  [C]
/// \throws ShapeError unless scale and bias have a value a channel
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> batch_norm(const ArrayVariable<T, 4>& x, const ArrayVariable<T, 1>& scale,
                                             const ArrayVariable<T, 1>& bias, double epsilon = 1e-5);
}  // namespace tapestry::nn
