#pragma once
#include <cmath>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::shell {

/// Throws NumericError unless all that a detector says about a picture is finite: sound weights can still
/// overflow on the way.
inline void require_finite_logits(const std::vector<Array<float, 4>>& logits, const std::string& picture) {
  for (const auto& head : logits)
    for (std::size_t i = 0; i < head.size(); ++i)
      if (!std::isfinite(head.data()[i]))
        throw NumericError(picture + ": output " + std::to_string(i) +
                           " of the detector; expected a finite number, found " +
                           std::to_string(head.data()[i]));
}

}  // namespace tapestry::shell
