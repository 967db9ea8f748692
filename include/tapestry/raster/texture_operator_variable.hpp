#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster {
namespace detail {
/// Adds every view's render_adjoint(), in the order of views; those without an adjoint add nothing. A small
/// texture gets a part a view, so that views are independent of one another.
template <class T>
void add_render_adjoints(const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
                         const std::vector<const Array<T, 3>*>& render_adjoints,
                         Array<T, 2>& texels_adjoint) {
  constexpr std::size_t small_texture = 1U << 18U;  // values
  if (texels_adjoint.size() > small_texture) {
    for (std::size_t n = 0; n < pictures.size(); ++n)
      if (render_adjoints[n] != nullptr) render_adjoint(*pictures[n], *render_adjoints[n], texels_adjoint);
    return;
  }
  std::vector<Array<T, 2>> parts(pictures.size());
  parallel_for(pictures.size(), [&](std::size_t n) {
    if (render_adjoints[n] == nullptr) return;
    parts[n] = zeros<T, 2>(texels_adjoint.shape());
    render_adjoint(*pictures[n], *render_adjoints[n], parts[n]);
  });
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.size(); ++i) texels_adjoint.data()[i] += part.data()[i];
}
}  // namespace detail

/// The picture of a texture on the active tape; its pullback is render_adjoint(). A passive texture records
/// nothing.
///
/// \param picture  must outlive the tape's last reverse(), unchanged
/// \param texels   [texel_count, 3]
/// \returns        [H, W, 3], colour times coverage, row 0 on top
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> render(const TextureOperator<T>& picture,
                                         const ArrayVariable<T, 2>& texels) {
  const auto pullback = [&picture](const Array<T, 3>& adjoint, Array<T, 2>* texels_adjoint) {
    render_adjoint(picture, adjoint, *texels_adjoint);
  };
  return record_array(render(picture, texels.value()), pullback, texels);
}

template <std::floating_point T>
void render(const TextureOperator<T>&&, const ArrayVariable<T, 2>&) = delete;  // it would be gone

/// The pictures of a texture in several views, as one record on the active tape. Views are rendered and
/// pulled back side by side; their adjoints are summed in the order of views, so the result has the same bits
/// for any number of threads.
///
/// \param pictures  the views, which may differ in size; the tape keeps them alive
/// \param texels    [texel_count, 3]
/// \returns         of each view [H, W, 3], colour times coverage
/// \throws ShapeError if texels does not fit one of the operators
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 3>> render(
    const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
    const ArrayVariable<T, 2>& texels) {
  std::vector<Array<T, 3>> values(pictures.size());
  parallel_for(values.size(), [&](std::size_t n) { values[n] = render(*pictures[n], texels.value()); });
  const auto pullback = [pictures](const std::vector<const Array<T, 3>*>& adjoints,
                                   Array<T, 2>* texels_adjoint) {
    detail::add_render_adjoints(pictures, adjoints, *texels_adjoint);
  };
  return record_arrays<T, 3>(std::move(values), pullback, texels);
}

}  // namespace tapestry::raster
