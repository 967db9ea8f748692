#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/neighbour_steps.hpp>
#include <vector>

namespace tapestry::loss {

/// Masks as the tape keeps them: shared, since they mostly stay the same from step to step. Each [H, W], not
/// null, and not to be changed before the tape's last reverse().
template <class T>
using SharedMasks = std::vector<std::shared_ptr<const Array<T, 2>>>;

namespace detail {

/// Σ over pictures of picture_steps().
template <class Penalty, class T>
[[nodiscard]] Variable<T> record_picture_steps(const char* operation, const Penalty& penalty,
                                               const std::vector<ArrayVariable<T, 3>>& pictures,
                                               SharedMasks<T> masks) {
  if (masks.size() != pictures.size())
    throw ShapeError(std::string(operation) + ": masks of " + std::to_string(masks.size()) +
                     " pictures, expected " + std::to_string(pictures.size()));
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
template <class Penalty, class T>
[[nodiscard]] Variable<T> record_picture_steps(const char* operation, const Penalty& penalty,
                                               const ArrayVariable<T, 3>& picture, Array<T, 2> mask) {
  const std::vector<ArrayVariable<T, 3>> one{picture};
  return record_picture_steps(operation, penalty, one,
                              SharedMasks<T>{std::make_shared<const Array<T, 2>>(std::move(mask))});
}

template <class Penalty, class T>
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
