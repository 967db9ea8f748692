#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::detect {

/// Refuses what a detector says about a picture unless all of it is finite: sound weights can still overflow
/// on the way, and decode() leaves out candidates that are not numbers.
///
/// \param logits   one array for each head
/// \param picture  its name, for the message
/// \throws NumericError naming the first output that is not finite
template <std::floating_point T>
void require_finite_logits(const std::vector<Array<T, 4>>& logits, const std::string& picture) {
  for (const auto& head : logits)
    for (std::size_t i = 0; i < head.size(); ++i)
      if (!std::isfinite(head.data()[i]))
        throw NumericError(picture + ": output " + std::to_string(i) +
                           " of the detector; expected a finite number, found " +
                           std::to_string(head.data()[i]));
}

}  // namespace tapestry::detect
