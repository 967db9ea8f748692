#pragma once
#include <tapestry/image/over.hpp>

namespace tapestry::image {
namespace detail {
/// Adds the part of a picture, [H, W, C], outside a place to another picture.
template <std::floating_point T>
void add_beside(const PixelWindow& place, const Array<T, 3>& from, Array<T, 3>& to) {
  const auto is_within = [](std::size_t at, std::size_t first, std::size_t count) {
    return at >= first && at - first < count;
  };
  const std::size_t channels = from.shape(2);
  for (std::size_t y = 0; y < from.shape(0); ++y)
    for (std::size_t x = 0; x < from.shape(1); ++x) {
      if (is_within(y, place.top, place.height) && is_within(x, place.left, place.width)) continue;
      for (std::size_t c = 0; c < channels; ++c) to(y, x, c) += from(y, x, c);
    }
}

/// One picture of a batch, and its backdrop.
template <std::floating_point T>
struct Laid {
  std::shared_ptr<const Array<T, 3>> premultiplied, background;
  std::shared_ptr<const Array<T, 2>> coverage;
  PixelWindow place;
};

/// Adds the gradient of the front to front_adjoint, given the adjoint of the whole picture of these extents.
template <std::floating_point T>
void pull_back_laid(const Laid<T>& laid, const T* picture, const T* picture_adjoint,
                    const Extents<3>& extents, ColourSpace space, T* front_adjoint) {
  with_overlay(space, [&](auto overlay) {
    for_each_covered_pixel(laid.place, extents[1], [&](std::size_t front, std::size_t back) {
      const T coverage = laid.coverage->data()[front];
      if (coverage == 0) return;
      for (std::size_t c = 0; c < extents[2]; ++c) {
        const std::size_t i = front * extents[2] + c, j = back * extents[2] + c;
        front_adjoint[i] +=
            overlay.slope(laid.premultiplied->data()[i], coverage, laid.background->data()[j], picture[j]) *
            picture_adjoint[j];
      }
    });
  });
}
}  // namespace detail

template <std::floating_point T>
Array<T, 3> over(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage, const Array<T, 3>& background,
                 std::size_t top, std::size_t left, ColourSpace space) {
  const auto place = detail::place_of("over", coverage, background.shape(), top, left);
  require_shape("over", "premultiplied", premultiplied, {place.height, place.width, background.shape(2)});
  Array<T, 3> picture = background;
  detail::lay_over(premultiplied.data(), coverage.data(), place, background.shape(), space, picture.data());
  return picture;
}

template <std::floating_point T>
void over_adjoint(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage,
                  const Array<T, 3>& background, const Array<T, 3>& picture_adjoint,
                  Array<T, 3>* premultiplied_adjoint, Array<T, 2>* coverage_adjoint,
                  Array<T, 3>* background_adjoint, std::size_t top, std::size_t left, ColourSpace space) {
  const auto place = detail::place_of("over_adjoint", coverage, background.shape(), top, left);
  const std::size_t channels = background.shape(2);
  require_shape("over_adjoint", "premultiplied", premultiplied, {place.height, place.width, channels});
  require_shape("over_adjoint", "picture_adjoint", picture_adjoint, background.shape());
  if (premultiplied_adjoint != nullptr)
    require_shape("over_adjoint", "premultiplied_adjoint", *premultiplied_adjoint, premultiplied.shape());
  if (coverage_adjoint != nullptr)
    require_shape("over_adjoint", "coverage_adjoint", *coverage_adjoint, coverage.shape());
  if (background_adjoint != nullptr) {
    require_shape("over_adjoint", "background_adjoint", *background_adjoint, background.shape());
    detail::add_beside(place, picture_adjoint, *background_adjoint);
  }
  detail::with_overlay(space, [&](auto overlay) {
    detail::for_each_covered_pixel(place, background.shape(1), [&](std::size_t front, std::size_t back) {
      for (std::size_t c = 0; c < channels; ++c) {
        const std::size_t i = front * channels + c, j = back * channels + c;
        const T p = premultiplied.data()[i], covered = coverage.data()[front], behind = background.data()[j];
        const auto slopes = overlay.slopes(p, covered, behind, overlay.value(p, covered, behind));
        const T adjoint = picture_adjoint.data()[j];
        if (premultiplied_adjoint != nullptr)
          premultiplied_adjoint->data()[i] += slopes.by_premultiplied * adjoint;
        if (coverage_adjoint != nullptr) coverage_adjoint->data()[front] += slopes.by_coverage * adjoint;
        if (background_adjoint != nullptr) background_adjoint->data()[j] += slopes.by_background * adjoint;
      }
    });
  });
}

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

template <std::floating_point T>
ArrayVariable<T, 4> over(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                         const std::vector<Backdrop<T>>& backdrops, ColourSpace space) {
  if (premultiplied.empty() || premultiplied.size() != backdrops.size())
    throw ShapeError({"over: ", premultiplied.size(), " pictures over ", backdrops.size(), " backdrops"});
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
    for (std::size_t n = 0; n < all.size(); ++n)  // one by one: two may share an adjoint
      if (premultiplied_adjoints[n] != nullptr)
        detail::pull_back_laid(all[n], batch->data() + n * size, batch_adjoint.data() + n * size, extents,
                               space, premultiplied_adjoints[n]->data());
  };
  return record_array(std::shared_ptr<const Array<T, 4>>(batch), pullback, premultiplied);
}

