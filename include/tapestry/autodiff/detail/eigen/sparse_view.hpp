#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

namespace Eigen {
template <class Matrix>
class SparseView;

namespace internal {
/// Entries of sparseView() and pruned() of variables. Eigen's own leave out an entry of value 0, and its
/// derivatives with it.
template <class Matrix, class Kind>
struct SparseViewOfVariables : evaluator_base<SparseView<Matrix>> {
  using XprType = SparseView<Matrix>;
  using Entries = inner_iterator_selector<Matrix, Kind>;
  enum { CoeffReadCost = evaluator<Matrix>::CoeffReadCost, Flags = XprType::Flags };

  explicit SparseViewOfVariables(const XprType& of) : entries(of.nestedExpression()), view(of) {}

  class InnerIterator : public Entries {
   public:
    InnerIterator(const SparseViewOfVariables& all, Index outer)
        : Entries(all.entries, outer, all.view.innerSize()), view_(all.view) {
      find();
    }
    InnerIterator& operator++() {
      Entries::operator++();
      find();
      return *this;
    }

   private:
    void find() {
      while (*this && is_left_out(Entries::value())) Entries::operator++();
    }
    [[nodiscard]] bool is_left_out(const typename XprType::Scalar& entry) const {
      return isMuchSmallerThan(entry, view_.reference(), view_.epsilon()) &&
             (entry != 0 || tapestry::detail::is_passive_zero(entry));
    }

    const XprType& view_;
  };

  evaluator<Matrix> entries;
  const XprType& view;
};

template <tapestry::detail::MatrixOfDifferentiable Matrix>
struct unary_evaluator<SparseView<Matrix>, IndexBased> : SparseViewOfVariables<Matrix, IndexBased> {
  using SparseViewOfVariables<Matrix, IndexBased>::SparseViewOfVariables;
};
template <tapestry::detail::MatrixOfDifferentiable Matrix>
struct unary_evaluator<SparseView<Matrix>, IteratorBased> : SparseViewOfVariables<Matrix, IteratorBased> {
  using SparseViewOfVariables<Matrix, IteratorBased>::SparseViewOfVariables;
};
}  // namespace internal
}  // namespace Eigen
