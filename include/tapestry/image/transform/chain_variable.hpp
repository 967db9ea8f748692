#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/transform/chain.hpp>
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
                                              const std::vector<TransformationChain>& chains);

}  // namespace tapestry::image
