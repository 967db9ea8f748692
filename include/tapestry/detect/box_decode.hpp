#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/head.hpp>

namespace tapestry::detect {
/// One class of one candidate box.
struct Detection {
  std::size_t class_index = 0;
  double confidence = 0;  ///< probability of an object times that of its class; else the class's
  double objectness = 0;  ///< probability of an object; of a head without objectness that of the surest class
  Box box{};              ///< pixels of the network's input
  std::size_t head = 0;
  std::size_t candidate = 0;  ///< (anchor · H + row) · W + column within its head
};

/// Every class of every candidate whose confidence is above the threshold, in the order head, candidate,
/// class, each head by its own decode family. Candidates with a NaN among their logits are never above it.
///
/// \param logits  one for each head, see Head; of the family scaled activations in [0, 1]
/// \param image   which of the N
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image, or as
///         require_layout()
template <std::floating_point T>
[[nodiscard]] std::vector<Detection> decode(const std::vector<Head>& heads,
                                            const std::vector<Array<T, 4>>& logits, std::size_t image,
                                            double confidence_threshold, std::size_t input_height,
                                            std::size_t input_width);

/// Throws unless all logits of a picture are finite: sound weights can still overflow on the way, and
/// decode() leaves out candidates that are not numbers.
///
/// \param logits   one array for each head
/// \param picture  its name, for the message
/// \throws NumericError naming the first output that is not finite
template <std::floating_point T>
void require_finite_logits(const std::vector<Array<T, 4>>& logits, const std::string& picture) {
  for (const auto& head : logits)
    for (std::size_t i = 0; i < head.size(); ++i)
      if (!std::isfinite(head.data()[i]))
        throw NumericError(
            {picture, ": output ", i, " of the detector; expected a finite number, found ", head.data()[i]});
}
}  // namespace tapestry::detect
