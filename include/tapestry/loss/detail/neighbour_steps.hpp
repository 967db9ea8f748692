#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>  // Image, Mask
#include <tapestry/core/error.hpp>  // require_shape, ShapeError
#include <tapestry/core/parallel.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {

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

/// Σ over all values of weight · penalty(step), in double: rows in parallel, their sums added from the top.
template <class Steps, class Penalty, std::floating_point T>
double weighted_steps(const Steps& steps, const Penalty& penalty, const T* colour, std::size_t channels) {
  std::vector<double> row_sums(steps.height, 0.0);
  parallel_for(steps.height, [&](std::size_t y) {
    double sum = 0;
    for (std::size_t x = 0; x < steps.width; ++x) {
      const StepWeights weights = steps(y, x);
      if (weights.down == 0 && weights.right == 0) continue;
      const T* here = colour + (y * steps.width + x) * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        const auto value = static_cast<double>(here[c]);
        const auto part = [&](double weight, std::size_t to_neighbour) {
          return weight == 0 ? 0
                             : weight * penalty.value(static_cast<double>(here[to_neighbour + c]) - value);
        };
        sum += part(weights.down, steps.width * channels) + part(weights.right, channels);
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
template <class Steps, class Penalty, std::floating_point T>
void weighted_steps_adjoint(const Steps& steps, const Penalty& penalty, const T* colour, std::size_t channels,
                            double loss_adjoint, T* colour_adjoint) {
  const std::size_t width = steps.width;
  parallel_for(steps.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const StepWeights leaving = steps(y, x);
      const double from_above = y > 0 ? steps(y - 1, x).down : 0;
      const double from_left = x > 0 ? steps(y, x - 1).right : 0;
      if (leaving.down == 0 && leaving.right == 0 && from_above == 0 && from_left == 0) continue;
      const std::size_t here = (y * width + x) * channels;
      for (std::size_t c = 0; c < channels; ++c) {
        double slope = 0;
        const auto add = [&](double weight, std::size_t neighbour) {
          if (weight == 0) return;
          slope += weight * penalty.slope(static_cast<double>(colour[here + c]) -
                                          static_cast<double>(colour[neighbour + c]));
        };
        add(leaving.down, here + width * channels);
        add(leaving.right, here + channels);
        add(from_above, here - width * channels);
        add(from_left, here - channels);
        colour_adjoint[here + c] += static_cast<T>(loss_adjoint * slope);
      }
    }
  });
}

/// Both rules with their checks: the sum over a picture, [H, W, C], or an atlas, [H·W, C].
template <class Penalty, Image Render, Mask VehicleMask>
[[nodiscard]] auto picture_steps(const char* operation, const Penalty& penalty, const Render& render,
                                 const VehicleMask& mask) {
  require_shape(operation, "mask", mask, {render.shape(0), render.shape(1)});
  const PixelSteps<typename VehicleMask::value_type> steps{mask.data(), render.shape(0), render.shape(1)};
  return weighted_steps(steps, penalty, render.data(), render.shape(2));
}

template <class Penalty, Image Render, Mask VehicleMask>
void picture_steps_adjoint(const char* operation, const Penalty& penalty, const Render& render,
                           const VehicleMask& mask, double loss_adjoint, Render& render_adjoint) {
  require_shape(operation, "mask", mask, {render.shape(0), render.shape(1)});
  require_shape(operation, "render_adjoint", render_adjoint, render.shape());
  const PixelSteps<typename VehicleMask::value_type> steps{mask.data(), render.shape(0), render.shape(1)};
  weighted_steps_adjoint(steps, penalty, render.data(), render.shape(2), loss_adjoint, render_adjoint.data());
}

template <class Penalty, Mask Texels, Mask UsedTexels>
[[nodiscard]] auto atlas_steps(const char* operation, const Penalty& penalty, const Texels& texels,
                               const UsedTexels& used) {
  require_shape(operation, "texels", texels, {used.size(), texels.shape(1)});
  const TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  return weighted_steps(steps, penalty, texels.data(), texels.shape(1));
}

template <class Penalty, Mask Texels, Mask UsedTexels>
void atlas_steps_adjoint(const char* operation, const Penalty& penalty, const Texels& texels,
                         const UsedTexels& used, double loss_adjoint, Texels& texels_adjoint) {
  require_shape(operation, "texels", texels, {used.size(), texels.shape(1)});
  require_shape(operation, "texels_adjoint", texels_adjoint, texels.shape());
  const TexelSteps<typename UsedTexels::value_type> steps{used.data(), used.shape(0), used.shape(1)};
  weighted_steps_adjoint(steps, penalty, texels.data(), texels.shape(1), loss_adjoint, texels_adjoint.data());
}

}  // namespace detail

/// Masks for losses on the tape: shared, since they mostly stay the same from step to step. Each [H, W], not
/// null, and not to be changed before the tape's last reverse().
template <std::floating_point T>
using SharedMasks = std::vector<std::shared_ptr<const Array<T, 2>>>;

namespace detail {

/// Σ over pictures of picture_steps().
template <class Penalty, std::floating_point T>
[[nodiscard]] Variable<T> record_picture_steps(const char* operation, const Penalty& penalty,
                                               const std::vector<ArrayVariable<T, 3>>& pictures,
                                               SharedMasks<T> masks) {
  if (masks.size() != pictures.size())
    throw ShapeError({operation, ": masks of ", masks.size(), " pictures, expected ", pictures.size()});
  std::vector<std::shared_ptr<const Array<T, 3>>> values;
  for (const auto& picture : pictures) values.push_back(picture.shared_value());
  std::vector<double> sums(values.size());
  parallel_for(values.size(),
               [&](std::size_t n) { sums[n] = picture_steps(operation, penalty, *values[n], *masks[n]); });
  double total = 0;
  for (const double sum : sums) total += sum;
  const auto pullback = [operation, penalty, values = std::move(values), of_pictures = std::move(masks)](
                            T adjoint, const std::vector<Array<T, 3>*>& pictures_adjoint) {
    for (std::size_t n = 0; n < values.size(); ++n)  // in turn: two may share an adjoint
      if (pictures_adjoint[n] != nullptr)
        picture_steps_adjoint(operation, penalty, *values[n], *of_pictures[n], static_cast<double>(adjoint),
                              *pictures_adjoint[n]);
  };
  return record_scalar(static_cast<T>(total), pullback, pictures);
}

/// The same of one picture, whose mask is copied into the record unless it is moved there.
template <class Penalty, std::floating_point T>
[[nodiscard]] Variable<T> record_picture_steps(const char* operation, const Penalty& penalty,
                                               const ArrayVariable<T, 3>& picture, Array<T, 2> mask) {
  const std::vector<ArrayVariable<T, 3>> one{picture};
  return record_picture_steps(operation, penalty, one,
                              SharedMasks<T>{std::make_shared<const Array<T, 2>>(std::move(mask))});
}

template <class Penalty, std::floating_point T>
[[nodiscard]] Variable<T> record_atlas_steps(const char* operation, const Penalty& penalty,
                                             const ArrayVariable<T, 2>& texels,
                                             std::shared_ptr<const Array<T, 2>> used) {
  const T value = static_cast<T>(atlas_steps(operation, penalty, texels.value(), *used));
  const auto pullback = [operation, penalty, values = texels.shared_value(), of_texels = std::move(used)](
                            T adjoint, Array<T, 2>* texels_adjoint) {
    atlas_steps_adjoint(operation, penalty, *values, *of_texels, static_cast<double>(adjoint),
                        *texels_adjoint);
  };
  return record_scalar(value, pullback, texels);
}

}  // namespace detail
}  // namespace tapestry::loss
