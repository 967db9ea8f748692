#include <tapestry/autodiff.hpp>

#include <tapestry/autodiff/checkpoint.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/differential.hpp"
#include "differential/scalar_program.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape, tapestry::test::input_count,
    tapestry::test::Point, tapestry::test::ScalarProgram, tapestry::test::Wide;

// Random programs through every mode of the tape, against central differences in long double.

namespace {
using Gradient = std::array<double, input_count>;

/// The step of differences.
constexpr double h = 0x1p-13;

Point moved(const Point& point, std::size_t axis, double step) {
  Point result = point;
  result[axis] += step;
  return result;
}
/// All points where a program must avoid kinks.
std::vector<Point> points_around(const Point& point) {
  std::vector<Point> points = {point};
  for (std::size_t axis = 0; axis < input_count; ++axis)
    for (const double step : {-h, h}) points.push_back(moved(point, axis, step));
  return points;
}

/// The value of a program, its slopes and its second derivative along all axes at once, from differences.
struct Reference {
  double value = 0;
  Gradient slopes{};
  double curvature = 0;
  double size = 0;            ///< of the slopes, at least 1
  double curvature_size = 0;  ///< likewise
  bool is_smooth = true;
};

/// Differences of steps h and h/2, extrapolated. With T their distance, the rest is about T² by the size of
/// the slopes, where derivatives grow with their order by a constant factor; T above 10⁻⁵ of the size is not
/// smooth. Roundings: of values up to 20 in 25 operations whose slopes are at most 10, 2⁻⁶⁴ · 20 · 25 · 10 /
/// h = 2e-12.
Reference reference_of(const ScalarProgram& program) {
  const auto value = [&](const Gradient& direction, Wide step) {
    std::array<Wide, input_count> at;
    for (std::size_t i = 0; i < input_count; ++i)
      at[i] = static_cast<Wide>(program.point[i]) + step * static_cast<Wide>(direction[i]);
    return program(std::span<const Wide>(at));
  };
  Reference reference;
  const Wide centre = value({}, 0), step = static_cast<Wide>(h);
  reference.value = static_cast<double>(centre);
  reference.size = reference.curvature_size = 1;
  const auto take = [&](Wide wide, Wide narrow, double& size, Wide smooth) {
    const auto found = static_cast<double>((4 * narrow - wide) / 3);
    size = std::max(size, std::abs(found));
    if (!(std::abs(wide - narrow) <= smooth * static_cast<Wide>(size))) reference.is_smooth = false;
    return found;
  };
  for (std::size_t axis = 0; axis < input_count; ++axis) {
    Gradient direction{};
    direction[axis] = 1;
    const auto slope = [&](Wide s) { return (value(direction, s) - value(direction, -s)) / (2 * s); };
    reference.slopes[axis] = take(slope(step), slope(step / 2), reference.size, 1e-5L);
  }
  const Gradient diagonal = {1, 1, 1, 1};
  const auto curve = [&](Wide s) {
    return (value(diagonal, s) - 2 * centre + value(diagonal, -s)) / (s * s);
  };
  reference.curvature = take(curve(step), curve(step / 2), reference.curvature_size, 1e-4L);
  return reference;
}

/// Compares a mode with the reference. The tolerance 1e-9 is ten times the sum of the differences' error,
/// 1e-10, and of the tape's own: 25 operations of 4 ε, each of values up to 20 and magnified up to 1,000
/// times, 5e-10 at the worst.
void check_mode(const char* mode, const ScalarProgram& program, const Reference& reference, double value,
                std::span<const double> slopes) {
  const auto check = [&](const char* what, double found, double expected) {
    if (std::abs(found - expected) <= 1e-9 * reference.size) return;
    INFO(mode << ", " << what << "\n" << program.text());
    CHECK(found == expected);
  };
  check("value", value, reference.value);
  constexpr std::array<const char*, input_count> names = {"by x[0]", "by x[1]", "by x[2]", "by x[3]"};
  for (std::size_t i = 0; i < input_count; ++i) check(names[i], slopes[i], reference.slopes[i]);
}

using Variables = std::vector<Variable<double>>;

/// Computes a program by a tape; apart(rest, variables) records the instructions from `split` on.
template <class Apart>
double by_tape(const ScalarProgram& program, const Point& point, std::size_t split, Gradient& slopes,
               const Apart& apart) {
  static tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  tape.clear();
  Variables inputs(input_count);
  tape.input(point, inputs);
  Variables registers = inputs;
  program.run(registers, 0, split);
  const auto rest = [&program, split](std::span<const Variable<double>> all) {
    Variables further(all.begin(), all.end());
    program.run(further, split, program.size());
    return further.back();
  };
  const Variable<double> root = apart(rest, registers);
  tape.reverse(root);
  tape.adjoints(inputs, slopes);
  return root.value();
}
double by_plain_tape(const ScalarProgram& program, const Point& point, Gradient& slopes) {
  return by_tape(program, point, program.size(), slopes,
                 [](const auto& rest, const Variables& all) { return rest(all); });
}

void check_tapes(const ScalarProgram& program, const Reference& reference, std::uint64_t seed) {
  Gradient slopes{};
  double value = by_plain_tape(program, program.point, slopes);
  check_mode("plain", program, reference, value, slopes);
  const std::size_t split = seed % (program.size() + 1);
  const bool is_checkpoint = seed % 2 == 0;
  value = by_tape(program, program.point, split, slopes, [=](const auto& rest, const Variables& all) {
    if (!is_checkpoint) return tapestry::preaccumulate<double>(rest, all);
    const auto results = [rest](std::span<const Variable<double>> x) { return Variables{rest(x)}; };
    return tapestry::checkpoint<double>(results, all)[0];
  });
  check_mode(is_checkpoint ? "checkpoint" : "preaccumulate", program, reference, value, slopes);
}

void check_duals(const ScalarProgram& program, const Reference& reference) {
  using D = Dual<double, input_count>;
  std::array<D, input_count> inputs;
  for (std::size_t i = 0; i < input_count; ++i) inputs[i] = D::input(program.point[i], i);
  const D result = program(std::span<const D>(inputs));
  check_mode("dual", program, reference, result.value(), result.tangents());

  using Second = Dual<double>;
  static tapestry::Tape<Second> tape;
  const auto scope = tape.activate();
  tape.clear();
  std::vector<Variable<Second>> variables;
  for (const double entry : program.point) variables.push_back(tape.input(Second::input(entry)));
  tape.reverse(program(std::span<const Variable<Second>>(variables)));
  double curvature = 0;
  Gradient slopes{};
  for (std::size_t i = 0; i < input_count; ++i) {
    slopes[i] = variables[i].adjoint().value();
    curvature += variables[i].adjoint().tangent();
  }
  check_mode("tape of duals", program, reference, result.value(), slopes);
  // Differences of second order: 10⁻⁸ of the size by T = 10⁻⁴ as above, and by roundings 2⁻⁶⁴ · 5000 / h² =
  // 2e-8.
  if (std::abs(curvature - reference.curvature) <= 1e-6 * reference.curvature_size) return;
  INFO("second derivative along (1, 1, 1, 1)\n" << program.text());
  CHECK(curvature == reference.curvature);
}
}  // namespace

