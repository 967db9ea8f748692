#include <tuple>

#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
template <class T>
double tolerance_of(std::size_t depth) {
  return 8 * static_cast<double>(depth + 1) * static_cast<double>(std::numeric_limits<T>::epsilon());
}

OperatorNetwork matmul(const nn::Shape& a, const nn::Shape& b, bool is_constant) {
  return operator_network("MatMul", {given(a, 1), is_constant ? weight(b, 2) : given(b, 2)});
}

/// a of extents [s, t, m, k] and b of [u, v, k, n], where s, t, u or v may be 1, in plain loops.
std::vector<double> product(const nn::Shape& a, const nn::Shape& b, const OperatorNetwork& test) {
  std::vector<double> y;
  for (std::size_t i = 0; i < std::max(a[0], b[0]); ++i)
    for (std::size_t j = 0; j < std::max(a[1], b[1]); ++j)
      for (std::size_t m = 0; m < a[2]; ++m)
        for (std::size_t n = 0; n < b[3]; ++n) {
          double sum = 0;
          for (std::size_t k = 0; k < a[3]; ++k)
            sum += test.operands[0].values[((i % a[0] * a[1] + j % a[1]) * a[2] + m) * a[3] + k] *
                   test.operands[1].values[((i % b[0] * b[1] + j % b[1]) * b[2] + k) * b[3] + n];
          y.push_back(sum);
        }
  return y;
}

OperatorNetwork gemm(bool turns_a, bool turns_b, const nn::Shape& c, bool is_constant) {
  const nn::Shape b = turns_b ? nn::Shape{37, 19} : nn::Shape{19, 37};
  auto test = operator_network(
      "Gemm",
      {given(turns_a ? nn::Shape{19, 5} : nn::Shape{5, 19}, 1), is_constant ? weight(b, 2) : given(b, 2)},
      {{"transA", std::int64_t(turns_a)}, {"transB", std::int64_t(turns_b)}, {"alpha", 0.5}, {"beta", -2.0}});
  if (c != nn::Shape{0}) test.operands.push_back(is_constant ? weight(c, 3) : given(c, 3));
  return test;
}
}  // namespace

TEMPLATE_TEST_CASE("products of no rows or columns are empty, those of no terms are 0 or C",
                   "[nn][network][product]", float, double) {
  using Pair = std::pair<nn::Shape, nn::Shape>;
  for (const bool is_constant : {false, true}) {
    for (const auto& [a, b] :
         {Pair{{0, 3}, {3, 2}}, Pair{{2, 3}, {3, 0}}, Pair{{0, 2, 3}, {3, 2}}, Pair{{0, 2, 3}, {0, 3, 2}}}) {
      CAPTURE(a, b, is_constant);
      CHECK(result_of<TestType>(matmul(a, b, is_constant)).empty());
      check_adjoints(matmul(a, b, is_constant));
    }
    CHECK(result_of<TestType>(matmul({2, 0}, {0, 3}, is_constant)) == std::vector<TestType>(6, 0));
    for (const auto& [rows, terms, columns] :
         {std::tuple(0U, 3U, 2U), std::tuple(2U, 3U, 0U), std::tuple(2U, 0U, 3U)})
      for (const bool turns : {false, true}) {
        CAPTURE(rows, terms, columns, turns, is_constant);
        const nn::Shape a = turns ? nn::Shape{terms, rows} : nn::Shape{rows, terms};
        const nn::Shape b = turns ? nn::Shape{columns, terms} : nn::Shape{terms, columns};
        const auto test = operator_network(
            "Gemm", {given(a, 1), is_constant ? weight(b, 2) : given(b, 2), given({1, columns}, 3)},
            {{"transA", std::int64_t(turns)}, {"transB", std::int64_t(turns)}, {"alpha", 0.5}});
        std::vector<TestType> expected;
        for (std::size_t i = 0; i < rows * columns; ++i)
          expected.push_back(static_cast<TestType>(test.operands[2].values[i % columns]));
        CHECK(result_of<TestType>(test) == expected);
        check_adjoints(test);
      }
  }
}

