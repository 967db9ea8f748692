#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/compressed_jacobian.hpp>

namespace tapestry {

/// The entries of d root / d variable in the plan's pattern, in its order: one reverse() for each colour of
/// its rows, which are elements of the root that share no element of the variable. Rows and columns are
/// elements in row-major order. The caller makes the pattern from the operations, since a tape does not
/// record how pullbacks work. Entries that it wrongly leaves out are added to others.
/// \throws DomainError if there are not as many elements and values as the pattern has, or root or variable
/// is not on the tape
template <std::floating_point T, std::size_t RootRank, std::size_t Rank>
void compressed_jacobian(Tape<T>& tape, const ArrayVariable<T, RootRank>& root,
                         const ArrayVariable<T, Rank>& variable, const JacobianPlan& plan,
                         std::span<std::type_identity_t<T>> values) {
  const JacobianPattern& pattern = plan.pattern();
  detail::require_pattern_of(pattern, root.size(), variable.size(), values.size());
  tape.shared_state()->require_own_if_active(variable.link());
  const ColumnColouring& colouring = plan.row_colouring();
  Array<T, RootRank> seed(root.shape());
  for (std::size_t colour = 0; colour < colouring.colour_count; ++colour) {
    for (std::size_t row = 0; row < root.size(); ++row)
      seed.data()[row] = colouring.colour_of[row] == colour ? T(1) : T(0);
    tape.reverse(root, seed);
    const T* const adjoint = variable.adjoint().data();
    pattern.visit([&](std::size_t row, std::size_t column, std::size_t e) {
      if (colouring.colour_of[row] == colour) values[e] = adjoint[column];
    });
  }
}

}  // namespace tapestry
