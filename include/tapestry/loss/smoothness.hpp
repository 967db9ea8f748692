#pragma once
#include <numeric>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/image/pixel_window.hpp>

namespace tapestry::loss::detail {
/// Weights of the two steps that leave texel or pixel (y, x).
struct StepWeights {
  double down;
  double right;
};

/// The image rule: both steps weigh as much as the pixel they leave; the last row and column start none.
template <std::floating_point T>
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
template <std::floating_point T>
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
/// \param row  values from one row to the next
template <class Steps, std::floating_point T>
double squared_steps(const Steps& steps, const T* colour, std::size_t channels, std::size_t row) {
  std::vector<double> row_sums(steps.height, 0.0);
  parallel_for(steps.height, [&](std::size_t y) {
    double sum = 0;
    for (std::size_t x = 0; x < steps.width; ++x) {
      const StepWeights weights = steps(y, x);
      if (weights.down == 0 && weights.right == 0) continue;
      const T* here = colour + y * row + x * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        const auto value = static_cast<double>(here[c]);
        const auto part = [&](double weight, std::size_t to_neighbour) {
          if (weight == 0) return 0.0;
          const double step = static_cast<double>(here[to_neighbour + c]) - value;
          return weight * (step * step);
        };
        sum += part(weights.down, row) + part(weights.right, channels);
      }
    }
    row_sums[y] = sum;
  });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0);
}

/// Adds the derivative of squared_steps() times loss_adjoint. Every value gathers from its four steps,
/// so that rows are independent of one another.
template <class Steps, std::floating_point T>
void squared_steps_adjoint(const Steps& steps, const T* colour, std::size_t channels, std::size_t row,
                           double loss_adjoint, T* colour_adjoint) {
  parallel_for(steps.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < steps.width; ++x) {
      const StepWeights leaving = steps(y, x);
      const double from_above = y > 0 ? steps(y - 1, x).down : 0;
      const double from_left = x > 0 ? steps(y, x - 1).right : 0;
      if (leaving.down == 0 && leaving.right == 0 && from_above == 0 && from_left == 0) continue;
      const std::size_t here = y * row + x * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        double slope = 0;
        const auto add = [&](double weight, std::size_t neighbour) {
          if (weight == 0) return;
          slope += weight *
                   (2 * (static_cast<double>(colour[here + c]) - static_cast<double>(colour[neighbour + c])));
        };
        add(leaving.down, here + row);
        add(leaving.right, here + channels);
        add(from_above, here - row);
        add(from_left, here - channels);
        colour_adjoint[here + c] += static_cast<T>(loss_adjoint * slope);
      }
    }
  });
}
}  // namespace tapestry::loss::detail

namespace tapestry::loss {
/// Squared colour steps between neighbouring pixels, counted inside the vehicle mask.
///
///   L = Σ M[y,x] · ((O[y+1,x,c] − O[y,x,c])² + (O[y,x+1,c] − O[y,x,c])²)
///
/// over y < H−1, x < W−1 and all c. A sum, not a mean: L grows with resolution. Pixels outside M are read
/// only where a step from inside M ends on them. Source: Wang et al., FCA (AAAI 2022), eq. 5, there without M
/// and over the composited picture; its published program, like this, sums over the render inside M.
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
      detail::squared_steps(steps, render.data(), render.shape(2), render.shape(1) * render.shape(2)));
}

/// Adds loss_adjoint · ∂L/∂O to render_adjoint, [H, W, C]; arguments otherwise as in smoothness().
template <Image Render, Mask VehicleMask>
void smoothness_adjoint(const Render& render, const VehicleMask& mask,
                        typename Render::value_type loss_adjoint, Render& render_adjoint) {
  require_shape("smoothness_adjoint", "mask", mask, {render.shape(0), render.shape(1)});
  require_shape("smoothness_adjoint", "render_adjoint", render_adjoint, render.shape());
  const detail::PixelSteps<typename VehicleMask::value_type> steps{mask.data(), render.shape(0),
                                                                   render.shape(1)};
  detail::squared_steps_adjoint(steps, render.data(), render.shape(2), render.shape(1) * render.shape(2),
                                static_cast<double>(loss_adjoint), render_adjoint.data());
}

/// Squared colour steps between neighbouring texels of an atlas that are both in use.
///
///   L = Σ U[y,x]·U[y+1,x]·(C[y+1,x] − C[y,x])² + Σ U[y,x]·U[y,x+1]·(C[y,x+1] − C[y,x])²
///
/// summed over the colour channels too; texels that no painted face refers to do not count. Charts that touch
/// in the atlas count as neighbours, whether or not they do on the car.
///
/// \param texels  C, [H·W, channel], row by row from the top, colour in [0, 1]
/// \param used    U, [H, W], 1 where a painted face refers to the texel and 0 elsewhere, as
///                raster::used_texels() finds
/// \returns       L in squared colour units, summed in double
/// \throws ShapeError if texels has not H·W rows
template <Mask Texels, Mask UsedTexels>
[[nodiscard]] auto atlas_smoothness(const Texels& texels, const UsedTexels& used) {
  require_shape("atlas_smoothness", "texels", texels, {used.size(), texels.shape(1)});
  const detail::TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  return static_cast<typename Texels::value_type>(
      detail::squared_steps(steps, texels.data(), texels.shape(1), used.shape(1) * texels.shape(1)));
}

