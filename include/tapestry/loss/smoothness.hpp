#pragma once
#include <cstddef>
#include <tapestry/core/array.hpp>  // Image, Mask
#include <tapestry/core/check.hpp>  // require_shape, ShapeError
#include <tapestry/core/parallel.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {

/// How much the two steps that leave texel or pixel (y, x) count.
struct StepWeights {
  double down;
  double right;
};

/// The image rule: both steps weigh as much as the pixel they leave; the last row and column start none.
template <class T>
struct PixelSteps {
  const T* mask;
  std::size_t height, width;

  [[nodiscard]] StepWeights operator()(std::size_t y, std::size_t x) const {
    if (y + 1 >= height || x + 1 >= width) return {0, 0};
    const auto weight = static_cast<double>(mask[y * width + x]);
    return {weight, weight};
  }
};

/// The atlas rule: a step counts when both texels are used, wherever they lie.
template <class T>
struct TexelSteps {
  const T* mask;
  std::size_t height, width;

  [[nodiscard]] StepWeights operator()(std::size_t y, std::size_t x) const {
    const T* here = mask + y * width + x;
    return {y + 1 < height ? static_cast<double>(here[0] * here[width]) : 0,
            x + 1 < width ? static_cast<double>(here[0] * here[1]) : 0};
  }
};

/// Σ over all values of weight · step², in double: rows in parallel, their sums added from the top.
template <class Steps, class T>
double weighted_steps(const Steps& steps, const T* colour, std::size_t channels) {
  std::vector<double> row_sums(steps.height, 0.0);
  parallel_for(steps.height, [&](std::size_t y) {
    double sum = 0;
    for (std::size_t x = 0; x < steps.width; ++x) {
      const StepWeights weights = steps(y, x);
      if (weights.down == 0 && weights.right == 0) continue;
      const T* here = colour + (y * steps.width + x) * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        const auto value = static_cast<double>(here[c]);
        const double down =
            weights.down == 0 ? 0 : static_cast<double>(here[steps.width * channels + c]) - value;
        const double right = weights.right == 0 ? 0 : static_cast<double>(here[channels + c]) - value;
        sum += weights.down * down * down + weights.right * right * right;
      }
    }
    row_sums[y] = sum;
  });
  double total = 0;
  for (const double sum : row_sums) total += sum;
  return total;
}

/// Adds the derivative of weighted_steps() times loss_adjoint. Every value gathers from its four steps,
/// so that rows are independent of one another.
template <class Steps, class T>
void weighted_steps_adjoint(const Steps& steps, const T* colour, std::size_t channels, double loss_adjoint,
                            T* colour_adjoint) {
  const std::size_t width = steps.width;
  parallel_for(steps.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const StepWeights leaving = steps(y, x);
      const double from_above = y > 0 ? steps(y - 1, x).down : 0;
      const double from_left = x > 0 ? steps(y, x - 1).right : 0;
      const std::size_t here = (y * width + x) * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        const auto step_to = [&](std::size_t neighbour) {
          return static_cast<double>(colour[here + c]) - static_cast<double>(colour[neighbour + c]);
        };
        double slope = 0;  // ½ · ∂L/∂colour
        if (leaving.down != 0) slope += leaving.down * step_to(here + width * channels);
        if (leaving.right != 0) slope += leaving.right * step_to(here + channels);
        if (from_above != 0) slope += from_above * step_to(here - width * channels);
        if (from_left != 0) slope += from_left * step_to(here - channels);
        colour_adjoint[here + c] += static_cast<T>(2 * loss_adjoint * slope);
      }
    }
  });
}

}  // namespace detail

/// Squared colour steps between neighbouring pixels, counted inside the vehicle mask.
///
///   L = Σ M[y,x] · ((O[y+1,x,c] − O[y,x,c])² + (O[y,x+1,c] − O[y,x,c])²)
///
/// over y < H−1, x < W−1 and all c. A sum, not a mean: L grows with resolution. Pixels outside M are not
/// read, so a NaN there does not matter. Source: Wang et al., FCA (AAAI 2022), eq. 5, there without M and
/// over the composited picture; its published program, like this, sums over the render inside M.
///
/// \param render  O, [H, W, C], colour in [0, 1], row 0 at the top
/// \param mask    M, [H, W], 1 on the vehicle and 0 elsewhere
/// \returns       L in squared colour units, summed in double
/// \throws ShapeError if mask is not [H, W]
template <Image Render, Mask VehicleMask>
[[nodiscard]] auto smoothness(const Render& render, const VehicleMask& mask) {
  require_shape("smoothness", "mask", mask, {render.shape(0), render.shape(1)});
  const detail::PixelSteps<typename VehicleMask::value_type> steps{mask.data(), render.shape(0),
                                                                   render.shape(1)};
  return static_cast<typename Render::value_type>(
      detail::weighted_steps(steps, render.data(), render.shape(2)));
}

/// Adds loss_adjoint · ∂L/∂O to render_adjoint, [H, W, C]; arguments otherwise as in smoothness().
template <Image Render, Mask VehicleMask>
void smoothness_adjoint(const Render& render, const VehicleMask& mask,
                        typename Render::value_type loss_adjoint, Render& render_adjoint) {
  require_shape("smoothness_adjoint", "mask", mask, {render.shape(0), render.shape(1)});
  require_shape("smoothness_adjoint", "render_adjoint", render_adjoint, render.shape());
  const detail::PixelSteps<typename VehicleMask::value_type> steps{mask.data(), render.shape(0),
                                                                   render.shape(1)};
  detail::weighted_steps_adjoint(steps, render.data(), render.shape(2), static_cast<double>(loss_adjoint),
                                 render_adjoint.data());
}

/// Squared colour steps between neighbouring texels of an atlas that are both in use.
///
///   L = Σ U[y,x]·U[y+1,x]·(C[y+1,x] − C[y,x])² + Σ U[y,x]·U[y,x+1]·(C[y,x+1] − C[y,x])²
///
/// summed over the colour channels too; texels that no painted face refers to pull on nothing. Charts
/// that touch in the atlas count as neighbours, whether or not they are on the car.
///
/// \param texels  C, [H·W, channel], row by row from the top, colour in [0, 1]
/// \param used    U, [H, W], 1 where a painted face refers to the texel and 0 elsewhere
/// \returns       L in squared colour units, summed in double
/// \throws ShapeError if texels has not H·W rows
template <Mask Texels, Mask UsedTexels>
[[nodiscard]] auto atlas_smoothness(const Texels& texels, const UsedTexels& used) {
  require_shape("atlas_smoothness", "texels", texels, {used.size(), texels.shape(1)});
  const detail::TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  return static_cast<typename Texels::value_type>(
      detail::weighted_steps(steps, texels.data(), texels.shape(1)));
}

/// Adds loss_adjoint · ∂L/∂C to texels_adjoint; arguments otherwise as in atlas_smoothness().
template <Mask Texels, Mask UsedTexels>
void atlas_smoothness_adjoint(const Texels& texels, const UsedTexels& used,
                              typename Texels::value_type loss_adjoint, Texels& texels_adjoint) {
  require_shape("atlas_smoothness_adjoint", "texels", texels, {used.size(), texels.shape(1)});
  require_shape("atlas_smoothness_adjoint", "texels_adjoint", texels_adjoint, texels.shape());
  const detail::TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  detail::weighted_steps_adjoint(steps, texels.data(), texels.shape(1), static_cast<double>(loss_adjoint),
                                 texels_adjoint.data());
}

}  // namespace tapestry::loss
