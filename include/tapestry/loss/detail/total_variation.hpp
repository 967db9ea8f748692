#pragma once
#include <cmath>
#include <concepts>
#include <memory>
#include <string>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/loss/detail/neighbour_steps.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {
/// φ(s) = √(s² + ε²) − ε, as s² / (√(s² + ε²) + ε), which keeps its digits where s is much smaller than ε.
struct AbsoluteStep {
  double epsilon;
  [[nodiscard]] double value(double step) const {
    return step == 0 ? 0 : step * step / (std::hypot(step, epsilon) + epsilon);
  }
  [[nodiscard]] double slope(double step) const { return step == 0 ? 0 : step / std::hypot(step, epsilon); }
};

/// \throws DomainError unless ε is a number from 0 on
inline AbsoluteStep absolute_step(const char* operation, double epsilon) {
  if (std::isfinite(epsilon) && epsilon >= 0) return {epsilon};
  throw DomainError({operation, ": epsilon is ", epsilon, ", expected a finite number of at least 0"});
}
}  // namespace detail

/// Step at which the penalty turns from square to length: a quarter of an 8-bit grey level.
inline constexpr double total_variation_epsilon = 1e-3;

/// Anisotropic total variation: the lengths of the colour steps between neighbouring pixels, counted inside
/// the vehicle mask. Flat areas with sharp borders cost less than under smoothness(), which squares.
///
///   L = Σ M[y,x] · (φ(O[y+1,x,c] − O[y,x,c]) + φ(O[y,x+1,c] − O[y,x,c])),   φ(s) = √(s² + ε²) − ε
///
/// over y < H−1, x < W−1 and all c. φ is |s| to within ε, and s² / 2ε for steps well below ε. With ε = 0 it
/// is |s|, whose derivative at 0 is taken as 0. Pixels outside M are read only where a step from inside M
/// ends on them.
/// Sources: Rudin, Osher and Fatemi, "Nonlinear total variation based noise removal algorithms" (Physica D
/// 60, 1992), there isotropic, and Esedoglu and Osher (Comm. Pure Appl. Math. 57, 2004), anisotropic; φ:
/// Charbonnier et al., "Two deterministic half-quadratic regularization algorithms" (ICIP 1994).
///
/// \param render   O, [H, W, C], colour in [0, 1], row 0 at the top
/// \param mask     M, [H, W], 1 on the vehicle and 0 elsewhere
/// \param epsilon  ε in colour units, 0 or more
/// \returns        L in colour units, summed in double
/// \throws ShapeError if mask is not [H, W]; DomainError if epsilon is below 0 or not finite
template <Image Render, Mask VehicleMask>
[[nodiscard]] auto total_variation(const Render& render, const VehicleMask& mask,
                                   double epsilon = total_variation_epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return static_cast<typename Render::value_type>(
      detail::picture_steps("total_variation", penalty, render, mask));
}

/// Adds loss_adjoint · ∂L/∂O to render_adjoint, [H, W, C]; arguments otherwise as in total_variation().
template <Image Render, Mask VehicleMask>
void total_variation_adjoint(const Render& render, const VehicleMask& mask, double epsilon,
                             typename Render::value_type loss_adjoint, Render& render_adjoint) {
  const auto penalty = detail::absolute_step("total_variation_adjoint", epsilon);
  detail::picture_steps_adjoint("total_variation_adjoint", penalty, render, mask,
                                static_cast<double>(loss_adjoint), render_adjoint);
}

/// total_variation() of a texture: the lengths of the steps between neighbouring texels of an atlas that are
/// both in use, as atlas_smoothness() counts them.
///
/// \param texels   [H·W, channel], row by row from the top, colour in [0, 1]
/// \param used     [H, W], 1 where a painted face refers to the texel and 0 elsewhere
/// \param epsilon  ε in colour units, 0 or more
/// \throws ShapeError if texels has not H·W rows; DomainError if epsilon is below 0 or not finite
template <Mask Texels, Mask UsedTexels>
[[nodiscard]] auto atlas_total_variation(const Texels& texels, const UsedTexels& used,
                                         double epsilon = total_variation_epsilon) {
  const auto penalty = detail::absolute_step("atlas_total_variation", epsilon);
  return static_cast<typename Texels::value_type>(
      detail::atlas_steps("atlas_total_variation", penalty, texels, used));
}

/// Adds loss_adjoint · ∂L/∂texels to texels_adjoint; arguments otherwise as in atlas_total_variation().
template <Mask Texels, Mask UsedTexels>
void atlas_total_variation_adjoint(const Texels& texels, const UsedTexels& used, double epsilon,
                                   typename Texels::value_type loss_adjoint, Texels& texels_adjoint) {
  const auto penalty = detail::absolute_step("atlas_total_variation_adjoint", epsilon);
  detail::atlas_steps_adjoint("atlas_total_variation_adjoint", penalty, texels, used,
                              static_cast<double>(loss_adjoint), texels_adjoint);
}

/// total_variation() of a picture on the active tape; its pullback is total_variation_adjoint(). Arguments as
/// in smoothness() on the tape, errors as there and in total_variation().
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const ArrayVariable<T, 3>& picture, Array<T, 2> mask,
                                          double epsilon = total_variation_epsilon);

/// The sum over several pictures as one record.
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const std::vector<ArrayVariable<T, 3>>& pictures,
                                          SharedMasks<T> masks, double epsilon = total_variation_epsilon);

/// atlas_total_variation() of a texture on the active tape.
template <std::floating_point T>
[[nodiscard]] Variable<T> atlas_total_variation(const ArrayVariable<T, 2>& texels,
                                                std::shared_ptr<const Array<T, 2>> used,
                                                double epsilon = total_variation_epsilon);

}  // namespace tapestry::loss
