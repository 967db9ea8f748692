#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/over.hpp>
#include <vector>

namespace tapestry::image {

/// over() on the tape, by each of its three arrays.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> over(const ArrayVariable<T, 3>& premultiplied,
                                       const ArrayVariable<T, 2>& coverage,
                                       const ArrayVariable<T, 3>& background, std::size_t top = 0,
                                       std::size_t left = 0) {
  const auto pullback = [c = coverage.shared_value(), b = background.shared_value(), top, left](
                            const Array<T, 3>& picture_adjoint, Array<T, 3>* premultiplied_adjoint,
                            Array<T, 2>* coverage_adjoint, Array<T, 3>* background_adjoint) {
    over_adjoint(*c, *b, picture_adjoint, premultiplied_adjoint, coverage_adjoint, background_adjoint, top,
                 left);
  };
  return record_array(over(premultiplied.value(), coverage.value(), background.value(), top, left), pullback,
                      premultiplied, coverage, background);
}

/// What a picture is laid over: a photograph, and where and how far it is covered. Neither changes.
template <std::floating_point T>
struct Backdrop {
  std::shared_ptr<const Array<T, 3>> background;  ///< [H, W, C]
  std::shared_ptr<const Array<T, 2>> coverage;    ///< [h, w] in [0, 1]
  std::size_t top = 0, left = 0;                  ///< of the coverage's first pixel in the background
};

/// Pictures laid over as many backgrounds of one size, as the batch that a network takes, in one operation.
///
/// \param premultiplied  one [h, w, C] for each backdrop, of the extents of its coverage
/// \returns              [N, H, W, C]
/// \throws ShapeError as over(), or if there are no pictures or not as many as backdrops
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> over(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                                       const std::vector<Backdrop<T>>& backdrops) {
  if (premultiplied.empty() || premultiplied.size() != backdrops.size())
    throw ShapeError("over: " + std::to_string(premultiplied.size()) + " pictures over " +
                     std::to_string(backdrops.size()) + " backdrops");
  const Extents<3> extents = backdrops.front().background->shape();
  const std::size_t size = backdrops.front().background->size();
  std::vector<PixelWindow> places;
  for (std::size_t n = 0; n < backdrops.size(); ++n) {
    require_shape("over", "background", *backdrops[n].background, extents);
    places.push_back(
        detail::place_of("over", *backdrops[n].coverage, extents, backdrops[n].top, backdrops[n].left));
    require_shape("over", "premultiplied", premultiplied[n].value(),
                  {places[n].height, places[n].width, extents[2]});
  }
  Array<T, 4> batch(Extents<4>{backdrops.size(), extents[0], extents[1], extents[2]});
  parallel_for(backdrops.size(), [&](std::size_t n) {
    T* const picture = batch.data() + n * size;
    std::copy_n(backdrops[n].background->data(), size, picture);
    detail::lay_over(premultiplied[n].value().data(), backdrops[n].coverage->data(), places[n], extents,
                     picture);
  });
  const auto pullback = [places, size, extents](const Array<T, 4>& batch_adjoint,
                                                const std::vector<Array<T, 3>*>& premultiplied_adjoints) {
    for (std::size_t n = 0; n < places.size(); ++n) {  // in turn: two may share an adjoint
      if (premultiplied_adjoints[n] == nullptr) continue;
      const T* const from = batch_adjoint.data() + n * size;
      T* const to = premultiplied_adjoints[n]->data();
      detail::for_each_covered_pixel(places[n], extents[1], [&](std::size_t front, std::size_t back) {
        for (std::size_t c = 0; c < extents[2]; ++c)
          to[front * extents[2] + c] += from[back * extents[2] + c];
      });
    }
  };
  return record_array(std::move(batch), pullback, premultiplied);
}

}  // namespace tapestry::image
