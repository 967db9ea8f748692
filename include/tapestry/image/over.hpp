#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <tapestry/image/pixel_window.hpp>

/// A picture that is multiplied by its coverage, laid over a background of the same or a larger size:
///
///   out = premultiplied + (1 − coverage) · background   inside the picture's place,   background beside it.
///
/// In ColourSpace::linear this is a sum of light. `premultiplied` is then linear, while `background` and
/// `out` remain encoded. The uncovered background is unchanged, bit for bit.
///
/// Source: Porter and Duff, "Compositing digital images" (1984). With premultiplied = m·O and coverage = m it
/// is the composite of Wang et al., FCA (AAAI 2022), eq. 6.
namespace tapestry::image {
namespace detail {
/// Calls visit(pixel of the front, pixel of the background) for all pixels of the front, from several
/// threads.
template <class Visit>
void for_each_covered_pixel(const PixelWindow& place, std::size_t background_width, Visit visit) {
  constexpr std::size_t rows = 16;
  parallel_for_blocks(place.height, rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      const std::size_t front = y * place.width;
      const std::size_t back = (place.top + y) * background_width + place.left;
      for (std::size_t x = 0; x < place.width; ++x) visit(front + x, back + x);
    }
  });
}

template <std::floating_point T>
PixelWindow place_of(const char* operation, const Array<T, 2>& coverage, const Extents<3>& background,
                     std::size_t top, std::size_t left) {
  const PixelWindow place{top, left, coverage.shape(0), coverage.shape(1)};
  require_window(operation, place, background[0], background[1]);
  return place;
}

/// Composition of one value over another in a colour space, and its slopes.
template <ColourSpace Space>
struct Overlay {
  static constexpr bool is_linear = Space == ColourSpace::linear;

  template <std::floating_point T>
  struct Slopes {
    T by_premultiplied, by_coverage, by_background;
  };

  template <std::floating_point T>
  static T value(T premultiplied, T coverage, T background) {
    const T shows = 1 - coverage;
    if constexpr (!is_linear) return premultiplied + shows * background;
    if (coverage == 0 && premultiplied == 0) return background;
    return encoded(light(premultiplied, shows, background));
  }

  /// \param out  value() of the others
  template <std::floating_point T>
  static Slopes<T> slopes(T premultiplied, T coverage, T background, T out) {
    const T shows = 1 - coverage;
    if constexpr (!is_linear) return {1, -background, shows};
    const T behind = linearised(background);
    const T slope = by_light(premultiplied, shows, background, out);
    return {slope, -slope * behind, slope * shows * linearised_slope(background, behind)};
  }

  /// by_premultiplied alone; it needs no power for a wholly covered pixel.
  template <std::floating_point T>
  static T slope(T premultiplied, T coverage, T background, T out) {
    if constexpr (!is_linear) return 1;
    return by_light(premultiplied, 1 - coverage, background, out);
  }

  /// The derivative of slope() by the premultiplied value, given slope().
  template <std::floating_point T>
  static T curvature(T premultiplied, T coverage, T background, T slope) {
    if constexpr (!is_linear) return 0;
    const T sum = light(premultiplied, 1 - coverage, background);
    return sum <= T(crossing_linear) ? T(0) : (1 / T(2.4) - 1) * slope / sum;
  }

 private:
  /// Most pixels are covered wholly; for them the background is not read.
  template <std::floating_point T>
  static T light(T premultiplied, T shows, T background) {
    return shows == 0 ? premultiplied : premultiplied + shows * linearised(background);
  }
  template <std::floating_point T>
  static T by_light(T premultiplied, T shows, T background, T out) {
    return encoded_slope(light(premultiplied, shows, background), out);
  }
};

/// Calls a function with the overlay of a space.
template <class Use>
void with_overlay(ColourSpace space, Use use) {
  if (space == ColourSpace::linear) return use(Overlay<ColourSpace::linear>{});
  use(Overlay<ColourSpace::encoded>{});
}

/// over() in place: `picture`, [H, W, C], holds the background.
template <std::floating_point T>
void lay_over(const T* premultiplied, const T* coverage, const PixelWindow& place, const Extents<3>& extents,
              ColourSpace space, T* picture) {
  const std::size_t channels = extents[2];
  with_overlay(space, [&](auto overlay) {
    for_each_covered_pixel(place, extents[1], [=](std::size_t front, std::size_t back) {
      for (std::size_t c = 0; c < channels; ++c) {
        T& value = picture[back * channels + c];
        value = overlay.value(premultiplied[front * channels + c], coverage[front], value);
      }
    });
  });
}
}  // namespace detail

/// \param premultiplied  [h, w, C]
/// \param coverage       [h, w] in [0, 1]
/// \param background     [H, W, C]
/// \param top, left      where the front's first pixel lies in the background
/// \param space where the two are added
/// \returns              [H, W, C]
/// \throws ShapeError if extents do not fit or the front leaves the background
template <std::floating_point T>
[[nodiscard]] Array<T, 3> over(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage,
                               const Array<T, 3>& background, std::size_t top = 0, std::size_t left = 0,
                               ColourSpace space = ColourSpace::encoded);

