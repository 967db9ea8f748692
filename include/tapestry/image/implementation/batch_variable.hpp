#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/batch_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::image {

template <std::floating_point T>
ArrayVariable<T, 4> batch_of(const std::vector<ArrayVariable<T, 3>>& pictures) {
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

template ArrayVariable<float, 4> batch_of<float>(const std::vector<ArrayVariable<float, 3>>& pictures);
template ArrayVariable<double, 4> batch_of<double>(const std::vector<ArrayVariable<double, 3>>& pictures);

}  // namespace tapestry::image
