#include <tapestry/autodiff/gradient_check.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::DomainError, tapestry::Tape, tapestry::Variable,
    tapestry::test::ActiveTape, tapestry::test::random_array;

namespace {
/// A user's operations: scale · x, and Σ x².
template <class T>
ArrayVariable<T, 1> scaled(const ArrayVariable<T, 1>& x, const Variable<T>& scale) {
  Array<T, 1> value = x.value();
  for (T& element : value.storage()) element *= scale.value();
  return record_array(
      value,
      [x = x.shared_value(), scale = scale.value()](const Array<T, 1>& value_adjoint, Array<T, 1>* x_adjoint,
                                                    T* scale_adjoint) {
        for (std::size_t i = 0; i < value_adjoint.size(); ++i) {
          if (x_adjoint != nullptr) (*x_adjoint)(i) += value_adjoint(i) * scale;
          if (scale_adjoint != nullptr) *scale_adjoint += value_adjoint(i) * (*x)(i);
        }
      },
      x, scale);
}

template <class T>
Variable<T> sum_of_squares(const ArrayVariable<T, 1>& x) {
  return record_scalar(
      tapestry::test::dot(x.value(), x.value()),
      [x = x.shared_value()](T value_adjoint, Array<T, 1>* x_adjoint) {
        for (std::size_t i = 0; i < x->size(); ++i) (*x_adjoint)(i) += 2 * (*x)(i)*value_adjoint;
      },
      x);
}
}  // namespace

TEMPLATE_TEST_CASE("user operations interleave with scalar statements", "[autodiff][record][gradient]", float,
                   double) {
  using T = TestType;
  const auto x0 = random_array<T>({7}, 1);
  const auto direction = tapestry::test::random_direction<T>({7}, 2);
  const auto loss = [](const ArrayVariable<T, 1>& x, const Variable<T>& s) {
    const Variable<T> first = sum_of_squares(scaled(x, s));
    const Variable<T> factor = first * s + 1;
    return Variable<T>(sum_of_squares(scaled(scaled(x, factor), Variable<T>(s * s))) / 8 + first);
  };
  ActiveTape<T> tape;
  const auto x = tape.input(x0);
  const Variable<T> s = tape.input(T(0.5));
  const Variable<T> root = loss(x, s);
  tape.reverse(root);
  tape.reverse(root);  // repeats
  const auto value = [&](const Array<T, 1>& at) { return loss(at, T(0.5)).value(); };
  const auto tolerance = tapestry::test::central_difference_tolerance(root.value());
  CHECK(std::abs(tapestry::test::dot(x.adjoint(), direction) -
                 tapestry::test::central_difference(value, x0, direction)) <= tolerance);
  const T h = tapestry::test::central_difference_step<T>();
  const T slope = (loss(x0, T(0.5) + h).value() - loss(x0, T(0.5) - h).value()) / (2 * h);
  CHECK(std::abs(s.adjoint() - slope) <= 8 * tolerance);  // third derivative by s below 8 · value
}

namespace {
/// sin x, with the cosine as a number of the tape's scalar, or as a plain one.
template <bool IsPlain, class T>
Variable<T> own_sine(const Variable<T>& x) {
  const auto slope = [&] {
    if constexpr (IsPlain) {
      return T(std::cos(tapestry::detail::value_of<double>(x)));
    } else {
      using std::cos;
      return T(cos(x.value()));
    }
  }();
  using std::sin;
  return tapestry::record_scalar(T(sin(x.value())),
                                 tapestry::CarriesTangents{[slope](T value_adjoint, T* x_adjoint) {
                                   *x_adjoint += value_adjoint * slope;
                                 }},
                                 x);
}
}  // namespace

