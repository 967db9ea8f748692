#pragma once
#include "operator_network.hpp"

namespace tapestry::test {
/// A network with tangents against central differences of the same network without, in double.
class TangentCheck {
 public:
  using Numbers = std::vector<double>;
  /// Largest errors, each by the size of what is compared.
  struct Errors {
    double value = 0;     ///< of y
    double tangent = 0;   ///< of ẏ
    double gradient = 0;  ///< of the adjoint of ẋ
    double second = 0;    ///< of the adjoint of x
    [[nodiscard]] double largest() const { return std::max({value, tangent, gradient, second}); }
  };
  /// \param x  values of the inputs, one behind the other
  /// \throws DomainError as Network::with_tangents(), or if an input holds no numbers
  TangentCheck(const nn::Network<double>& plain, Numbers x)
      : plain_(plain), both_(plain.with_tangents()), x_(std::move(x)), u_(random_values(x_.size(), 11)) {
    std::size_t place = 0;
    for (std::size_t i = 0; i < plain.input_count(); ++i) place += nn::size_of(plain.input_shape(i));
    if (place != x_.size() || both_.input_count() != 2 * plain.input_count())
      throw DomainError("TangentCheck: inputs that do not hold numbers");
  }

  /// \param smooth  number of outputs, from the first on, that hold floating-point numbers
  /// \param h  step of the differences
  [[nodiscard]] Errors errors(std::size_t smooth, double h = 6e-6) const {
    const auto moved = [&](double step) {
      Numbers all = x_;
      for (std::size_t i = 0; i < all.size(); ++i) all[i] += step * u_[i];
      return all;
    };
    const Run here = run(plain_, x_, smooth, 0, 1), up = run(plain_, moved(h), smooth, 0, 1),
              down = run(plain_, moved(-h), smooth, 0, 1);
    const Numbers of_values = run(plain_, x_, smooth, 0, 2).adjoint;
    Numbers inputs = x_;
    inputs.insert(inputs.end(), u_.begin(), u_.end());
    const Run both = run(both_, inputs, smooth, plain_.output_count(), 2);
    Errors errors;
    Numbers tangent(here.results.size()), second = of_values;
    for (std::size_t i = 0; i < tangent.size(); ++i) tangent[i] = (up.results[i] - down.results[i]) / (2 * h);
    for (std::size_t i = 0; i < second.size(); ++i) second[i] += (up.adjoint[i] - down.adjoint[i]) / (2 * h);
    const auto half = [](const Numbers& all, int which) {
      const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
      return which == 0 ? Numbers(all.begin(), middle) : Numbers(middle, all.end());
    };
    errors.value = distance(half(both.results, 0), here.results, here.results);
    errors.tangent = distance(half(both.results, 1), tangent, here.results);
    errors.second = distance(half(both.adjoint, 0), second, here.adjoint);
    errors.gradient = distance(half(both.adjoint, 1), here.adjoint, here.adjoint);
    return errors;
  }

 private:
  struct Run {
    Numbers results, adjoint;
  };
  /// ‖found − expected‖ by the larger of ‖expected‖, ‖scale‖ and 1; infinite for NaN.
  [[nodiscard]] static double distance(const Numbers& found, const Numbers& expected, const Numbers& scale) {
    double squares = 0, size = 1, other = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      squares += std::pow(found.at(i) - expected[i], 2);
      size += expected[i] * expected[i];
    }
    for (const double value : scale) other += value * value;
    const double error = std::sqrt(squares / std::max(size, other));
    return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
  }

  /// Results and inputs' adjoints for weights on the first `smooth` outputs, and those from `second` on.
  [[nodiscard]] static Run run(const nn::Network<double>& network, const Numbers& x, std::size_t smooth,
                               std::size_t second, std::size_t seeds) {
    std::vector<nn::Buffer<double>> inputs, weights;
    nn::NetworkPass<double> pass;
    const double* from = x.data();
    for (std::size_t i = 0; i < network.input_count(); ++i) {
      inputs.emplace_back(nn::size_of(network.input_shape(i)));
      std::copy_n(from, inputs.back().size(), inputs.back().data());
      from += inputs.back().size();
    }
    network.forward(addresses(inputs), pass, nn::Mode::input_gradient);
    Run result;
    std::vector<const double*> adjoints(network.output_count(), nullptr);
    weights.reserve(2 * smooth);
    for (const std::size_t first : {std::size_t(0), second}) {
      if (second == 0 && !weights.empty()) break;
      for (std::size_t o = 0; o < smooth; ++o) {
        const std::size_t count = nn::size_of(network.output_shape(first + o));
        result.results.insert(result.results.end(), pass.output(first + o), pass.output(first + o) + count);
        // Seeds a of values and b of tangents; a network without tangents takes either.
        const bool is_b = second == 0 ? seeds == 1 : first == second;
        const auto drawn = random_values(count, (is_b ? 100 : 200) + o);
        weights.emplace_back(count);
        std::ranges::copy(drawn, weights.back().data());
        adjoints[first + o] = weights.back().data();
      }
    }
    std::vector<Numbers> found;
    std::vector<double*> goals;
    for (const auto& input : inputs) found.emplace_back(input.size(), 0.0);
    for (Numbers& one : found) goals.push_back(one.data());
    network.adjoint(pass, adjoints, goals);
    for (const Numbers& one : found) result.adjoint.insert(result.adjoint.end(), one.begin(), one.end());
    return result;
  }

  const nn::Network<double>& plain_;
  nn::Network<double> both_;
  Numbers x_, u_;
};
}  // namespace tapestry::test
