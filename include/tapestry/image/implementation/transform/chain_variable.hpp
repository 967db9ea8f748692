#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/chain_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::image {

template <std::floating_point T>
ArrayVariable<T, 4> transformed(const ArrayVariable<T, 4>& pictures,
                                const std::vector<TransformationChain>& chains) {
  const Array<T, 4>& before = pictures.value();
  if (chains.size() != before.shape(0))
    throw ShapeError("transformed: " + std::to_string(chains.size()) + " chains for " +
                     std::to_string(before.shape(0)) + " pictures");
  std::vector<std::vector<Array<T, 3>>> stages(chains.size());
  Array<T, 4> out(before.shape());
  const std::size_t size = chains.empty() ? 0 : before.size() / chains.size();
  parallel_for(chains.size(), [&](std::size_t n) {
    stages[n] = transformation_stages(picture_of(before, n), chains[n]);
    std::copy_n(stages[n].back().data(), size, out.data() + n * size);
  });
  const auto pullback = [stages = std::move(stages), chains, size](const Array<T, 4>& out_adjoint,
                                                                   Array<T, 4>* pictures_adjoint) {
    parallel_for(chains.size(), [&](std::size_t n) {
      Array<T, 3> adjoint = xt::zeros_like(stages[n].front());
      transformed_adjoint(stages[n], chains[n], picture_of(out_adjoint, n), adjoint);
      T* const to = pictures_adjoint->data() + n * size;
      for (std::size_t i = 0; i < size; ++i) to[i] += adjoint.data()[i];
    });
  };
  return record_array(std::move(out), pullback, pictures);
}

template ArrayVariable<float, 4> transformed<float>(const ArrayVariable<float, 4>& pictures,
                                                    const std::vector<TransformationChain>& chains);
template ArrayVariable<double, 4> transformed<double>(const ArrayVariable<double, 4>& pictures,
                                                      const std::vector<TransformationChain>& chains);

}  // namespace tapestry::image
