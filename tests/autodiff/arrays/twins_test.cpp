#include <tapestry/autodiff/array_functions.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../function_rows.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable, tapestry::test::ActiveTape;

// Compares functions of arrays with those of the same name for vectors of variables.

namespace {
template <class T>
constexpr T infinity = std::numeric_limits<T>::infinity();
template <class T>
const T not_a_number = std::numeric_limits<T>::quiet_NaN();

/// Values of a function, and its slopes, one row a value.
template <class T>
struct Slopes {
  std::vector<T> values, rows;
};

/// \param f  of a vector of variables, returns one
template <class T, class Function>
Slopes<T> of_vector(const Function& f, const std::vector<T>& x) {
  ActiveTape<T> tape;
  std::vector<Variable<T>> inputs(x.size());
  tape.input(x, inputs);
  Slopes<T> result;
  for (const Variable<T>& root : std::vector<Variable<T>>(f(inputs))) {
    result.values.push_back(root.value());
    tape.reverse(root);
    for (const auto& input : inputs) result.rows.push_back(input.adjoint());
  }
  return result;
}
/// \param f  of an array, returns a vector of variables
template <class T, class Function>
Slopes<T> of_array(const Function& f, const std::vector<T>& x) {
  ActiveTape<T> tape;
  Array<T, 1> values(tapestry::Extents<1>{x.size()});
  for (std::size_t i = 0; i < x.size(); ++i) values.data()[i] = x[i];
  const ArrayVariable<T, 1> input = tape.input(values);
  Slopes<T> result;
  for (const Variable<T>& root : std::vector<Variable<T>>(f(input))) {
    result.values.push_back(root.value());
    tape.reverse(root);
    for (const T slope : input.adjoint().storage()) result.rows.push_back(slope);
  }
  return result;
}

/// Equal within eight roundings, infinities and NaN among them.
template <class T>
bool is_near(T a, T b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  return a == b || std::abs(a - b) <= 8 * std::numeric_limits<T>::epsilon() * std::abs(b);
}
template <class T>
void check_same(const Slopes<T>& array, const Slopes<T>& vector) {
  REQUIRE(array.values.size() == vector.values.size());
  for (std::size_t i = 0; i < array.values.size(); ++i) CHECK(is_near(array.values[i], vector.values[i]));
  for (std::size_t i = 0; i < array.rows.size(); ++i) {
    INFO("slope " << i << ": array " << array.rows[i] << ", vector " << vector.rows[i]);
    CHECK(is_near(array.rows[i], vector.rows[i]));
  }
}

/// Ordinary vectors, and those with ties, infinities, NaN, hugely different, tiny and huge entries.
template <class T>
std::vector<std::vector<T>> vectors() {
  const T inf = infinity<T>, nan = not_a_number<T>, tiny = std::numeric_limits<T>::denorm_min();
  const T large = std::numeric_limits<T>::max();
  return {{1, -2, T(0.5)}, {2, 2, 2},         {0, -20},    {0, -40},    {-40, 0, -40},
          {0, 0},          {-T(0.0), 0},      {3},         {1, nan, 3}, {nan, 1, 3},
          {3, 1, nan},     {nan, nan},        {inf, 1, 2}, {inf, -inf}, {inf, inf, 0},
          {-inf, 1, 2},    {-inf, -inf},      {inf, nan},  {nan, inf},  {3 * tiny, 4 * tiny},
          {large, large},  {large, -large, 0}};
}
template <class T, class OfArray, class OfVector>
void check_twins(const OfArray& array, const OfVector& vector) {
  for (const auto& x : vectors<T>()) {
    CAPTURE(x);
    check_same(of_array(array, x), of_vector(vector, x));
  }
}
template <class T>
std::vector<Variable<T>> elements_of(const ArrayVariable<T, 1>& x) {
  std::vector<Variable<T>> result;
  for (std::size_t i = 0; i < x.size(); ++i) result.push_back(element(x, {i}));
  return result;
}
}  // namespace

