#include <tapestry/autodiff.hpp>

#include <fstream>
#include <map>
#include <sstream>

#include "../support/catch.hpp"
#include "../support/paths.hpp"
#include "function_rows.hpp"

// Every function, and its derivatives up to the third, against reference/function_table.txt, which
// reference/make_function_table.py computed with many digits and without a formula of ours. The bounds here
// are those that the functions' comments state.

namespace {
using First = tapestry::Dual<double>;
using Second = tapestry::Dual<First>;
using Third = tapestry::Dual<Second>;
using Row = std::vector<double>;

/// The rows of every function: arguments, then the table's values for them.
const std::map<std::string, std::vector<Row>>& table() {
  static const auto rows = [] {
    std::map<std::string, std::vector<Row>> all;
    std::ifstream file(tapestry::test::in_sources("tests/autodiff/reference/function_table.txt"));
    std::string line, name;
    while (std::getline(file, line)) {
      std::istringstream words(line);
      std::string word;
      if (line.starts_with("f ")) {
        words >> word >> name;
        continue;
      }
      Row row;
      while (words >> word) row.push_back(__builtin_bit_cast(double, std::stoull(word, nullptr, 16)));
      all[name].push_back(row);
    }
    return all;
  }();
  return rows;
}

/// Distance in units in the last place of the reference, denormals have the spacing of the smallest. Sixteen
/// of these count as none: a formula may multiply its roundings there. Where the reference overflows, ∞ is
/// right, as is a number a rounding away from it.
double ulps(double found, double expected) {
  constexpr double largest = std::numeric_limits<double>::max() * (1 - 0x1p-50);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (found == expected) return 0;
  if (std::isinf(expected)) {
    return found * std::copysign(1.0, expected) >= largest ? 0 : infinity;
  }
  if (!std::isfinite(found))
    return found * std::copysign(1.0, expected) >= largest && std::abs(expected) >= largest ? 0 : infinity;
  if (std::abs(found - expected) <= 16 * std::numeric_limits<double>::denorm_min()) return 0;
  int exponent = 0;
  std::frexp(expected, &exponent);
  const int last = std::max(exponent - 53, -1074);
  return std::ldexp(std::abs(found - expected), -last);
}

template <class Function>
Row derivatives_of_one(const Function& f, double x) {
  const Third y = f(Third::input(Second::input(First::input(x))));
  return {y.value().value().value(), y.tangent().value().value(), y.tangent().tangent().value(),
          y.tangent().tangent().tangent()};
}

template <class Function>
Row derivatives_of_two(const Function& f, double x, double y) {
  const Row along_x = derivatives_of_one([&](const Third& v) { return f(v, Third(y)); }, x);
  const Row along_y = derivatives_of_one([&](const Third& v) { return f(Third(x), v); }, y);
  const Second mixed = f(Second::input(First(x)), Second(First::input(y)));
  return {along_x[0], along_x[1], along_y[1], along_x[2], mixed.tangent().tangent(),
          along_y[2], along_x[3], along_y[3]};
}

/// Sizes that errors are relative to where a derivative passes through 0: by order, for these arguments and
/// references.
using Sizes = std::array<double, 4>;
Sizes no_size(const Row&) { return {0, 0, 0, 0}; }

struct Worst {
  std::array<double, 4> error{};
  std::array<double, 4> at{}, found{}, expected{};
};

template <class Found, class SizesOf>
Worst worst_of(const std::string& name, std::size_t arguments, const Found& found_at,
               const SizesOf& sizes_of) {
  constexpr std::array orders_of_one{0, 1, 2, 3}, orders_of_two{0, 1, 1, 2};
  constexpr std::array later_orders_of_two{2, 2, 3, 3};
  Worst worst;
  for (const Row& row : table().at(name)) {
    const Row found = found_at(row);
    const Sizes sizes = sizes_of(row);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const auto order = static_cast<std::size_t>(arguments == 1 ? orders_of_one[i]
                                                  : i < 4        ? orders_of_two[i]
                                                                 : later_orders_of_two[i - 4]);
      const double expected = row[arguments + i];
      if (name == "atan2" && order == 3 && std::isinf(expected) && std::isnan(found[i])) continue;  // ∞ − ∞
      const double difference = std::abs(found[i] - expected) / (0x1p-53 * sizes[order]);
      const double error = std::fmin(ulps(found[i], expected), sizes[order] > 0 ? difference : 1e300);
      if (error > worst.error[order]) {
        worst.error[order] = error;
        worst.at[order] = row[0];
        worst.found[order] = found[i];
        worst.expected[order] = expected;
      }
    }
  }
  return worst;
}

