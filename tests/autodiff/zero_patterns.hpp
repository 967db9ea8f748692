#pragma once
#include <Eigen/LU>
#include <tapestry/autodiff/eigen.hpp>
#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

/// Solves of systems with every pattern of zeros, on the tape and in duals, against Gauss elimination in
/// duals.
namespace tapestry::test {
/// A x = b of n equations. The inputs are the entries of A, row by row, and those of b if it is active.
struct System {
  Eigen::Index n;
  std::vector<double> entries;  // A, then b
  bool has_active_side;
};

using Slopes = Dual<double, 12>;  // by up to 9 + 3 inputs
template <class S>
using AnySize = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

/// X of A X = B by Gauss elimination with pivoting. It leaves out no number that is 0.
inline AnySize<Slopes> eliminate(AnySize<Slopes> a, AnySize<Slopes> b) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k; i < n; ++i)
      if (std::abs(a(i, k).value()) > std::abs(a(pivot, k).value())) pivot = i;
    for (Eigen::Index j = 0; j < n; ++j) std::swap(a(k, j), a(pivot, j));
    for (Eigen::Index j = 0; j < b.cols(); ++j) std::swap(b(k, j), b(pivot, j));
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i == k) continue;
      const Slopes factor = a(i, k) / a(k, k);
      for (Eigen::Index j = 0; j < n; ++j) a(i, j) -= factor * a(k, j);
      for (Eigen::Index j = 0; j < b.cols(); ++j) b(i, j) -= factor * b(k, j);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < b.cols(); ++j) b(i, j) /= a(i, i);
  return b;
}

/// A and b of a system, of one column or of two: b, and b from below.
template <class S, int Size, int Columns>
struct Sides {
  Eigen::Matrix<S, Size, Size> a;
  Eigen::Matrix<S, Size, Columns> b;

  Sides(const System& system, const std::vector<S>& inputs) : a(system.n, system.n), b(system.n, Columns) {
    for (Eigen::Index i = 0; i < system.n; ++i) {
      for (Eigen::Index j = 0; j < system.n; ++j)
        a(i, j) = inputs[static_cast<std::size_t>(i * system.n + j)];
      const S side = inputs[static_cast<std::size_t>(system.n * system.n + i)];
      b(i, 0) = side;
      if constexpr (Columns == 2) b(system.n - 1 - i, 1) = side;
    }
  }
};

inline std::vector<Slopes> duals_of(const System& system) {
  std::vector<Slopes> inputs;
  for (std::size_t k = 0; k < system.entries.size(); ++k)
    inputs.push_back(system.has_active_side || k < static_cast<std::size_t>(system.n * system.n)
                         ? Slopes::input(system.entries[k], k)
                         : Slopes(system.entries[k]));
  return inputs;
}

/// Counts of slopes of X that are far from the expected ones.
template <int Size, int Columns, class Solve>
int wrong_slopes(const System& system, const AnySize<Slopes>& expected, const Solve& solve) {
  int wrong = 0;
  const auto compare = [&](double found, double right) {
    wrong += std::abs(found - right) <= 1e-11 * std::max(1.0, std::abs(right)) ? 0 : 1;
  };
  const Sides<Slopes, Size, Columns> of_duals(system, duals_of(system));
  const AnySize<Slopes> x = solve(of_duals.a, of_duals.b);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      for (std::size_t k = 0; k < 12; ++k) compare(x(i, j).tangent(k), expected(i, j).tangent(k));

  ActiveTape<double> tape;
  std::vector<Variable<double>> inputs;
  for (std::size_t k = 0; k < system.entries.size(); ++k)
    inputs.push_back(system.has_active_side || k < static_cast<std::size_t>(system.n * system.n)
                         ? tape.input(system.entries[k])
                         : Variable<double>(system.entries[k]));
  const Sides<Variable<double>, Size, Columns> of_variables(system, inputs);
  const AnySize<Variable<double>> y = solve(of_variables.a, of_variables.b);
  for (Eigen::Index i = 0; i < y.rows(); ++i)
    for (Eigen::Index j = 0; j < y.cols(); ++j) {
      compare(y(i, j).value(), expected(i, j).value());
      if (y(i, j).is_active()) tape.reverse(y(i, j));
      for (std::size_t k = 0; k < inputs.size(); ++k)
        compare(y(i, j).is_active() ? inputs[k].adjoint() : 0.0, expected(i, j).tangent(k));
    }
  return wrong;
}

