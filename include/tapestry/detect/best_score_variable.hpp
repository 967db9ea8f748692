#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <vector>

namespace tapestry::detect {

/// How sure a detector is of the surest of all its candidates and classes in a batch of pictures: the largest
/// of confidences(), from 0 to 1, before suppression. Of equals the first has the derivative.
///
/// \param detector  with heads(), input_height() and input_width()
/// \param logits    of forward()
/// \throws as decode()
template <class Detector, std::floating_point T>
[[nodiscard]] Variable<T> best_score(const Detector& detector,
                                     const std::vector<ArrayVariable<T, 4>>& logits) {
  Variable<T> best = 0;
  for (const DecodedHead<T>& head : decode(detector, logits)) {
    const ArrayVariable<T, 1> of_images = largest_along(largest_along(confidences(head), 2), 1);
    for (std::size_t n = 0; n < of_images.size(); ++n) best = max(best, element(of_images, {n}));
  }
  return best;
}

}  // namespace tapestry::detect