void check_bounds(const std::string& name, const Worst& worst, const std::array<double, 4>& bounds) {
  for (std::size_t order = 0; order < 4; ++order) {
    INFO(name << ", derivative " << order << " at " << worst.at[order] << ": " << worst.found[order]
              << ", expected " << worst.expected[order]);
    CHECK(worst.error[order] <= bounds[order]);
  }
}

/// Terms of derivatives whose sums cancel; the bound of digamma beside its roots below −20 is absolute.
Sizes sizes_by_name(const std::string& name, const Row& row) {
  const double by_root = row[0] < -20 ? 0x1p-10 : 0;
  if (name == "sigmoid") return {0, 0, 0, row[2]};
  if (name == "atan") return {0, 0, 0, 2 * row[2] * row[2]};
  if (name == "tanh") return {0, 0, 0, 2 * row[2]};
  if (name == "asinh") return {0, 0, 0, row[2] * row[2] * row[2]};
  if (name == "erf" || name == "erfc") return {0, 0, 0, (4 * row[0] * row[0] + 2) * std::abs(row[2])};
  if (name == "lgamma") return {0, by_root, 0, 0};
  if (name == "digamma") return {4 * by_root, 0, 0, 0};
  if (name != "tgamma") return {0, 0, 0, 0};
  const double psi = std::abs(tapestry::digamma(row[0])), psi1 = tapestry::polygamma<1>(row[0]);
  const double terms = psi * psi * psi + 3 * psi * psi1 + std::abs(tapestry::polygamma<2>(row[0]));
  return {0, by_root * std::abs(row[1]), 0, terms * std::abs(row[1])};
}

template <class Function, class SizesOf = decltype(&no_size)>
void check_two(const std::string& name, const std::array<double, 4>& bounds, const Function& f,
               const SizesOf& sizes_of = &no_size) {
  check_bounds(name,
               worst_of(
                   name, 2, [&](const Row& row) { return derivatives_of_two(f, row[0], row[1]); }, sizes_of),
               bounds);
}
}  // namespace

TEST_CASE("functions of one number are as near to many digits as they say", "[autodiff][table]") {
  tapestry::test::for_each_function([](const tapestry::test::FunctionRow& function, const auto& f) {
    const std::string name = function.name;
    const auto found = [&](const Row& row) { return derivatives_of_one(f, row[0]); };
    check_bounds(name, worst_of(name, 1, found, [&](const Row& row) { return sizes_by_name(name, row); }),
                 {function.f, function.f1, function.f2, function.f3});
  });
}

TEST_CASE("functions of two numbers are as near to many digits as they say", "[autodiff][table]") {
  check_two(
      "logsumexp", {2, 4, 5, 8}, [](auto x, auto y) { return logsumexp(x, y); },
      [](const Row& row) {
        return Sizes{std::abs(row[0]) + std::abs(row[1]), 0, 0, row[5]};
      });
  check_two(
      "atan2", {1, 4, 5, 8}, [](auto y, auto x) { return atan2(y, x); },
      [](const Row& row) {
        return Sizes{0, 0, 0, 2 / std::pow(std::hypot(row[0], row[1]), 3)};
      });
  check_two("divide", {1, 2, 5, 8}, [](auto x, auto y) { return x / y; });
  check_two("pow", {2, 4, 5, 8}, [](auto x, auto y) { return pow(x, y); });
  const auto sizes = [](const Row& row) {  // below the normal numbers where the length overflows
    const double length = row[2];
    return Sizes{0, 0, std::isinf(length) ? 0x1p-1022 * 0x1p53 : 0, 2 / (length * length)};
  };
  check_two(
      "hypot", {1, 4, 5, 8}, [](auto x, auto y) { return hypot(x, y); }, sizes);
  check_two(
      "hypot3", {1, 4, 5, 8}, [](auto x, auto y) { return hypot(x, y, 2); }, sizes);
}

TEST_CASE("fmod and remainder are exact between their jumps", "[autodiff][table]") {
  check_two("fmod", {0, 0, 0, 0}, [](auto x, auto y) { return fmod(x, y); });
  check_two("remainder", {0, 0, 0, 0}, [](auto x, auto y) { return remainder(x, y); });
}
