#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

namespace Eigen::internal {
/// A formula of variables that a number multiplies, as a triangle of ones on its diagonal. Eigen
/// multiplies products with it by the number, then corrects the diagonal, but not for a number 1: its
/// derivatives then stay there.
template <class Matrix, int Mode>
concept ScaledUnitTriangle =
    (Mode & UnitDiag) != 0 &&
    bool(blas_traits<Matrix>::HasScalarFactor) && tapestry::detail::HasDerivatives<typename Matrix::Scalar>;

template <int Mode, class Left, class Right>
requires ScaledUnitTriangle<Left, Mode>
struct triangular_product_impl<Mode, true, Left, false, Right, true> {
  template <class To>
  static void run(To& to, const Left& left, const Right& right, const typename To::Scalar& factor) {
    using Plain = typename Left::PlainObject;
    triangular_product_impl<Mode, true, Plain, false, Right, true>::run(to, Plain(left), right, factor);
  }
};
template <int Mode, class Left, class Right>
requires ScaledUnitTriangle<Right, Mode>
struct triangular_product_impl<Mode, false, Left, true, Right, false> {
  template <class To>
  static void run(To& to, const Left& left, const Right& right, const typename To::Scalar& factor) {
    using Plain = typename Right::PlainObject;
    triangular_product_impl<Mode, false, Left, true, Plain, false>::run(to, left, Plain(right), factor);
  }
};
template <int Mode, bool IsLeft, class Left, class Right>
requires ScaledUnitTriangle<std::conditional_t<IsLeft, Left, Right>, Mode>
struct triangular_product_impl<Mode, IsLeft, Left, false, Right, false> {
  template <class To>
  static void run(To& to, const Left& left, const Right& right, const typename To::Scalar& factor) {
    using PlainLeft = std::conditional_t<IsLeft, typename Left::PlainObject, Left>;
    using PlainRight = std::conditional_t<IsLeft, Right, typename Right::PlainObject>;
    const PlainLeft& plain_left = left;
    const PlainRight& plain_right = right;
    triangular_product_impl<Mode, IsLeft, PlainLeft, false, PlainRight, false>::run(to, plain_left,
                                                                                    plain_right, factor);
  }
};
}  // namespace Eigen::internal