TEST_CASE("an operation that carries tangents has second derivatives", "[autodiff][record]") {
  const auto f = [](auto x) { return x[0] * own_sine<false>(x[0]); };  // f″ = 2 cos x − x sin x
  CHECK(std::abs(tapestry::hessian(f, {0.7})[0] - (2 * std::cos(0.7) - 0.7 * std::sin(0.7))) <= 4e-16);
  const auto report = tapestry::check_hessian(f, std::vector<double>{0.7});
  INFO(report.to_text());
  CHECK(report.passed());
  const auto linear = [](auto x) {  // its slope is a constant that nothing captures
    using T = typename decltype(x)::value_type::value_type;
    const auto twice = [](T value_adjoint, T* x_adjoint) { *x_adjoint += 2 * value_adjoint; };
    return exp(tapestry::record_scalar(T(2 * x[0].value()), twice, x[0]));
  };
  CHECK(std::abs(tapestry::hessian(linear, {0.5})[0] - 4 * std::exp(1.0)) <= 4e-15);
}

TEST_CASE("an operation that wrongly states that it carries tangents is found by check_hessian",
          "[autodiff][record][gradient_check]") {
  const auto f = [](auto x) { return own_sine<true>(x[0]) + x[1] * x[1] * x[0]; };
  const auto report = tapestry::check_hessian(f, std::vector<double>{0.7, 2});
  INFO(report.to_text());
  CHECK(report.checked == 4);
  REQUIRE(report.failures.size() == 1);
  CHECK(report.failures[0].index == 0);
  CHECK(report.failures[0].analytic == 0);
  CHECK(std::abs(report.failures[0].numeric + std::sin(0.7)) <= 1e-9);
}

TEST_CASE("an operation of passive inputs records nothing and needs no tape", "[autodiff][record]") {
  const ArrayVariable<double, 1> x = random_array<double>({3}, 1);
  CHECK_FALSE(scaled(x, Variable<double>(2.0)).is_active());
  CHECK_FALSE(sum_of_squares(x).is_active());
  ActiveTape<double> tape;
  CHECK_FALSE(scaled(x, Variable<double>(2.0)).is_active());
  CHECK(tape.statement_count() == 0);
}

TEST_CASE("a passive input has no adjoint to add to", "[autodiff][record]") {
  ActiveTape<double> tape;
  const Array<double, 1> values = {1, 2};
  const Variable<double> s = tape.input(3.0);
  const auto y = scaled<double>(values, s);
  tape.reverse(y, values);
  CHECK(s.adjoint() == 5);
  bool saw_null = false;
  const auto z = tapestry::record_scalar(
      1.0,
      [&](double, double* by_s, Array<double, 1>* by_plain, double* by_number) {
        saw_null = by_s != nullptr && by_plain == nullptr && by_number == nullptr;
      },
      s * 2, values, 4);
  tape.reverse(z);
  CHECK(saw_null);
}

TEST_CASE("two inputs may be the same variable", "[autodiff][record]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2});
  const auto product = tapestry::record_scalar(
      5.0,
      [x](double g, Array<double, 1>* left, Array<double, 1>* right) {
        for (std::size_t i = 0; i < 2; ++i) {
          (*left)(i) += g * x.value()(i);
          (*right)(i) += g * x.value()(i);
        }
      },
      x, x);
  tape.reverse(product);
  CHECK(x.adjoint() == Array<double, 1>{2, 4});
}

TEST_CASE("branches nobody asked about are not pulled back", "[autodiff][record]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2});
  int calls = 0;
  const auto count_array = [&](const Array<double, 1>&, Array<double, 1>*) { ++calls; };
  const auto count_scalar = [&](double, Array<double, 1>*) { ++calls; };
  const auto unused = record_array(x.value(), count_array, x);
  const auto unused_scalar = tapestry::record_scalar(0.0, count_scalar, unused);
  const Variable<double> used = sum_of_squares(x);
  tape.reverse(Variable<double>(used + 0 * unused_scalar));
  CHECK(calls == 0);
  CHECK(unused.adjoint() == Array<double, 1>{0, 0});
  CHECK(x.adjoint() == Array<double, 1>{2, 4});
}

