#pragma once
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>

// What GradBench's programs for CoDiPack include under this name, on Tapestry's tape: names and arguments are
// theirs.

struct CoDiForwardRunner {
  using Real = tapestry::Dual<double>;
  using Gradient = double;
  static void codiSetGradient(Real& x, double tangent) { x = {x.value(), {tangent}}; }
  static double codiGetGradient(const Real& x) { return x.tangent(); }
};

template <int dimensions>
struct CoDiForwardRunnerVec {
  static constexpr int dim = dimensions;
  using Real = tapestry::Dual<double, dimensions>;
  using Gradient = double;
  static void codiSetGradient(Real& x, int direction, double tangent) {
    auto tangents = x.tangents();
    tangents[static_cast<std::size_t>(direction)] = tangent;
    x = {x.value(), tangents};
  }
  static double codiGetGradient(const Real& x, int direction) {
    return x.tangent(static_cast<std::size_t>(direction));
  }
  /// As many as CoDiPack's runner makes, most of the later ones without a direction.
  static int codiGetRuns(int size) { return size == 0 ? 0 : (2 * size - 1) / dim; }
};

/// Records on a tape of T between the start and the clean-up.
template <class T>
struct Recording {
  using Real = tapestry::Variable<T>;
  using Gradient = double;
  void codiStartRecording() { scope.emplace(tape.activate()); }
  void codiStopRecording() {}
  void codiAddInput(Real& x) { x = tape.input(x.value()); }
  void codiAddOutput(Real&) {}
  void codiEval() { tape.reverse(root); }
  void codiCleanup() {
    scope.reset();
    tape.clear();
  }

  tapestry::Tape<T> tape;
  std::optional<tapestry::ActiveScope<T>> scope;
  Real root;
};

struct CoDiReverseRunner : Recording<double> {
  void codiSetGradient(const Real& y, double) { root = y; }
  static double codiGetGradient(const Real& x) { return x.adjoint(); }
};

template <int count>
struct CoDiReverseRunnerVec : Recording<double> {
  void codiSetGradient(const Real& y, int number, double) { roots[static_cast<std::size_t>(number)] = y; }
  void codiEval() { adjoints.reverse(tape, roots); }
  double codiGetGradient(const Real& x, int number) const {
    return adjoints.of(x)[static_cast<std::size_t>(number)];
  }

  std::array<Real, count> roots;
  tapestry::AdjointVectors<double, count> adjoints;
};

struct CoDiReverseRunner2nd : Recording<tapestry::Dual<double>> {
  void codiAddInput(Real& x) { x = tape.input({x.value().value(), {1.0}}); }
  void codiSetGradient(const Real& y, double) { root = y; }
  static double codiGetGradient(const Real& x, std::size_t order, std::size_t) {
    return order == 1 ? x.adjoint().value() : x.adjoint().tangent();
  }
};
