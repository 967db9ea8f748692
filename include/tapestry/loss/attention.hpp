#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::loss {
/// Concentration of a heat map; minimised so that a detector's attention is scattered:
///
///   L = 1/P · Σ_p Σ_{i in p} tanh(heat_i) / (H·W + 1 − |p|)
///
/// over the P connected parts of positive heat (joined by their sides); 0 without heat. Smaller parts and
/// less heat make it smaller. The sum is in double. Source: Wang et al., "Dual Attention Suppression Attack"
/// (CVPR 2021), eq. 4 and 5, as in its published program: there on 7 × 7 places, with 50 for H·W + 1.
///
/// \param heat  [H, W]
/// \returns     at least 0; places whose heat is NaN count as without heat
template <std::floating_point T>
[[nodiscard]] T attention(const Array<T, 2>& heat);

/// Adds loss_adjoint · ∂L/∂heat to heat_adjoint, [H, W]; the parts are held fixed, and places without heat
/// have no derivative.
/// \throws ShapeError if heat_adjoint has other extents than heat
template <std::floating_point T>
void attention_adjoint(const Array<T, 2>& heat, T loss_adjoint, Array<T, 2>& heat_adjoint);

/// attention() of a heat map on the active tape; its pullback is attention_adjoint().
///
/// \param heat  [H, W]
template <std::floating_point T>
[[nodiscard]] Variable<T> attention(const ArrayVariable<T, 2>& heat);
}  // namespace tapestry::loss