namespace detail {
/// Slopes of a picture laid over a backdrop by its values, and of its tangent ("bend").
template <std::floating_point T>
struct TangentOver {
  PixelWindow place;
  Array<T, 3> slope, bend;

  TangentOver(const Backdrop<T>& backdrop, const Array<T, 3>& at, const Array<T, 3>& along, ColourSpace space)
      : place(
            place_of("over", *backdrop.coverage, backdrop.background->shape(), backdrop.top, backdrop.left)),
        slope(zeros<T, 3>(at.shape())),
        bend(zeros<T, 3>(at.shape())) {
    with_overlay(space, [&](auto overlay) {
      for_each_element(*backdrop.background, [&](std::size_t i, std::size_t j) {
        const T covered = backdrop.coverage->data()[i / at.shape(2)], behind = backdrop.background->data()[j];
        if (covered == 0) return;
        const T p = at.data()[i];
        slope.data()[i] = overlay.slope(p, covered, behind, overlay.value(p, covered, behind));
        bend.data()[i] = overlay.curvature(p, covered, behind, slope.data()[i]) * along.data()[i];
      });
    });
  }
  /// Calls visit(element of the front, element of the picture) for a picture [H, W, C] of this size.
  template <class Visit>
  void for_each_element(const Array<T, 3>& picture, Visit visit) const {
    for_each_covered_pixel(place, picture.shape(1), [&, c = picture.shape(2)](std::size_t i, std::size_t j) {
      for (std::size_t channel = 0; channel < c; ++channel) visit(i * c + channel, j * c + channel);
    });
  }
};
}  // namespace detail

template <std::floating_point T>
ArrayVariable<T, 4> over_tangent(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                                 const std::vector<ArrayVariable<T, 3>>& tangents,
                                 const std::vector<Backdrop<T>>& backdrops, ColourSpace space) {
  const auto photo = backdrops.front().background;
  auto batch = zeros<T, 4>({backdrops.size(), photo->shape(0), photo->shape(1), photo->shape(2)});
  std::vector<detail::TangentOver<T>> views;
  for (std::size_t n = 0; n < backdrops.size(); ++n) {
    const Array<T, 3>& along = tangents[n].value();
    views.emplace_back(backdrops[n], premultiplied[n].value(), along, space);
    views[n].for_each_element(*photo,
                              [&, to = batch.data() + n * photo->size()](std::size_t i, std::size_t j) {
                                to[j] = views[n].slope.data()[i] * along.data()[i];
                              });
  }
  const auto pullback = [views = std::move(views), photo](const Array<T, 4>& adjoint,
                                                          const std::vector<Array<T, 3>*>& of_pictures,
                                                          const std::vector<Array<T, 3>*>& of_tangents) {
    for (std::size_t n = 0; n < views.size(); ++n)
      views[n].for_each_element(*photo,
                                [&, g = adjoint.data() + n * photo->size()](std::size_t i, std::size_t j) {
                                  if (of_pictures[n] != nullptr)
                                    of_pictures[n]->data()[i] += views[n].bend.data()[i] * g[j];
                                  if (of_tangents[n] != nullptr)
                                    of_tangents[n]->data()[i] += views[n].slope.data()[i] * g[j];
                                });
  };
  return record_array(std::move(batch), pullback, premultiplied, tangents);
}
}  // namespace tapestry::image
