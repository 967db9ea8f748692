#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>

/// Layers of whole pictures, with their derivatives. camouflage::compose() does in one pass what over() with
/// m·P and m·c would do in three, inside the car's window and on planes, and so does not call them.
namespace tapestry::image {
namespace detail {

/// Calls visit(pixel) for 0 … count − 1 from several threads.
template <class Visit>
void for_each_pixel(std::size_t count, Visit visit) {
  constexpr std::size_t block = 16384;
  parallel_for(block_count(count, block), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, count, block);
    for (std::size_t pixel = begin; pixel < end; ++pixel) visit(pixel);
  });
}

template <class T>
void require_layers(const char* operation, const Array<T, 3>& front, const Array<T, 2>& mask,
                    const Array<T, 3>& background) {
  require_shape(operation, "background", background, front.shape());
  require_shape(operation, "mask", mask, {front.shape(0), front.shape(1)});
}

}  // namespace detail

/// A picture that is already multiplied by its coverage, laid over a background:
///   out = premultiplied + (1 − coverage) · background.
///
/// \param premultiplied  [H, W, C]
/// \param coverage       [H, W] in [0, 1]
/// \param background     [H, W, C]
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 3> over(const Array<T, 3>& premultiplied, const Array<T, 2>& coverage,
                               const Array<T, 3>& background) {
  detail::require_layers("over", premultiplied, coverage, background);
  const std::size_t channels = premultiplied.shape(2);
  Array<T, 3> picture(premultiplied.shape());
  const T *const front = premultiplied.data(), *const back = background.data(), *const mask = coverage.data();
  T* const out = picture.data();
  detail::for_each_pixel(coverage.size(), [=](std::size_t pixel) {
    for (std::size_t i = pixel * channels; i < (pixel + 1) * channels; ++i) {
      out[i] = front[i] + (1 - mask[pixel]) * back[i];
    }
  });
  return picture;
}

/// Adds the derivatives of over(); a null pointer stands for an argument that needs none.
///
/// \param picture_adjoint  [H, W, C]; the adjoints have the extents of their arguments
/// \throws ShapeError if the extents differ
template <std::floating_point T>
void over_adjoint(const Array<T, 2>& coverage, const Array<T, 3>& background,
                  const Array<T, 3>& picture_adjoint, Array<T, 3>* premultiplied_adjoint,
                  Array<T, 2>* coverage_adjoint, Array<T, 3>* background_adjoint) {
  detail::require_layers("over_adjoint", picture_adjoint, coverage, background);
  if (premultiplied_adjoint != nullptr)
    require_shape("over_adjoint", "premultiplied_adjoint", *premultiplied_adjoint, background.shape());
  if (coverage_adjoint != nullptr)
    require_shape("over_adjoint", "coverage_adjoint", *coverage_adjoint, coverage.shape());
  if (background_adjoint != nullptr)
    require_shape("over_adjoint", "background_adjoint", *background_adjoint, background.shape());
  const std::size_t channels = background.shape(2);
  detail::for_each_pixel(coverage.size(), [&](std::size_t pixel) {
    const T mask = coverage.data()[pixel];
    for (std::size_t i = pixel * channels; i < (pixel + 1) * channels; ++i) {
      const T adjoint = picture_adjoint.data()[i];
      if (premultiplied_adjoint != nullptr) premultiplied_adjoint->data()[i] += adjoint;
      if (coverage_adjoint != nullptr) coverage_adjoint->data()[pixel] -= adjoint * background.data()[i];
      if (background_adjoint != nullptr) background_adjoint->data()[i] += (1 - mask) * adjoint;
    }
  });
}

/// The paper's composite I_adv = m·O + (1 − m)·I.
///
/// Source: Wang et al., FCA (AAAI 2022), eq. 2.
///
/// \param render      O, [H, W, C], not multiplied by its coverage
/// \param mask        m, [H, W] in [0, 1]
/// \param background  I, [H, W, C]
/// \throws ShapeError if the extents differ
template <std::floating_point T>
[[nodiscard]] Array<T, 3> composite(const Array<T, 3>& render, const Array<T, 2>& mask,
                                    const Array<T, 3>& background) {
  detail::require_layers("composite", render, mask, background);
  const std::size_t channels = render.shape(2);
  Array<T, 3> picture(render.shape());
  const T *const front = render.data(), *const back = background.data(), *const m = mask.data();
  T* const out = picture.data();
  detail::for_each_pixel(mask.size(), [=](std::size_t pixel) {
    for (std::size_t i = pixel * channels; i < (pixel + 1) * channels; ++i) {
      out[i] = m[pixel] * front[i] + (1 - m[pixel]) * back[i];
    }
  });
  return picture;
}

/// Adds the derivatives of composite(); a null pointer stands for an argument that needs none.
///
/// \param picture_adjoint  [H, W, C]; the adjoints have the extents of their arguments
/// \throws ShapeError if the extents differ
template <std::floating_point T>
void composite_adjoint(const Array<T, 3>& render, const Array<T, 2>& mask, const Array<T, 3>& background,
                       const Array<T, 3>& picture_adjoint, Array<T, 3>* render_adjoint,
                       Array<T, 2>* mask_adjoint, Array<T, 3>* background_adjoint) {
  detail::require_layers("composite_adjoint", render, mask, background);
  require_shape("composite_adjoint", "picture_adjoint", picture_adjoint, render.shape());
  if (render_adjoint != nullptr)
    require_shape("composite_adjoint", "render_adjoint", *render_adjoint, render.shape());
  if (mask_adjoint != nullptr)
    require_shape("composite_adjoint", "mask_adjoint", *mask_adjoint, mask.shape());
  if (background_adjoint != nullptr)
    require_shape("composite_adjoint", "background_adjoint", *background_adjoint, render.shape());
  const std::size_t channels = render.shape(2);
  detail::for_each_pixel(mask.size(), [&](std::size_t pixel) {
    const T m = mask.data()[pixel];
    for (std::size_t i = pixel * channels; i < (pixel + 1) * channels; ++i) {
      const T adjoint = picture_adjoint.data()[i];
      if (render_adjoint != nullptr) render_adjoint->data()[i] += m * adjoint;
      if (mask_adjoint != nullptr)
        mask_adjoint->data()[pixel] += adjoint * (render.data()[i] - background.data()[i]);
      if (background_adjoint != nullptr) background_adjoint->data()[i] += (1 - m) * adjoint;
    }
  });
}

}  // namespace tapestry::image
