#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <vector>

namespace tapestry::raster {

/// The picture of a texture on the active tape; its pullback is render_adjoint(). A passive texture records
/// nothing.
///
/// \param picture  must outlive the tape's last reverse(), unchanged
/// \param texels   [texel_count, 3]
/// \returns        [H, W, 3], colour times coverage, row 0 on top
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> render(const TextureOperator<T>& picture,
                                         const ArrayVariable<T, 2>& texels);

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
    const ArrayVariable<T, 2>& texels);

}  // namespace tapestry::raster