TEST_CASE("a record refuses inputs of another tape and a missing tape", "[autodiff][record]") {
  Tape<double> tape, other;
  const auto x = other.input(Array<double, 1>{1, 2});
  CHECK_THROWS_AS(sum_of_squares(x), DomainError);
  const auto scope = tape.activate();
  CHECK_THROWS_AS(sum_of_squares(x), DomainError);
  CHECK(tape.statement_count() == 0);
  const auto y = tape.input(Array<double, 1>{1, 2});
  tape.clear();
  CHECK_THROWS_AS(sum_of_squares(y), DomainError);
}

TEST_CASE("a throwing pullback leaves the tape usable", "[autodiff][record]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2});
  bool fails = true;
  const auto y = tapestry::record_scalar(
      3.0,
      [&](double g, Array<double, 1>* by_x) {
        if (fails) throw std::runtime_error("user");
        (*by_x)(0) += g;
      },
      x);
  CHECK_THROWS_AS(tape.reverse(y), std::runtime_error);
  fails = false;
  const Variable<double> z = y * 2;
  tape.reverse(z);
  CHECK(x.adjoint() == Array<double, 1>{2, 0});
}

TEST_CASE("a pullback that changes the extents of an adjoint is refused", "[autodiff][record][error]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2});
  bool replaces = true;
  const auto twice = [&](const Array<double, 1>& g, Array<double, 1>* by_x) {
    if (replaces)
      *by_x = Array<double, 1>{7};
    else
      *by_x += 2.0 * g;
  };
  const ArrayVariable<double, 1> y = tapestry::record_array(Array<double, 1>{2, 4}, twice, x);
  const auto total = [](const ArrayVariable<double, 1>& array) {
    const auto pullback = [](double g, Array<double, 1>* adjoint) { *adjoint += g; };
    return tapestry::record_scalar(array.value()(0) + array.value()(1), pullback, array);
  };
  const Variable<double> root = total(y) + total(x);
  CHECK_THROWS_WITH(tape.reverse(root),
                    "pullback: has changed the extents of the adjoint of an input [2]; it must add to it");
  replaces = false;
  tape.reverse(root);
  CHECK(x.adjoint() == Array<double, 1>{3, 3});
}

TEST_CASE("a pullback cannot record on the tape it runs on, but may use its own", "[autodiff][record]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(3.0);
  const auto greedy = tapestry::record_scalar(
      9.0, [&](double, double*) { static_cast<void>(tape.input(1.0)); }, x);
  CHECK_THROWS_AS(tape.reverse(greedy), DomainError);
  const auto formula = tapestry::record_scalar(
      9.0, [x](double, double*) { static_cast<void>(Variable<double>(x * x)); }, x);
  CHECK_THROWS_WITH(
      tape.reverse(formula),
      "an operation on an active variable cannot be recorded while reverse() sweeps its tape: a pullback, or "
      "a function that is computed again, takes values, or activates a tape of its own");
  const auto nested = tapestry::record_scalar(
      9.0,
      [x](double g, double* by_x) {
        Tape<double> local;
        const auto local_scope = local.activate();
        const Variable<double> again = local.input(x.value());
        local.reverse(Variable<double>(again * again), g);
        *by_x += again.adjoint();
      },
      x);
  tape.reverse(nested);
  CHECK(x.adjoint() == 6);
  CHECK(Variable<double>(x * x).is_active());
}

TEST_CASE("rewinding drops records and what they keep", "[autodiff][record]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2});
  const auto position = tape.mark();
  auto kept = std::make_shared<int>(1);
  for (int step = 0; step < 3; ++step) {
    const auto y = tapestry::record_scalar(
        1.0, [kept](double g, Array<double, 1>* by_x) { (*by_x)(1) += g * *kept; }, x);
    CHECK(kept.use_count() == 2);
    tape.reverse(y);
    CHECK(x.adjoint() == Array<double, 1>{0, 1});
    tape.rewind(position);
    CHECK(kept.use_count() == 1);
  }
  CHECK(tape.record_count() == 1);
}

