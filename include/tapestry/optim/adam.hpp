#pragma once
#include <cmath>
#include <span>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>

namespace tapestry::optim {
/// Settings of Adam; the defaults are the FCA paper's.
struct AdamSettings {
  double learning_rate = 0.01;
  double beta1 = 0.9;     ///< memory of the gradient's mean, in [0, 1)
  double beta2 = 0.999;   ///< memory of the gradient's square, in [0, 1)
  double epsilon = 1e-8;  ///< added to √v̂, in units of the gradient, at least 0
};

/// Everything that Adam keeps from step to step; a checkpoint holds exactly this.
template <std::floating_point T>
struct AdamState {
  std::vector<T> first_moment;   ///< m, one a parameter
  std::vector<T> second_moment;  ///< v, one a parameter
  std::uint64_t step = 0;        ///< steps taken so far
};

/// Adam: gradient descent with each parameter's step scaled by its gradient's recent size.
///
///   m ← β₁m + (1 − β₁)g        m̂ = m / (1 − β₁ᵗ)
///   v ← β₂v + (1 − β₂)g²       v̂ = v / (1 − β₂ᵗ)
///   x ← x − η · m̂ / (√v̂ + ε)
///
/// Source: Kingma and Ba, ICLR 2015, algorithm 1. Moments are kept in T, the arithmetic of a step is in
/// double. The same bits for any number of threads, and after state() and restore(). A gradient that is NaN
/// makes its parameter NaN; check before the step to stop there.
template <std::floating_point T>
class Adam {
 public:
  /// \param count  number of parameters
  /// \throws DomainError if a setting is outside its range
  explicit Adam(std::size_t count, const AdamSettings& settings = {}) : settings_(settings) {
    const auto memory_fits = [](double beta) { return beta >= 0 && beta < 1; };
    if (!memory_fits(settings.beta1) || !memory_fits(settings.beta2))
      throw DomainError("Adam: beta1 and beta2 must lie in [0, 1)");
    if (!(settings.epsilon >= 0)) throw DomainError("Adam: epsilon must be at least 0");
    if (!std::isfinite(settings.learning_rate)) throw DomainError("Adam: learning_rate must be finite");
    state_.first_moment.assign(count, T(0));
    state_.second_moment.assign(count, T(0));
  }

  /// One step of all parameters.
  ///
  /// \param parameters  x, changed in place
  /// \param gradient    g = ∂loss/∂x, in the same order
  /// \throws ShapeError if either has another length than the optimiser was made for
  void step(std::span<T> parameters, std::span<const T> gradient) {
    require_length("parameters", parameters.size());
    require_length("gradient", gradient.size());
    ++state_.step;
    const auto t = static_cast<double>(state_.step);
    const double mean_scale = settings_.learning_rate / (1 - std::pow(settings_.beta1, t));
    const double square_scale = 1 / (1 - std::pow(settings_.beta2, t));
    parallel_for_vectors(
        parameters.size(), [
          =, beta1 = settings_.beta1, beta2 = settings_.beta2, epsilon = settings_.epsilon,
          g = gradient.data(), x = parameters.data(), first = state_.first_moment.data(),
          second = state_.second_moment.data()
        ](std::size_t i) __attribute__((always_inline)) {
          const auto slope = static_cast<double>(g[i]);
          const double m = blend(beta1, static_cast<double>(first[i]), slope);
          const double v = blend(beta2, static_cast<double>(second[i]), slope * slope);
          first[i] = static_cast<T>(m);
          second[i] = static_cast<T>(v);
          const double least = m == 0 ? 1 : epsilon;  // not 0 / 0 when ε = 0
          const double change = mean_scale * m / (std::sqrt(v * square_scale) + least);
          x[i] = static_cast<T>(static_cast<double>(x[i]) - change);
        });
  }

  /// The same of arrays: step(parameter, parameter_variable.adjoint()).
  /// \throws ShapeError also if the extents differ
  template <std::size_t Rank>
  void step(Array<T, Rank>& parameters, const Array<T, Rank>& gradient) {
    require_shape("Adam", "gradient", gradient, parameters.shape());
    step(std::span<T>(parameters.data(), parameters.size()),
         std::span<const T>(gradient.data(), gradient.size()));
  }

  [[nodiscard]] const AdamSettings& settings() const { return settings_; }

  /// For schedules; the moments stay.
  void set_learning_rate(double learning_rate) { settings_.learning_rate = learning_rate; }

  [[nodiscard]] const AdamState<T>& state() const { return state_; }

  /// Continues from a saved state.
  /// \throws ShapeError if it belongs to another number of parameters
  void restore(AdamState<T> state) {
    require_length("first_moment", state.first_moment.size());
    require_length("second_moment", state.second_moment.size());
    state_ = std::move(state);
  }

 private:
  static double blend(double memory, double old, double now) { return memory * old + (1 - memory) * now; }

  void require_length(const char* argument, std::size_t length) const {
    if (length == state_.first_moment.size()) return;
    throw ShapeError({"Adam: ", argument, " has ", length, " values, expected ", state_.first_moment.size()});
  }

  AdamSettings settings_;
  AdamState<T> state_;
};
}  // namespace tapestry::optim
