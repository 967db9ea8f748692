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
#include <utility>
#include <vector>

namespace tapestry::image {

/// Recoloured texels or pictures on the tape, [..., 3].
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> transformed(const ArrayVariable<T, Rank>& colours,
                                                 const ColourChange& change) {
  const auto pullback = [before = colours.shared_value(), change](const Array<T, Rank>& out_adjoint,
                                                                  Array<T, Rank>* colours_adjoint) {
    transformed_adjoint(*before, change, out_adjoint, *colours_adjoint);
  };
  return record_array(transformed(colours.value(), change), pullback, colours);
}

/// The pictures of a batch, each after its own chain, in one operation on the tape, which keeps what every
/// transformation began with.
///
/// \param pictures  [N, H, W, 3]
/// \param chains    one a picture
/// \returns         [N, H, W, 3]
/// \throws ShapeError if there are not as many chains; or as the transformations
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> transformed(const ArrayVariable<T, 4>& pictures,
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

}  // namespace tapestry::image