TEST_CASE("an operation may have several results", "[autodiff][record]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2, 3});
  int calls = 0;
  const auto split = tapestry::record_arrays<double, 1>(
      {{1, 2}, {3}, {1, 2, 3}},
      [&](const std::vector<const Array<double, 1>*>& parts, Array<double, 1>* by_x) {
        ++calls;
        CHECK(parts[2] == nullptr);
        for (std::size_t i = 0; i < 3; ++i) {
          const Array<double, 1>* const part = parts[i / 2];
          if (part != nullptr) (*by_x)(i) += (*part)(i % 2);
        }
      },
      x);
  CHECK(tape.record_count() == 2);
  tape.reverse(Variable<double>(2 * sum_of_squares(split[0]) + sum_of_squares(split[1])));
  CHECK(x.adjoint() == Array<double, 1>{4, 8, 6});
  tape.reverse(sum_of_squares(split[1]));
  CHECK(x.adjoint() == Array<double, 1>{0, 0, 6});
  CHECK(calls == 2);
  tape.reverse(sum_of_squares(x));
  CHECK(calls == 2);
  tape.clear();
  CHECK_THROWS_AS(split[0].adjoint(), DomainError);
  CHECK_FALSE(tapestry::record_arrays<double, 1>(
                  {{1}}, [](auto&&...) {}, x.value())[0]
                  .is_active());
}

TEST_CASE("an operation may have a run-time number of inputs", "[autodiff][record]") {
  ActiveTape<double> tape;
  std::vector<ArrayVariable<double, 1>> parts;
  for (int i = 0; i < 3; ++i) parts.push_back(tape.input(Array<double, 1>{1.0 + i, 2.0}));
  parts.push_back(Array<double, 1>{5, 6});  // passive
  const Variable<double> scale = tape.input(2.0);
  Array<double, 1> sum = {0, 0};
  for (const auto& part : parts) sum += scale.value() * part.value();
  const auto pullback = [values = parts, scale = scale.value()](
                            const Array<double, 1>& g, const std::vector<Array<double, 1>*>& by_parts,
                            double* by_scale) {
    REQUIRE(by_parts.size() == 4);
    CHECK(by_parts[3] == nullptr);
    for (std::size_t i = 0; i < 4; ++i) {
      if (by_parts[i] != nullptr) *by_parts[i] += scale * g;
      *by_scale += tapestry::test::dot(g, values[i].value());
    }
  };
  const ArrayVariable<double, 1> total = tapestry::record_array(sum, pullback, parts, scale);
  CHECK(total.value() == Array<double, 1>{22, 24});
  tape.reverse(total, Array<double, 1>{1, 10});
  for (std::size_t i = 0; i < 3; ++i) CHECK(parts[i].adjoint() == Array<double, 1>{2, 20});
  CHECK(scale.adjoint() == 11 + 120);
}

TEST_CASE("a run-time number of inputs is checked one by one", "[autodiff][record][error]") {
  Tape<double> tape, other;
  const std::vector<ArrayVariable<double, 1>> none;
  const std::vector<ArrayVariable<double, 1>> mixed{Array<double, 1>{1}, other.input(Array<double, 1>{2})};
  const auto ignore = [](double, const std::vector<Array<double, 1>*>&) {};
  const auto scope = tape.activate();
  CHECK_FALSE(tapestry::record_scalar(0.0, ignore, none).is_active());
  CHECK_THROWS_AS(tapestry::record_scalar(0.0, ignore, mixed), DomainError);
  CHECK(tape.statement_count() == 0);
  const std::vector<ArrayVariable<double, 1>> own{tape.input(Array<double, 1>{1})};
  const auto replace = [](double, const std::vector<Array<double, 1>*>& by_own) {
    *by_own[0] = Array<double, 1>{1, 2};
  };
  CHECK_THROWS_AS(tape.reverse(tapestry::record_scalar(0.0, replace, own)), tapestry::ShapeError);
}
