#pragma once
#include "catch.hpp"
#include "finite_difference.hpp"
#include "random_array.hpp"

namespace tapestry::test {
/// Checks each head's adjoint along a random direction against central differences of value(logits).
/// \param bound  of the error, in tolerances of a central difference
template <class T, class Value>
void check_head_adjoints(const std::vector<Array<T, 4>>& adjoint, const std::vector<Array<T, 4>>& logits,
                         std::uint64_t seed, T bound, Value value) {
  for (std::size_t head = 0; head < logits.size(); ++head) {
    const auto& shape = logits[head].shape();
    const auto direction = random_direction<T>({shape[0], shape[1], shape[2], shape[3]}, seed * 100 + head);
    const auto of_head = [&](const Array<T, 4>& changed) {
      auto at = logits;
      at[head] = changed;
      return value(at);
    };
    CAPTURE(seed, head);
    CHECK(std::abs(dot(adjoint[head], direction) - central_difference(of_head, logits[head], direction)) <=
          bound * central_difference_tolerance(value(logits)));
  }
}
}  // namespace tapestry::test
