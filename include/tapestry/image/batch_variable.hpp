#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/batch.hpp>
#include <utility>
#include <vector>

namespace tapestry::image {

/// batch_of() of pictures on the tape, [N, H, W, C], such as a network takes.
/// \throws ShapeError as batch_of()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> batch_of(const std::vector<ArrayVariable<T, 3>>& pictures) {
  std::vector<const Array<T, 3>*> values;
  for (const auto& picture : pictures) values.push_back(&picture.value());
  const auto pullback = [](const Array<T, 4>& batch_adjoint,
                           const std::vector<Array<T, 3>*>& picture_adjoints) {
    const T* from = batch_adjoint.data();
    for (auto* const adjoint : picture_adjoints) {
      const std::size_t size = batch_adjoint.size() / batch_adjoint.shape(0);
      for (std::size_t i = 0; adjoint != nullptr && i < size; ++i) adjoint->data()[i] += from[i];
      from += size;
    }
  };
  return record_array(batch_of(values), pullback, pictures);
}

}  // namespace tapestry::image
