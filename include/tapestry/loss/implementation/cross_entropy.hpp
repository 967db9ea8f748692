#pragma once
#include <numeric>
#include <tapestry/loss/cross_entropy.hpp>
#include <tapestry/loss/detail/logistic.hpp>

namespace tapestry::loss {
namespace detail {
template <std::floating_point T>
void require_wanted(const char* operation, const Array<T, 4>& logits, const Array<T, 4>& wanted) {
  require_shape(operation, "wanted", wanted, logits.shape());
  if (logits.size() == 0) throw ShapeError({operation, ": no logits"});
}

inline constexpr std::size_t entropy_block = 4096;  ///< logits that a thread takes at a time

/// Calls body(place of class 0, distance of classes, Σ exp(x − largest), largest) for each softmax.
template <std::floating_point T, class Body>
void for_each_softmax(const Array<T, 4>& logits, Body body) {
  const std::size_t classes = logits.shape(1), cells = logits.shape(2) * logits.shape(3);
  for (std::size_t n = 0; n < logits.shape(0); ++n)
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const std::size_t first = n * classes * cells + cell;
      double largest = static_cast<double>(logits.data()[first]);
      for (std::size_t k = 1; k < classes; ++k)
        largest = std::max(largest, static_cast<double>(logits.data()[first + k * cells]));
      double sum = 0;
      for (std::size_t k = 0; k < classes; ++k)
        sum += std::exp(static_cast<double>(logits.data()[first + k * cells]) - largest);
      body(first, cells, sum, largest);
    }
}
}  // namespace detail

template <std::floating_point T>
T binary_cross_entropy(const Array<T, 4>& logits, const Array<T, 4>& wanted) {
  detail::require_wanted("binary_cross_entropy", logits, wanted);
  std::vector<double> sums(block_count(logits.size(), detail::entropy_block), 0);
  parallel_for(sums.size(), [&](std::size_t block) {
    const auto [begin, end] = block_range(block, logits.size(), detail::entropy_block);
    for (std::size_t i = begin; i < end; ++i)
      sums[block] += static_cast<double>(binary_cross_entropy(logits.data()[i], wanted.data()[i]));
  });
  const double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  return static_cast<T>(sum / static_cast<double>(logits.size()));
}

template <std::floating_point T>
void binary_cross_entropy_adjoint(const Array<T, 4>& logits, const Array<T, 4>& wanted, T value_adjoint,
                                  Array<T, 4>& logits_adjoint) {
  detail::require_wanted("binary_cross_entropy", logits, wanted);
  require_shape("binary_cross_entropy_adjoint", "logits_adjoint", logits_adjoint, logits.shape());
  const T scale = value_adjoint / static_cast<T>(logits.size());
  parallel_for_blocks(logits.size(), detail::entropy_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      logits_adjoint.data()[i] += scale * binary_cross_entropy_slope(logits.data()[i], wanted.data()[i]);
  });
}

template <std::floating_point T>
T cross_entropy(const Array<T, 4>& logits, const Array<T, 4>& wanted) {
  detail::require_wanted("cross_entropy", logits, wanted);
  double total = 0;
  detail::for_each_softmax(logits, [&](std::size_t first, std::size_t distance, double sum, double largest) {
    total += std::log(sum);
    for (std::size_t k = 0; k < logits.shape(1); ++k) {  // Σ t = 1, so that `largest` goes into the sum
      const std::size_t at = first + k * distance;
      if (wanted.data()[at] != 0)
        total += static_cast<double>(wanted.data()[at]) * (largest - static_cast<double>(logits.data()[at]));
    }
  });
  return static_cast<T>(total * static_cast<double>(logits.shape(1)) / static_cast<double>(logits.size()));
}

template <std::floating_point T>
void cross_entropy_adjoint(const Array<T, 4>& logits, const Array<T, 4>& wanted, T value_adjoint,
                           Array<T, 4>& logits_adjoint) {
  detail::require_wanted("cross_entropy", logits, wanted);
  require_shape("cross_entropy_adjoint", "logits_adjoint", logits_adjoint, logits.shape());
  const double scale = static_cast<double>(value_adjoint) * static_cast<double>(logits.shape(1)) /
                       static_cast<double>(logits.size());
  detail::for_each_softmax(logits, [&](std::size_t first, std::size_t distance, double sum, double largest) {
    for (std::size_t k = 0; k < logits.shape(1); ++k) {
      const std::size_t at = first + k * distance;
      const double share = std::exp(static_cast<double>(logits.data()[at]) - largest) / sum;
      logits_adjoint.data()[at] += static_cast<T>(scale * (share - static_cast<double>(wanted.data()[at])));
    }
  });
}

template <std::floating_point T>
Variable<T> binary_cross_entropy(const ArrayVariable<T, 4>& logits,
                                 std::shared_ptr<const Array<T, 4>> wanted) {
  const T value = binary_cross_entropy(logits.value(), *wanted);
  const auto pullback = [x = logits.shared_value(), t = std::move(wanted)](T adjoint,
                                                                           Array<T, 4>* logits_adjoint) {
    binary_cross_entropy_adjoint(*x, *t, adjoint, *logits_adjoint);
  };
  return record_scalar(value, pullback, logits);
}

template <std::floating_point T>
Variable<T> cross_entropy(const ArrayVariable<T, 4>& logits, std::shared_ptr<const Array<T, 4>> wanted) {
  const T value = cross_entropy(logits.value(), *wanted);
  const auto pullback = [x = logits.shared_value(), t = std::move(wanted)](T adjoint,
                                                                           Array<T, 4>* logits_adjoint) {
    cross_entropy_adjoint(*x, *t, adjoint, *logits_adjoint);
  };
  return record_scalar(value, pullback, logits);
}
}  // namespace tapestry::loss
