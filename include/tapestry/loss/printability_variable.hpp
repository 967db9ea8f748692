#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/loss/printability.hpp>

namespace tapestry::loss {

/// non_printability() on the active tape; its pullback is non_printability_adjoint().
///
/// \param texels  [H·W, 3]
/// \param used    [H, W]; it and `palette` are shared, and not to be changed before the tape's last reverse()
template <std::floating_point T>
[[nodiscard]] Variable<T> non_printability(const ArrayVariable<T, 2>& texels,
                                           std::shared_ptr<const Array<T, 2>> used,
                                           std::shared_ptr<const Array<double, 2>> palette,
                                           double spread = printable_spread);

}  // namespace tapestry::loss
