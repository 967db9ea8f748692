#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>
#include <vector>

namespace tapestry::loss {

/// The terms of the loss a detector is trained with, before weighting, and their weighted sum.
struct YoloTrainingTerms {
  double box = 0, objectness = 0, classification = 0;
  double total = 0;
};

namespace detail {

/// The terms of a batch: those of its images, several at once, summed in order and divided by `count`.
/// \param options   with a weight of each term
/// \param of_image  the terms of an image, called with its number
template <class Options, std::invocable<std::size_t> OfImage>
YoloTrainingTerms batch_terms(std::size_t images, double count, const Options& options, OfImage of_image) {
  std::vector<YoloTrainingTerms> per_image(images);
  parallel_for(images, [&](std::size_t n) { per_image[n] = of_image(n); });
  YoloTrainingTerms terms;
  for (const auto& one : per_image) {
    terms.box += one.box / count;
    terms.objectness += one.objectness / count;
    terms.classification += one.classification / count;
  }
  terms.total = options.box * terms.box + options.objectness * terms.objectness +
                options.classification * terms.classification;
  return terms;
}

}  // namespace detail
}  // namespace tapestry::loss
