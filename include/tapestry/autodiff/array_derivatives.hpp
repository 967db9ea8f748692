#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/compressed_jacobian.hpp>
#include <tapestry/autodiff/gradient_check.hpp>

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

/// f(x…), its gradient, and its Hessian's product with a direction, by argument.
template <class T, class... Arrays>
struct ArrayHessianProduct {
  T value;
  std::tuple<Arrays...> gradient, product;
};

/// Second derivatives of a function of arrays, forward over reverse: f is recorded once, on a tape of duals,
/// and takes ArrayVariables of any scalar. Operations of this library that have no second order on such a
/// tape do not compile; see record_tangent() for one's own. Where an operation of arrays has a kink or an
/// infinite slope, entries are NaN: no neighbours are tried, as hessian() of scalars does.
///
///   const auto f = [](const auto& x, const auto& w) { return sum(tanh(matmul(w, x))); };
///   const auto [value, gradient, product] = hessian_product(f, std::tuple(x, w), std::tuple(dx, dw));
///
/// \throws ShapeError if a direction has not the extents of its argument
template <class Function, std::floating_point T, std::size_t... Ranks>
[[nodiscard]] ArrayHessianProduct<T, Array<T, Ranks>...> hessian_product(
    const Function& f, const std::tuple<Array<T, Ranks>...>& x, const std::tuple<Array<T, Ranks>...>& v) {
  using D = Dual<T, 1, Function>;
  Tape<D> tape;
  const auto scope = tape.activate();
  const auto input = [&]<std::size_t Rank>(const Array<T, Rank>& at, const Array<T, Rank>& along) {
    require_shape("hessian_product", "direction", along, at.shape());
    Array<D, Rank> both(at.shape());
    for (std::size_t i = 0; i < at.size(); ++i) both.data()[i] = D(at.data()[i], {along.data()[i]});
    return tape.input(std::move(both));
  };
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    const std::tuple inputs{input(std::get<i>(x), std::get<i>(v))...};
    const Variable<D> root = f(std::get<i>(inputs)...);
    tape.reverse(root);
    return ArrayHessianProduct<T, Array<T, Ranks>...>{root.value().value(),
                                                      {detail::part_of(std::get<i>(inputs).adjoint(), 0)...},
                                                      {detail::part_of(std::get<i>(inputs).adjoint(), 1)...}};
  }
  (std::index_sequence_for<Array<T, Ranks>...>());
}

/// The same for a function of one array.
template <class Function, std::floating_point T, std::size_t Rank>
[[nodiscard]] auto hessian_product(const Function& f, const Array<T, Rank>& x, const Array<T, Rank>& v) {
  return hessian_product(f, std::tuple(x), std::tuple(v));
}

/// The Hessian of a function of one array, [n, n], its elements in row-major order; a product for each.
template <class Function, std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, 2> hessian(const Function& f, const Array<T, Rank>& x) {
  Array<T, 2> all(Extents<2>{x.size(), x.size()});
  for (std::size_t i = 0; i < x.size(); ++i) {
    Array<T, Rank> unit = zeros<T, Rank>(x.shape());
    unit.data()[i] = 1;
    const auto product = std::get<0>(hessian_product(f, x, unit).product);
    std::copy_n(product.data(), x.size(), all.data() + i * x.size());
  }
  return all;
}

/// ½‖∂f/∂x‖² and its gradient by x and each parameter, which is the Hessian times (∂f/∂x, 0, …).
template <class Function, std::floating_point T, std::size_t Rank, std::size_t... Ranks>
[[nodiscard]] auto gradient_penalty(const Function& f, const Array<T, Rank>& x,
                                    const Array<T, Ranks>&... parameters) {
  Tape<T> tape;
  const auto scope = tape.activate();
  const ArrayVariable<T, Rank> input = tape.input(x);
  tape.reverse(Variable<T>(f(input, ArrayVariable<T, Ranks>(parameters)...)));
  const Array<T, Rank>& gradient = input.adjoint();
  double square = 0;
  for (const T slope : gradient) square += static_cast<double>(slope) * static_cast<double>(slope);
  auto gradients = hessian_product(f, std::tuple(x, parameters...),
                                   std::tuple(gradient, zeros<T, Ranks>(parameters.shape())...))
                       .product;
  return std::pair(static_cast<T>(square / 2), std::move(gradients));
}

/// Compares a product of the Hessian of a function of one array, written for any scalar, with central
/// differences of the gradient's part along the direction: it finds an operation that loses tangents. Entries
/// are those of the product.
template <class Function, std::size_t Rank>
[[nodiscard]] GradientReport check_hessian_product(const Function& f, const Array<double, Rank>& x,
                                                   const Array<double, Rank>& v,
                                                   const GradientCheckOptions& options = {}) {
  const auto slope = [&](const Array<double, Rank>& at) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const ArrayVariable<double, Rank> input = tape.input(at);
    tape.reverse(Variable<double>(f(input)));
    return std::inner_product(v.begin(), v.end(), input.adjoint().begin(), 0.0);
  };
  return check_gradient(slope, x, std::get<0>(hessian_product(f, x, v).product), options);
}
}  // namespace tapestry
