#include <tapestry/autodiff.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/differential.hpp"
#include "differential/array_program.hpp"

using tapestry::Array, tapestry::test::ActiveTape, tapestry::test::ArrayProgram;
using Wide = ArrayProgram::Wide;

namespace {
constexpr double h = 0x1p-13;

/// The slope along a direction by the tape's adjoints of all inputs.
struct OnTape {
  double value = 0;
  std::array<double, 2> slopes{};
};
OnTape on_tape(const ArrayProgram& program) {
  static tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  tape.clear();
  const std::array<ArrayProgram::A, 2> arrays = {tape.input(program.point.arrays[0]),
                                                 tape.input(program.point.arrays[1])};
  const auto scalar = tape.input(program.point.scalar);
  const auto root = program(arrays, scalar);
  tape.reverse(root, 0.5);
  tape.reverse(root);  // forgets the first
  OnTape found{root.value(), {}};
  for (std::size_t d = 0; d < 2; ++d) {
    const ArrayProgram::Point& direction = program.directions[d];
    found.slopes[d] = scalar.adjoint() * direction.scalar;
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t i = 0; i < direction.arrays[k].size(); ++i)
        found.slopes[d] += arrays[k].adjoint().data()[i] * direction.arrays[k].data()[i];
  }
  return found;
}
}  // namespace

TEST_CASE("random programs of arrays have the derivatives of differences", "[autodiff][differential]") {
  tapestry::test::DifferentialRun run("random array programs", 10);
  std::size_t smooth = 0;
  while (run.next()) {
    const ArrayProgram program(run.seed(), h);
    INFO(run.repeat());
    const auto check = [&](double at, double expected) {
      if (std::abs(at - expected) <= 1e-9 * std::max(1.0, std::abs(expected))) return;
      INFO(program.text());
      CHECK(at == expected);
    };
    const OnTape found = on_tape(program);
    const auto value = static_cast<double>(program.reference(program.directions[0], 0));
    // Tolerance: roundings of exponentials and of sums of up to 90,000 elements up to 20 in ten operations,
    // and of the extrapolated differences of steps h and h/2, see differential_test.cpp.
    check(found.value, value);
    for (std::size_t d = 0; d < 2; ++d) {
      const auto slope = [&](Wide s) {
        return (program.reference(program.directions[d], s) - program.reference(program.directions[d], -s)) /
               (2 * s);
      };
      const Wide wide = slope(static_cast<Wide>(h)), narrow = slope(static_cast<Wide>(h) / 2);
      const auto expected = static_cast<double>((4 * narrow - wide) / 3);
      const double size = std::max(1.0, std::abs(expected));
      if (std::abs(static_cast<double>(wide - narrow)) > 1e-5 * size || size > 1000) continue;
      ++smooth;
      check(found.slopes[d], expected);
    }
  }
  std::cout << smooth << " of the slopes were smooth\n";
  CHECK(smooth > 0);
}