TEMPLATE_TEST_CASE("sums and lengths of arrays have the values and slopes of those of vectors",
                   "[autodiff][arrays]", float, double) {
  using T = TestType;
  using Vector = std::vector<Variable<T>>;
  check_twins<T>([](const auto& x) { return Vector{sum(x)}; }, [](const auto& x) { return Vector{sum(x)}; });
  check_twins<T>([](const auto& x) { return Vector{norm(x)}; },
                 [](const auto& x) { return Vector{norm(x)}; });
}

TEMPLATE_TEST_CASE("functions of the elements of arrays have the values and slopes of those of vectors",
                   "[autodiff][arrays]", float, double) {
  using T = TestType;
  tapestry::test::for_each_function([](const tapestry::test::FunctionRow& row, const auto& f) {
    CAPTURE(row.name);
    check_twins<T>([&](const auto& x) { return elements_of(ArrayVariable<T, 1>(f(x))); },
                   [&](const auto& x) {
                     std::vector<Variable<T>> all;
                     for (const auto& entry : x) all.push_back(f(entry));
                     return all;
                   });
  });
}

TEMPLATE_TEST_CASE("logsumexp and softmax of arrays have the values and slopes of those of vectors",
                   "[autodiff][arrays]", float, double) {
  using T = TestType;
  using Vector = std::vector<Variable<T>>;
  const auto total = [](const auto& x) { return Vector{logsumexp(x)}; };
  check_twins<T>([](const auto& x) { return Vector{tapestry::logsumexp<tapestry::Exponential::library>(x)}; },
                 total);
  check_twins<T>(
      [](const auto& x) {
        return elements_of(
            ArrayVariable<T, 1>(tapestry::softmax_along<tapestry::Exponential::library>(x, 0)));
      },
      [](const auto& x) { return softmax(x); });
}

TEMPLATE_TEST_CASE("extremes and bounds of arrays have the values and slopes of those of vectors",
                   "[autodiff][arrays]", float, double) {
  using T = TestType;
  using Vector = std::vector<Variable<T>>;
  const auto fold = [](const auto& choose) {
    return [&choose](const Vector& x) {
      Variable<T> best = x[0];
      for (std::size_t i = 1; i < x.size(); ++i) best = choose(best, x[i]);
      return Vector{best};
    };
  };
  // The first of equal ones, unlike max() and min().
  const auto larger = [](const auto& a, const auto& b) { return isnan(a) || a >= b ? a : b; };
  const auto smaller = [](const auto& a, const auto& b) { return isnan(a) || a <= b ? a : b; };
  check_twins<T>([](const auto& x) { return Vector{largest(x)}; }, fold(larger));
  check_twins<T>([](const auto& x) { return Vector{smallest(x)}; }, fold(smaller));
  check_twins<T>(
      [](const auto& x) { return Vector{element(ArrayVariable<T, 0>(tapestry::largest_along(x, 0)), {})}; },
      fold(larger));
  check_twins<T>([](const auto& x) { return elements_of(ArrayVariable<T, 1>(clamp(x, T(-1), T(2)))); },
                 [](const auto& x) {
                   Vector all;
                   for (const auto& entry : x) all.push_back(clamp(entry, T(-1), T(2)));
                   return all;
                 });
  for (const auto& x : vectors<T>()) {
    CAPTURE(x);
    const std::vector<T> ones(x.size(), T(1));
    const auto both =
        of_array<T>([](const auto& a) { return Vector{sum(max(a, 1 * a) + min(a, 1 * a))}; }, x);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!std::isnan(x[i])) CHECK(both.rows[i] == 2);
  }
  check_twins<T>(
      [](const auto& x) { return elements_of(ArrayVariable<T, 1>(max(x, T(0)) + min(x, T(1)) * abs(x))); },
      [](const auto& x) {
        Vector all;
        for (const auto& entry : x) all.push_back(max(entry, T(0)) + min(entry, T(1)) * abs(entry));
        return all;
      });
}