/// Adds loss_adjoint · ∂L/∂C to texels_adjoint; arguments otherwise as in atlas_smoothness().
template <Mask Texels, Mask UsedTexels>
void atlas_smoothness_adjoint(const Texels& texels, const UsedTexels& used,
                              typename Texels::value_type loss_adjoint, Texels& texels_adjoint) {
  require_shape("atlas_smoothness_adjoint", "texels", texels, {used.size(), texels.shape(1)});
  require_shape("atlas_smoothness_adjoint", "texels_adjoint", texels_adjoint, texels.shape());
  const detail::TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  detail::squared_steps_adjoint(steps, texels.data(), texels.shape(1), used.shape(1) * texels.shape(1),
                                static_cast<double>(loss_adjoint), texels_adjoint.data());
}

/// Mask of the steps that count: pixels of a window, [h, w], shared, and unchanged until the tape's last
/// reverse().
template <std::floating_point T>
struct PlacedMask {
  std::shared_ptr<const Array<T, 2>> mask;  ///< not null
  std::size_t top = 0, left = 0;            ///< of its first pixel in the picture
};

namespace detail {
/// A mask in a batch of pictures.
template <std::floating_point T>
struct MaskedSteps {
  PixelSteps<T> steps;
  std::size_t first, row;  ///< the batch's value that the window begins with; values from row to row

  MaskedSteps(const PlacedMask<T>& placed, const Array<T, 4>& pictures, std::size_t n)
      : steps{placed.mask->data(), placed.mask->shape(0), placed.mask->shape(1)},
        first(((n * pictures.shape(1) + placed.top) * pictures.shape(2) + placed.left) * pictures.shape(3)),
        row(pictures.shape(2) * pictures.shape(3)) {}
};
}  // namespace detail

/// The sum of smoothness() over the pictures of a batch, each within a window of its own, as one record on
/// the active tape; its pullback is smoothness_adjoint(). Sums are in double and in a fixed order: the same
/// bits for any number of threads.
///
/// \param pictures  [N, H, W, C]
/// \param masks     one for each picture
/// \throws ShapeError if there are not as many masks as pictures, or one leaves its picture
template <std::floating_point T>
[[nodiscard]] Variable<T> smoothness(const ArrayVariable<T, 4>& pictures, std::vector<PlacedMask<T>> masks) {
  const auto& [count, height, width, channels] = pictures.shape();
  if (masks.size() != count)
    throw ShapeError({"smoothness: masks of ", masks.size(), " pictures, expected ", count});
  for (const auto& [mask, top, left] : masks)
    image::require_window("smoothness", {top, left, mask->shape(0), mask->shape(1)}, height, width);
  std::vector<double> sums(masks.size());
  parallel_for(masks.size(), [&, channel_count = channels](std::size_t n) {
    const detail::MaskedSteps<T> masked(masks[n], pictures.value(), n);
    sums[n] = detail::squared_steps(masked.steps, pictures.value().data() + masked.first, channel_count,
                                    masked.row);
  });
  const double total = std::accumulate(sums.begin(), sums.end(), 0.0);
  const auto pullback = [values = pictures.shared_value(), of_pictures = std::move(masks)](
                            T adjoint, Array<T, 4>* pictures_adjoint) {
    for (std::size_t n = 0; n < of_pictures.size(); ++n) {
      const detail::MaskedSteps<T> masked(of_pictures[n], *values, n);
      detail::squared_steps_adjoint(masked.steps, values->data() + masked.first, values->shape(3), masked.row,
                                    static_cast<double>(adjoint), pictures_adjoint->data() + masked.first);
    }
  };
  return record_scalar(static_cast<T>(total), pullback, pictures);
}

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] Variable<D> smoothness(const ArrayVariable<D, 4>& pictures,
                                     const std::vector<PlacedMask<typename D::value_type>>& masks) {
  return record_quadratic([=](const auto& at) { return smoothness(at, masks); }, pictures);
}

/// atlas_smoothness() of a texture on the active tape; its pullback is atlas_smoothness_adjoint().
///
/// \param texels  [H·W, channel]
/// \param used    [H, W], as raster::used_texels() gives it; shared, and not to be changed before the tape's
///                last reverse()
/// \throws ShapeError if texels has not H·W rows
template <std::floating_point T>
[[nodiscard]] Variable<T> atlas_smoothness(const ArrayVariable<T, 2>& texels,
                                           std::shared_ptr<const Array<T, 2>> used) {
  const T value = atlas_smoothness(texels.value(), *used);
  const auto pullback = [values = texels.shared_value(), of_texels = std::move(used)](
                            T adjoint, Array<T, 2>* texels_adjoint) {
    atlas_smoothness_adjoint(*values, *of_texels, adjoint, *texels_adjoint);
  };
  return record_scalar(value, pullback, texels);
}

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] Variable<D> atlas_smoothness(
    const ArrayVariable<D, 2>& texels, const std::shared_ptr<const Array<typename D::value_type, 2>>& used) {
  return record_quadratic([=](const auto& at) { return atlas_smoothness(at, used); }, texels);
}
}  // namespace tapestry::loss