/// Adds the derivatives of over(); a null pointer stands for an argument that needs none.
///
/// \param picture_adjoint  [H, W, C]; the adjoints have the extents of their arguments
/// \throws ShapeError as over()
template <std::floating_point T>
void over_adjoint(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage,
                  const Array<T, 3>& background, const Array<T, 3>& picture_adjoint,
                  Array<T, 3>* premultiplied_adjoint, Array<T, 2>* coverage_adjoint,
                  Array<T, 3>* background_adjoint, std::size_t top = 0, std::size_t left = 0,
                  ColourSpace space = ColourSpace::encoded);

/// over() on the tape, differentiable by its three arrays.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> over(const ArrayVariable<T, 3>& premultiplied,
                                       const ArrayVariable<T, 2>& coverage,
                                       const ArrayVariable<T, 3>& background, std::size_t top = 0,
                                       std::size_t left = 0, ColourSpace space = ColourSpace::encoded);

/// The same on a tape of duals. In linear space it adds light, and encodes the sum.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 3> over(const ArrayVariable<D, 3>& premultiplied,
                                       const ArrayVariable<D, 2>& coverage,
                                       const ArrayVariable<D, 3>& background, std::size_t top = 0,
                                       std::size_t left = 0, ColourSpace space = ColourSpace::encoded) {
  if (space == ColourSpace::linear)
    return encoded(over(premultiplied, coverage, linearised(background), top, left));
  const auto blend = [=]<class P, class C>(const P& p, const C& c, const P& b, const P& p_along,
                                           const C& c_along, const P& b_along) {
    const P none(zeros<typename P::value_type, 3>(p.shape()));
    return std::pair(over(p, c, b, top, left),
                     P(over(p_along, c, b_along, top, left) + over(none, c_along, b, top, left) - b));
  };
  return record_tangent(blend, premultiplied, coverage, background);
}

/// Background and coverage to lay a picture over; both are constant. Made of plain arrays, or of a
/// photograph and a rendered view:
///
///   const image::Backdrop backdrop(image::from_bytes<float>(frame.image), view);
template <std::floating_point T>
struct Backdrop {
  std::shared_ptr<const Array<T, 3>> background{};  ///< [H, W, C]
  std::shared_ptr<const Array<T, 2>> coverage{};    ///< [h, w] in [0, 1]
  std::size_t top = 0, left = 0;                    ///< of the coverage's first pixel in the background

  Backdrop() = default;
  Backdrop(std::shared_ptr<const Array<T, 3>> background_of, std::shared_ptr<const Array<T, 2>> coverage_of,
           std::size_t top_px = 0, std::size_t left_px = 0)
      : background(std::move(background_of)), coverage(std::move(coverage_of)), top(top_px), left(left_px) {}

  /// \param photo      [H, W, C], encoded, RGB in [0, 1]
  /// \param covered    [h, w] in [0, 1]
  Backdrop(Array<T, 3> photo, Array<T, 2> covered, std::size_t top_px = 0, std::size_t left_px = 0)
      : Backdrop(std::make_shared<const Array<T, 3>>(std::move(photo)),
                 std::make_shared<const Array<T, 2>>(std::move(covered)), top_px, left_px) {}

  /// \param view  a rendered view with its `coverage`, such as raster::TextureOperator, kept alive and not
  ///              copied
  template <class RenderedView>
  requires std::same_as<decltype(RenderedView::coverage), Array<T, 2>> Backdrop(
      Array<T, 3> photo, const std::shared_ptr<const RenderedView>& view, std::size_t top_px = 0,
      std::size_t left_px = 0)
      : Backdrop(std::make_shared<const Array<T, 3>>(std::move(photo)), {view, &view->coverage}, top_px,
                 left_px) {}
};

/// Lays pictures over as many backgrounds of one size, as the batch that a network takes, in one operation.
/// Pixels of coverage 0 hold no picture: their adjoint is 0.
///
/// \param premultiplied  one [h, w, C] for each backdrop, of the extents of its coverage
/// \param space where they are added
/// \returns              [N, H, W, C]
/// \throws ShapeError as over(), or if there are no pictures or another number of backdrops
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> over(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                                       const std::vector<Backdrop<T>>& backdrops,
                                       ColourSpace space = ColourSpace::encoded);
/// Tangents of over() of a batch, of these tangents of the pictures, as one operation; 0 beside the pictures.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> over_tangent(const std::vector<ArrayVariable<T, 3>>& premultiplied,
                                               const std::vector<ArrayVariable<T, 3>>& tangents,
                                               const std::vector<Backdrop<T>>& backdrops, ColourSpace space);

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 4> over(const std::vector<ArrayVariable<D, 3>>& premultiplied,
                                       const std::vector<Backdrop<typename D::value_type>>& backdrops,
                                       ColourSpace space = ColourSpace::encoded) {
  const auto lay = [&](const auto& pictures, const auto& along) {
    return std::pair(over(pictures, backdrops, space), over_tangent(pictures, along, backdrops, space));
  };
  return record_tangent(lay, premultiplied);
}
}  // namespace tapestry::image
