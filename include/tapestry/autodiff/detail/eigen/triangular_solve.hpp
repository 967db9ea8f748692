#pragma once
#include <Eigen/Core>
#include <tapestry/autodiff/functions.hpp>

// Eigen's triangular solves for a vector. Its own leave out a number of the right-hand side that is 0, and
// its derivatives with it.

namespace tapestry::detail {
template <class S>
concept HasDerivatives = Differentiable<S> || ComplexOfDifferentiable<S>;
template <class M>
concept MatrixOfDerivatives = HasDerivatives<typename M::Scalar>;

/// Whether a number is 0 and carries no derivatives: products with it are left out.
template <HasDerivatives S>
[[nodiscard]] bool is_passive_zero(const S& x) {
  if constexpr (ComplexOfDifferentiable<S>) {
    return is_passive_zero(x.real()) && is_passive_zero(x.imag());
  } else if constexpr (ScalarExpression<S>) {
    return !x.is_active() && is_zero(x.value());
  } else {
    return x.is_zero();
  }
}

/// Solves L x = b for a triangular L, [N, N]; x replaces b. The operations are Eigen's, in Eigen's order.
template <class Left, class Right, int Mode, bool Conjugate, int Order>
struct TriangularSolve {
  static constexpr bool is_lower = (Mode & Eigen::Lower) == Eigen::Lower;
  static constexpr bool by_rows = Order == Eigen::RowMajor;

  template <class Index>
  static void run(Index size, const Left* entries, Index stride, Right* numbers) {
    using Entries = Eigen::Matrix<Left, Eigen::Dynamic, Eigen::Dynamic, Order>;
    const Eigen::Map<const Entries, 0, Eigen::OuterStride<>> map(entries, size, size,
                                                                 Eigen::OuterStride<>(stride));
    Eigen::Map<Eigen::Matrix<Right, Eigen::Dynamic, 1>> x(numbers, size);
    if constexpr (Conjugate && Eigen::NumTraits<Left>::IsComplex) {
      solve(map.conjugate(), x);
    } else {
      solve(map, x);
    }
  }

 private:
  template <class L, class X>
  static void solve(const L& l, X& x) {
    const Eigen::Index size = x.size(), width = EIGEN_TUNE_TRIANGULAR_PANEL_WIDTH;
    for (Eigen::Index done = 0; done < size; done += width) {
      const Eigen::Index count = std::min(width, size - done), left = size - done - count;
      const Eigen::Index begin = is_lower ? done : left, end = begin + count;
      const Eigen::Index behind = is_lower ? 0 : end, ahead = is_lower ? end : 0;
      if (by_rows && done > 0)
        x.segment(begin, count).noalias() -= l.block(begin, behind, count, done) * x.segment(behind, done);
      for (Eigen::Index k = 0; k < count; ++k)
        solve_row(l, x, is_lower ? begin + k : end - 1 - k, begin, end);
      if (!by_rows && left > 0)
        x.segment(ahead, left).noalias() -= l.block(ahead, begin, left, count) * x.segment(begin, count);
    }
  }

  /// Solves for x[i], within columns, or rows, begin to end.
  template <class L, class X>
  static void solve_row(const L& l, X& x, Eigen::Index i, Eigen::Index begin, Eigen::Index end) {
    const Eigen::Index first = is_lower ? begin : i + 1, last = is_lower ? i : end;
    if (by_rows && last > first) {
      Right sum = l.coeff(i, first) * x.coeff(first);
      for (Eigen::Index j = first + 1; j < last; ++j) sum += l.coeff(i, j) * x.coeff(j);
      x.coeffRef(i) -= sum;
    }
    if (is_passive_zero(x.coeff(i))) return;
    if constexpr ((Mode & Eigen::UnitDiag) == 0) x.coeffRef(i) /= l.coeff(i, i);
    if constexpr (!by_rows)
      for (Eigen::Index j = is_lower ? i + 1 : begin; j < (is_lower ? end : i); ++j)
        x.coeffRef(j) -= x.coeff(i) * l.coeff(j, i);
  }
};

/// The same of a sparse L, which is stored by columns, for the columns of a dense b.
template <class Left, class Right, int Mode>
struct SparseTriangularSolve {
  static void run(const Left& l, Right& x) {
    using Evaluator = Eigen::internal::evaluator<Left>;
    constexpr bool is_lower = (Mode & Eigen::Lower) == Eigen::Lower;
    const Evaluator columns(l);
    for (Eigen::Index column = 0; column < x.cols(); ++column)
      for (Eigen::Index step = 0; step < l.cols(); ++step) {
        const Eigen::Index i = is_lower ? step : l.cols() - 1 - step;
        auto& number = x.coeffRef(i, column);
        if (is_passive_zero(number)) continue;
        using Entry = typename Evaluator::InnerIterator;
        if constexpr ((Mode & Eigen::UnitDiag) == 0)
          for (Entry entry(columns, i); entry; ++entry)
            if (entry.index() == i) number /= entry.value();
        for (Entry entry(columns, i); entry; ++entry)
          if (is_lower ? entry.index() > i : entry.index() < i)
            x.coeffRef(entry.index(), column) -= number * entry.value();
      }
  }
};
}  // namespace tapestry::detail

namespace Eigen::internal {
template <class Lhs, class Rhs, int Mode, int UpLo, int Order>
struct sparse_solve_triangular_selector;

template <class Left, tapestry::detail::HasDerivatives Right, class Index, int Mode, bool Conjugate>
struct triangular_solve_vector<Left, Right, Index, OnTheLeft, Mode, Conjugate, RowMajor>
    : tapestry::detail::TriangularSolve<Left, Right, Mode, Conjugate, RowMajor> {};
template <class Left, tapestry::detail::HasDerivatives Right, class Index, int Mode, bool Conjugate>
struct triangular_solve_vector<Left, Right, Index, OnTheLeft, Mode, Conjugate, ColMajor>
    : tapestry::detail::TriangularSolve<Left, Right, Mode, Conjugate, ColMajor> {};
template <class Left, tapestry::detail::MatrixOfDerivatives Right, int Mode>
struct sparse_solve_triangular_selector<Left, Right, Mode, Lower, ColMajor>
    : tapestry::detail::SparseTriangularSolve<Left, Right, Mode> {};
template <class Left, tapestry::detail::MatrixOfDerivatives Right, int Mode>
struct sparse_solve_triangular_selector<Left, Right, Mode, Upper, ColMajor>
    : tapestry::detail::SparseTriangularSolve<Left, Right, Mode> {};
}  // namespace Eigen::internal