TEST_CASE("random scalar programs have the derivatives of differences in every mode of the tape",
          "[autodiff][differential]") {
  tapestry::test::DifferentialRun run("random scalar programs", 10);
  std::size_t smooth = 0;
  while (run.next()) {
    INFO(run.repeat());
    const ScalarProgram program(run.seed(), points_around);
    const Reference reference = reference_of(program);
    if (!reference.is_smooth || reference.size > 1000) continue;
    ++smooth;
    check_tapes(program, reference, run.seed());
    check_duals(program, reference);
  }
  std::cout << smooth << " of the programs were smooth\n";
  CHECK(smooth > 0);
}

TEST_CASE(
    "Hessians of random programs are the same where a part is a checkpoint whose results have adjoint 0",
    "[autodiff][differential]") {
  using Second = Dual<double>;
  using Seconds = std::vector<Variable<Second>>;
  ActiveTape<Second> tape;
  std::size_t curved = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const ScalarProgram program(seed, points_around);
    const std::size_t split = seed % (program.size() + 1);
    const auto rest = [&](std::span<const Variable<Second>> all) {
      Seconds further(all.begin(), all.end());
      program.run(further, split, program.size());
      return Seconds{further.back()};
    };
    // The second derivative of (f − f₀)² / 2 along (1, 1, 1, 1), by each input; f₀ is the value of f.
    const auto curvature = [&](bool is_checkpoint) {
      tape.clear();
      Seconds inputs;
      for (const double entry : program.point) inputs.push_back(tape.input(Second::input(entry)));
      Seconds registers = inputs;
      program.run(registers, 0, split);
      const Variable<Second> f =
          is_checkpoint ? tapestry::checkpoint<Second>(rest, registers)[0] : rest(registers)[0];
      tape.reverse(Variable<Second>(square(f - f.value().value()) / 2));
      Gradient result{};
      for (std::size_t i = 0; i < input_count; ++i) result[i] = inputs[i].adjoint().tangent();
      return result;
    };
    INFO(program.text());
    const Gradient expected = curvature(false);
    CHECK(curvature(true) == expected);
    if (expected != Gradient{}) ++curved;
  }
  CHECK(curved > 50);
}