/// Solves all systems by solve(a, b), of fixed and dynamic size, for a vector and a matrix. The solution
/// is equation(a)'s, a matrix.
template <class Equation, class Solve>
void check_solves(const std::string& name, const std::vector<System>& systems, const Equation& equation,
                  const Solve& solve) {
  int wrong = 0;
  for (const System& system : systems) {
    const Sides<Slopes, Eigen::Dynamic, 2> sides(system, duals_of(system));
    const AnySize<Slopes> expected = eliminate(equation(sides.a), sides.b);
    wrong += wrong_slopes<Eigen::Dynamic, 1>(system, expected, solve);
    wrong += wrong_slopes<Eigen::Dynamic, 2>(system, expected, solve);
    if (system.n == 3) wrong += wrong_slopes<3, 1>(system, expected, solve);
  }
  INFO(name << ", " << systems.size() << " systems");
  CHECK(systems.size() > 30);
  CHECK(wrong == 0);
}

/// The same for systems whose solution is a's own.
template <class Solve>
void check_solves(const std::string& name, const std::vector<System>& systems, const Solve& solve) {
  check_solves(
      name, systems, [](const AnySize<Slopes>& a) { return a; }, solve);
}

/// Appends systems of one A: sides with a pattern of zeros, and sides whose solution has one.
inline void append_sides(std::vector<System>& systems, Eigen::Index n, const std::vector<double>& a,
                         unsigned first_pattern, unsigned pattern_count) {
  const std::array<double, 3> numbers = {1, -2, 0.5};
  for (unsigned pattern = first_pattern; pattern < first_pattern + pattern_count; ++pattern)
    for (const bool is_of_solution : {false, true}) {
      std::vector<double> side(static_cast<std::size_t>(n), 0.0), entries = a;
      for (std::size_t i = 0; i < side.size(); ++i)
        if ((pattern >> i & 1U) != 0) side[i] = numbers[i];
      for (std::size_t i = 0; i < side.size(); ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < side.size(); ++j) sum += a[i * side.size() + j] * side[j];
        entries.push_back(is_of_solution ? sum : side[i]);
      }
      for (const bool is_active : {false, true})
        if (n == 2 || is_active == ((systems.size() + pattern) % 3 != 0))
          systems.push_back({n, entries, is_active});
    }
}

/// Systems of every pattern of zeros in A, of 2 and 3 equations, that are not singular.
/// \param is_kept  of a pattern: bit i·n + j is set where A[i, j] is not 0
template <class IsKept>
std::vector<System> systems_where(const std::array<double, 9>& numbers, unsigned side_count,
                                  const IsKept& is_kept) {
  std::vector<System> systems;
  for (const unsigned n : {2U, 3U})
    for (unsigned pattern = 0; pattern < 1U << (n * n); ++pattern) {
      if (!is_kept(n, pattern)) continue;
      std::vector<double> a;
      for (unsigned k = 0; k < n * n; ++k) {
        const unsigned place = n == 3 ? k : k / 2 * 3 + k % 2;
        a.push_back((pattern >> k & 1U) != 0 ? numbers[place] : 0.0);
      }
      const Eigen::Map<const Eigen::MatrixXd> map(a.data(), n, n);
      if (std::abs(map.determinant()) < 0.1) continue;
      if (n == 2) append_sides(systems, n, a, 0, 4);
      if (n == 3) append_sides(systems, n, a, pattern % 8, side_count);
    }
  return systems;
}

/// The same of any pattern, of numbers that pivoting reorders, with three of the eight patterns of each side.
inline std::vector<System> general_systems() {
  return systems_where({4, 1, -2, 0.5, 8, 1, -16, 2, 4}, 3, [](unsigned, unsigned) { return true; });
}
/// The same of a diagonal that is not 0 and triangles of equal patterns, with every pattern of each side.
inline std::vector<System> diagonal_systems(const std::array<double, 9>& numbers) {
  return systems_where(numbers, 8, [](unsigned n, unsigned pattern) {
    const auto has = [&](unsigned i, unsigned j) { return (pattern >> (i * n + j) & 1U) != 0; };
    for (unsigned i = 0; i < n; ++i)
      for (unsigned j = 0; j <= i; ++j)
        if (has(i, j) != has(j, i) || !has(i, i)) return false;
    return true;
  });
}
}  // namespace tapestry::test
