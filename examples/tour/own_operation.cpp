// An operation of our own with its pullback, in five lines, and the check of it that everyone should make.
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/gradient_check.hpp>

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable;

namespace {
/// The elements in ascending order.
ArrayVariable<double, 1> sorted(const ArrayVariable<double, 1>& x) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return x.value()(a) < x.value()(b); });
  Array<double, 1> value(x.shape());
  for (std::size_t i = 0; i < order.size(); ++i) value(i) = x.value()(order[i]);

  const auto pullback = [order](const Array<double, 1>& value_adjoint, Array<double, 1>* x_adjoint) {
    for (std::size_t i = 0; i < order.size(); ++i) (*x_adjoint)(order[i]) += value_adjoint(i);
  };
  return record_array(value, pullback, x);
}

/// The distance between the sorted samples and the quantiles that they should have.
Variable<double> distance_to_quantiles(const ArrayVariable<double, 1>& samples) {
  Array<double, 1> quantiles(samples.shape());
  for (std::size_t i = 0; i < quantiles.size(); ++i)
    quantiles(i) = (static_cast<double>(i) + 0.5) / static_cast<double>(quantiles.size());
  return mean(abs(sorted(samples) - quantiles));
}
}  // namespace

int main() {
  const Array<double, 1> samples = {0.95, 0.12, 0.45, 0.33, 0.72};
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(samples);
  const Variable<double> distance = distance_to_quantiles(x);
  tape.reverse(distance);
  std::printf("distance %.4f, by sample", distance.value());
  for (const double entry : x.adjoint().storage()) std::printf(" %.1f", entry);
  const auto report = tapestry::check_tape_gradient(distance_to_quantiles, samples);
  std::printf("\ncheck %s: %zu entries\n", report.passed() ? "passed" : "failed", report.checked);
}
