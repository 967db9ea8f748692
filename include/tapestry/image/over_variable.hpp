#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/image/over.hpp>
#include <vector>

namespace tapestry::image {

/// over() on the tape, by each of its three arrays.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> over(const ArrayVariable<T, 3>& premultiplied,
                                       const ArrayVariable<T, 2>& coverage,
                                       const ArrayVariable<T, 3>& background, std::size_t top = 0,
                                       std::size_t left = 0, ColourSpace space = ColourSpace::encoded);

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
/// \param space          in which they are added
/// \returns              [N, H, W, C]
/// \throws ShapeError as over(), or if there are no pictures or not as many as backdrops
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> over(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                                       const std::vector<Backdrop<T>>& backdrops,
                                       ColourSpace space = ColourSpace::encoded);

}  // namespace tapestry::image
