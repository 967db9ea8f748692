#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/loss/cross_entropy.hpp>

namespace tapestry::loss {

/// binary_cross_entropy() on the active tape; its pullback is binary_cross_entropy_adjoint().
/// \param wanted  shared, and not to be changed before the tape's last reverse()
template <std::floating_point T>
[[nodiscard]] Variable<T> binary_cross_entropy(const ArrayVariable<T, 4>& logits,
                                               std::shared_ptr<const Array<T, 4>> wanted);

/// cross_entropy() on the active tape; its pullback is cross_entropy_adjoint().
/// \param wanted  as above
template <std::floating_point T>
[[nodiscard]] Variable<T> cross_entropy(const ArrayVariable<T, 4>& logits,
                                        std::shared_ptr<const Array<T, 4>> wanted);

}  // namespace tapestry::loss
