#pragma once
#include <Eigen/Core>
#include <Eigen/LU>
#include <tapestry/autodiff/checkpoint.hpp>

namespace tapestry {
namespace detail {
/// The solution of equations, as the statements behind it. The way to it is not recorded.
template <class T, class Residual>
class ImplicitRecord final : public TapeRecord<T> {
 public:
  ImplicitRecord(Residual residual, std::span<const T> solution, std::span<const Variable<T>> parameters)
      : residual_(std::move(residual)),
        solution_(solution.begin(), solution.end()),
        parameters_(parameters.begin(), parameters.end()) {}

  void pull_back(T* adjoints, std::size_t statement) override {
    const auto n = static_cast<Eigen::Index>(solution_.size());
    const Eigen::Map<const Vector> x_adjoint(adjoints + statement + 1, n);
    if ((x_adjoint.array() == T(0)).all()) return;
    SpareTape<T> tape;
    const auto scope = tape->activate();
    const std::span<const Variable<T>> x = tape.input(solution_);
    std::vector<Variable<T>> p;
    for (const Variable<T>& parameter : parameters_)
      p.push_back(parameter.is_active() ? tape->input(parameter.value()) : passive(parameter));
    const auto residuals = residual_(x, std::span<const Variable<T>>(p));
    const Vector weights = -solve_transposed(*tape, residuals, x, x_adjoint);
    tape->reverse(record_partials<T>(T(0), residuals, std::span<const T>(weights.data(), x.size())));
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p[i].is_active()) adjoints[parameters_[i].link().index()] += tape->adjoint(p[i]);
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override {
    list_variables<T>(parameters_, statements);
  }

 private:
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;

  /// (∂F/∂x)⁻ᵀ · side
  static Vector solve_transposed(Tape<T>& tape, const std::vector<Variable<T>>& residuals,
                                 std::span<const Variable<T>> x, const Vector& side) {
    if (residuals.size() != x.size())
      throw ShapeError(
          {"implicit_function: the residual has ", residuals.size(), " numbers, expected ", x.size()});
    Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> transposed(side.size(), side.size());
    for (Eigen::Index i = 0; i < side.size(); ++i) {
      tape.reverse(residuals[static_cast<std::size_t>(i)]);
      tape.adjoints(x, std::span<T>(transposed.col(i).data(), x.size()));
    }
    const Eigen::PartialPivLU<Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>> lu(transposed);
    if ((lu.matrixLU().diagonal().array() == T(0)).any())
      throw NumericError(
          "implicit_function: the residual's Jacobian by the solution is singular, "
          "so that the solution has no derivative");
    return lu.solve(side);
  }

  Residual residual_;
  std::vector<T> solution_;
  std::vector<Variable<T>> parameters_;
};
}  // namespace detail

/// The solution x of F(x, p) = 0 as a function of p, as one record, whatever solver has found it. By the
/// implicit function theorem
///
///   p̄ = −(∂F/∂p)ᵀ (∂F/∂x)⁻ᵀ x̄.
///
/// A fixed point x = g(x, p) is a root of F = x − g(x, p). F is computed in the reverse sweep only, once, on
/// a tape of its own, which is swept once for each number of x; then its Jacobian is decomposed. The
/// gradient's error has the order of the solution's error, which is not checked.
///
///   const double root = newton(p.value());                      // x³ + p x = 1, in plain numbers
///   const auto residual = [](auto x, auto p) {
///     return std::vector<Variable<double>>{x[0] * x[0] * x[0] + p[0] * x[0] - 1};
///   };
///   const Variable<double> x = implicit_function<double>(residual, std::array{root}, std::array{p})[0];
///
/// \param residual    F: takes two std::span<const Variable<T>>, x and p, and returns
///                    std::vector<Variable<T>> of x's size; computes the same whenever called, uses no other
///                    active variables, and is copied
/// \param solution    x, any number of numbers
/// \param parameters  p, any number of variables, active or passive
/// \returns           the solution as variables; passive, with nothing recorded, if all parameters are
/// \throws DomainError  as any statement
/// \throws ShapeError   in the reverse sweep, if F and x differ in size
/// \throws NumericError in the reverse sweep, if ∂F/∂x is singular, as at a double root: a pivot is exactly 0
template <std::floating_point T, class Residual>
[[nodiscard]] std::vector<Variable<T>> implicit_function(
    Residual residual, std::type_identity_t<std::span<const T>> solution,
    std::type_identity_t<std::span<const Variable<T>>> parameters) {
  std::vector<Variable<T>> results(solution.begin(), solution.end());
  if (results.empty() || !detail::any_active<T>(parameters)) return results;
  auto& state = detail::TapeState<T>::require_active();
  for (const Variable<T>& parameter : parameters) state.require_own_if_active(parameter.link());
  using Record = detail::ImplicitRecord<T, Residual>;
  static_cast<void>(state.append_record(std::make_unique<Record>(std::move(residual), solution, parameters),
                                        results.size()));
  for (Variable<T>& result : results) result = {result.value(), state.append_input()};
  return results;
}
}  // namespace tapestry
