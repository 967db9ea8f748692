#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/image/over_variable.hpp>
#include <vector>

namespace tapestry::image {

template <std::floating_point T>
ArrayVariable<T, 3> over(const ArrayVariable<T, 3>& premultiplied, const ArrayVariable<T, 2>& coverage,
                         const ArrayVariable<T, 3>& background, std::size_t top, std::size_t left,
                         ColourSpace space) {
  const auto pullback = [p = premultiplied.shared_value(), c = coverage.shared_value(),
                         b = background.shared_value(), top, left,
                         space](const Array<T, 3>& picture_adjoint, Array<T, 3>* premultiplied_adjoint,
                                Array<T, 2>* coverage_adjoint, Array<T, 3>* background_adjoint) {
    over_adjoint(*p, *c, *b, picture_adjoint, premultiplied_adjoint, coverage_adjoint, background_adjoint,
                 top, left, space);
  };
  return record_array(over(premultiplied.value(), coverage.value(), background.value(), top, left, space),
                      pullback, premultiplied, coverage, background);
}

}  // namespace tapestry::image

namespace tapestry::image::detail {

/// One picture of a batch, and what it lies over.
template <class T>
struct Laid {
  std::shared_ptr<const Array<T, 3>> premultiplied, background;
  std::shared_ptr<const Array<T, 2>> coverage;
  PixelWindow place;
};

/// Adds to the adjoint of the front what that of the whole picture, of these extents, says.
template <class T>
void pull_back_laid(const Laid<T>& laid, const T* picture, const T* picture_adjoint,
                    const Extents<3>& extents, ColourSpace space, T* front_adjoint) {
  with_overlay(space, [&](auto overlay) {
    for_each_covered_pixel(laid.place, extents[1], [&](std::size_t front, std::size_t back) {
      for (std::size_t c = 0; c < extents[2]; ++c) {
        const std::size_t i = front * extents[2] + c, j = back * extents[2] + c;
        front_adjoint[i] += overlay.slope(laid.premultiplied->data()[i], laid.coverage->data()[front],
                                          laid.background->data()[j], picture[j]) *
                            picture_adjoint[j];
      }
    });
  });
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

template <std::floating_point T>
ArrayVariable<T, 4> over(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                         const std::vector<Backdrop<T>>& backdrops, ColourSpace space) {
  if (premultiplied.empty() || premultiplied.size() != backdrops.size())
    throw ShapeError("over: " + std::to_string(premultiplied.size()) + " pictures over " +
                     std::to_string(backdrops.size()) + " backdrops");
  const Extents<3> extents = backdrops.front().background->shape();
  const std::size_t size = backdrops.front().background->size();
  std::vector<detail::Laid<T>> all;
  for (std::size_t n = 0; n < backdrops.size(); ++n) {
    const auto& [background, coverage, top, left] = backdrops[n];
    require_shape("over", "background", *background, extents);
    const auto place = detail::place_of("over", *coverage, extents, top, left);
    require_shape("over", "premultiplied", premultiplied[n].value(), {place.height, place.width, extents[2]});
    all.push_back({premultiplied[n].shared_value(), background, coverage, place});
  }
  auto batch =
      std::make_shared<Array<T, 4>>(Extents<4>{backdrops.size(), extents[0], extents[1], extents[2]});
  parallel_for(all.size(), [&](std::size_t n) {
    T* const picture = batch->data() + n * size;
    std::copy_n(all[n].background->data(), size, picture);
    detail::lay_over(all[n].premultiplied->data(), all[n].coverage->data(), all[n].place, extents, space,
                     picture);
  });
  const auto pullback = [all, batch, size, extents, space](
                            const Array<T, 4>& batch_adjoint,
                            const std::vector<Array<T, 3>*>& premultiplied_adjoints) {
    for (std::size_t n = 0; n < all.size(); ++n)  // in turn: two may share an adjoint
      if (premultiplied_adjoints[n] != nullptr)
        detail::pull_back_laid(all[n], batch->data() + n * size, batch_adjoint.data() + n * size, extents,
                               space, premultiplied_adjoints[n]->data());
  };
  return record_array(std::shared_ptr<const Array<T, 4>>(batch), pullback, premultiplied);
}

template ArrayVariable<float, 3> over<float>(const ArrayVariable<float, 3>& premultiplied,
                                             const ArrayVariable<float, 2>& coverage,
                                             const ArrayVariable<float, 3>& background, std::size_t top,
                                             std::size_t left, ColourSpace space);
template ArrayVariable<double, 3> over<double>(const ArrayVariable<double, 3>& premultiplied,
                                               const ArrayVariable<double, 2>& coverage,
                                               const ArrayVariable<double, 3>& background, std::size_t top,
                                               std::size_t left, ColourSpace space);
template ArrayVariable<float, 4> over<float>(const std::vector<ArrayVariable<float, 3>>& premultiplied,
                                             const std::vector<Backdrop<float>>& backdrops,
                                             ColourSpace space);
template ArrayVariable<double, 4> over<double>(const std::vector<ArrayVariable<double, 3>>& premultiplied,
                                               const std::vector<Backdrop<double>>& backdrops,
                                               ColourSpace space);

}  // namespace tapestry::image