TEMPLATE_TEST_CASE("MatMul equals its definition, with stacks repeated", "[nn][network][product]", float,
                   double) {
  using Pair = std::pair<nn::Shape, nn::Shape>;
  for (const auto& [a, b] : {Pair{{2, 3, 4, 20}, {2, 3, 20, 33}}, Pair{{2, 3, 4, 20}, {1, 1, 20, 3}},
                             Pair{{2, 1, 7, 5}, {1, 3, 5, 6}}, Pair{{1, 3, 1, 300}, {2, 1, 300, 1}}})
    for (const bool is_constant : {false, true}) {
      CAPTURE(a, b, is_constant);
      const auto test = matmul(a, b, is_constant);
      CHECK(largest_difference(result_of<TestType>(test), product(a, b, test)) <=
            tolerance_of<TestType>(a[3]));
      check_adjoints(test);
    }
}

TEST_CASE("MatMul takes operands of any rank", "[nn][network][product]") {
  const auto check = [](const nn::Shape& a, const nn::Shape& b, const nn::Shape& shape, const nn::Shape& a4,
                        const nn::Shape& b4) {
    CAPTURE(a, b);
    const auto test = matmul(a, b, false);
    CHECK(test.network<double>().output_shape(0) == shape);
    CHECK(largest_difference(result_of<double>(test), product(a4, b4, test)) <= tolerance_of<double>(5));
    check_adjoints(test);
  };
  check({5}, {5}, {}, {1, 1, 1, 5}, {1, 1, 5, 1});
  check({5}, {3, 5, 2}, {3, 2}, {1, 1, 1, 5}, {1, 3, 5, 2});
  check({3, 4, 5}, {5}, {3, 4}, {1, 3, 4, 5}, {1, 1, 5, 1});
  check({4, 5}, {2, 3, 5, 2}, {2, 3, 4, 2}, {1, 1, 4, 5}, {2, 3, 5, 2});
}

TEST_CASE("a matrix times itself gets both adjoints", "[nn][network][product][gradient]") {
  OperatorNetwork test = matmul({3, 3}, {3, 3}, false);
  auto description = test.description();
  for (nn::Node& node : description.nodes)
    if (node.operation == "MatMul") node.inputs[1] = node.inputs[0];
  test.operands[1].values = test.operands[0].values;
  Objective ignored;
  const auto both = gradients_of(test, nn::Network<double>(description), ignored);
  const auto apart = gradients_of(test, test.network<double>(), ignored);
  for (std::size_t i = 0; i < 9; ++i) CHECK(both[0][i] == Approx(apart[0][i] + apart[1][i]).margin(1e-13));
}

TEMPLATE_TEST_CASE("Gemm equals its definition", "[nn][network][product]", float, double) {
  for (const bool turns_a : {false, true})
    for (const bool turns_b : {false, true})
      for (const nn::Shape& c : {nn::Shape{5, 37}, {37}, {1, 37}, {5, 1}, {1}, {}, {0}})
        for (const bool is_constant : {false, true}) {
          CAPTURE(turns_a, turns_b, c, is_constant);
          const auto test = gemm(turns_a, turns_b, c, is_constant);
          const auto &a = test.operands[0].values, &b = test.operands[1].values;
          std::vector<double> expected;
          for (std::size_t m = 0; m < 5; ++m)
            for (std::size_t n = 0; n < 37; ++n) {
              double sum = 0;
              for (std::size_t k = 0; k < 19; ++k)
                sum += a[turns_a ? k * 5 + m : m * 19 + k] * b[turns_b ? n * 19 + k : k * 37 + n];
              expected.push_back(0.5 * sum);
              if (c == nn::Shape{0}) continue;
              const std::size_t row = c.size() == 2 && c[0] > 1 ? m : 0;
              const std::size_t column = !c.empty() && c.back() > 1 ? n : 0;
              expected.back() -= 2 * test.operands[2].values[row * (c.empty() ? 1 : c.back()) + column];
            }
          CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance_of<TestType>(20));
          check_adjoints(test);
        }
}

TEST_CASE("products refuse what does not fit", "[nn][network][product]") {
  CHECK_THAT(refusal_of(matmul({2, 3}, {4, 5}, false)), contains("[2, 3] and [4, 5] cannot be multiplied"));
  CHECK_THAT(refusal_of(matmul({2, 2, 3}, {3, 3, 5}, false)), contains("cannot be multiplied"));
  CHECK_THAT(refusal_of(matmul({}, {3}, false)), contains("[] and [3] cannot be multiplied"));
  OperatorNetwork test = gemm(false, false, {37}, true);
  test.operands[1] = weight({18, 37}, 1);
  CHECK_THAT(refusal_of(test), contains("[5, 19] and [18, 37] cannot be multiplied"));
  test = gemm(false, false, {4, 37}, true);
  CHECK_THAT(refusal_of(test), contains("C is [4, 37], which is no [5, 37]"));
}
