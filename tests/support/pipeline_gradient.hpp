#pragma once
#include <tapestry/autodiff/gradient_check.hpp>
#include <tapestry/camouflage/objective.hpp>
#include "active_tape.hpp"
#include "catch.hpp"

namespace tapestry::test {
/// Views for the objective; the texture decides T.
template <class T>
using ViewPointers = std::type_identity_t<typename camouflage::Objective<T>::Views>;

/// The objective's gradient by the texture parameter.
template <class T>
Array<T, 2> pipeline_gradient(camouflage::Objective<T>& objective, ViewPointers<T> views,
                              const Array<T, 2>& start) {
  ActiveTape<T> tape;
  const ArrayVariable<T, 2> parameter = tape.input(start);
  const Variable<T> total = objective(parameter, views);
  tape.reverse(total);
  return parameter.adjoint();
}

/// Checks fifty directions of the gradient against central differences.
inline void check_pipeline_gradient(camouflage::Objective<double>& objective, ViewPointers<double> views,
                                    const Array<double, 2>& start,
                                    const camouflage::PhotoSession* session = nullptr) {
  GradientCheckOptions check;
  check.tolerance = 1e-6;
  check.subset = 50;
  check.step = 1e-5;    // short, since every leaky unit within the step is a kink
  check.rounding = 24;  // differences at shorter steps grow as 1/h, by 20 ε|f| at most of 50 entries
  const auto report = check_tape_gradient(
      [&](const ArrayVariable<double, 2>& parameter) { return objective(parameter, views, session); }, start,
      check);
  INFO(report.to_text());
  CHECK(report.passed());
  CHECK(report.kinks.size() <= 5);
}
}  // namespace tapestry::test
