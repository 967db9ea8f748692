#include "../../../support/operator_case.hpp"

using namespace tapestry;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
const std::vector<std::string> reductions = {"ReduceSum",       "ReduceMean",     "ReduceMax", "ReduceMin",
                                             "ReduceProd",      "ReduceL1",       "ReduceL2",  "ReduceLogSum",
                                             "ReduceLogSumExp", "ReduceSumSquare"};
constexpr double infinity = std::numeric_limits<double>::infinity();
}  // namespace

TEST_CASE("adjoints of reductions agree with central differences",
          "[nn][network][reduction][gradient][repeated]") {
  for (const std::string& name : reductions)
    for (const std::int64_t keepdims : {0, 1}) {
      const auto check = [&](nn::Shape shape, const Integers& axes) {
        check_operator({name, {shape}, {{"axes", axes}, {"keepdims", keepdims}}, {}, 11, 0.5, 2});
        const OperatorCase newer{
            name, {shape}, {{"keepdims", keepdims}}, {{1, integers({axes.begin(), axes.end()})}}, 18, 0.5, 2};
        check_operator(newer);
      };
      for (const Integers& axes : {Integers{1}, Integers{3}, Integers{2, 3}, Integers{-1, 0}, Integers{1, 3},
                                   Integers{0, 1, 2, 3}, Integers{1, 2, 3}})
        check({2, 3, 4, 2}, axes);
      check({3}, {0});
      check({2, 3, 2}, {-2});
      check_operator({name, {{2, 3, 4, 2}}, {{"keepdims", keepdims}}, {}, 18, 0.5, 2});
      const std::map<std::string, nn::Attribute> is_noop{{"keepdims", keepdims},
                                                         {"noop_with_empty_axes", std::int64_t(1)}};
      for (const nn::Shape& shape : {nn::Shape{2, 3, 2}, nn::Shape{2, 3, 2, 2}})
        check_operator({name, {shape}, is_noop, {}, 18, 0.5, 2});
    }
  check_operator({"ReduceL1", {{2, 3, 4, 2}}, {{"axes", Integers{2}}}, {}, 13, -1, 1, {0}});
  check_operator({"ReduceLogSumExp", {{70, 70}}, {{"axes", Integers{0}}}, {}, 13, -2, 2});
}

TEST_CASE("reductions take the values of their definitions", "[nn][network][reduction]") {
  const auto of = [](const std::string& name) {
    return results_of({name, {{2, 3}}, {{"axes", Integers{1}}, {"keepdims", std::int64_t(0)}}, {}, 11},
                      {{1, 2, 3, 4, 5, 6}});
  };
  CHECK(of("ReduceSum") == std::vector<double>{6, 15});
  CHECK(of("ReduceMean") == std::vector<double>{2, 5});
  CHECK(of("ReduceMax") == std::vector<double>{3, 6});
  CHECK(of("ReduceMin") == std::vector<double>{1, 4});
  CHECK(of("ReduceProd") == std::vector<double>{6, 120});
  CHECK(of("ReduceL1") == std::vector<double>{6, 15});
  CHECK(of("ReduceL2") == std::vector<double>{std::sqrt(14.0), std::sqrt(77.0)});
  CHECK(of("ReduceLogSum") == std::vector<double>{std::log(6.0), std::log(15.0)});
  CHECK(of("ReduceSumSquare") == std::vector<double>{14, 77});
  CHECK(of("ReduceLogSumExp")[0] == Approx(3 + std::log(1 + std::exp(-1.0) + std::exp(-2.0))).epsilon(1e-15));
  const OperatorCase mean{"ReduceMean", {{2}}, {}, {}, 18};
  CHECK(results_of(mean, {{-3, 0}}, nn::ElementType::integer) == std::vector<double>{-1});
}

TEST_CASE("a product's adjoint counts zeros right", "[nn][network][reduction][gradient]") {
  OperatorRun run(description_of({"ReduceProd", {{2, 3}}, {{"axes", Integers{1}}}, {}, 13}));
  const double x[] = {2, 0, 3, 0, 5, 0};
  std::copy_n(x, 6, run.inputs[0].data());
  run.forward(nn::Mode::input_gradient);
  CHECK(run.gradient(1)[0] == std::vector<double>{1, 1 + 6 * std::cos(1.0), 1, 1, 1, 1});
}

TEST_CASE("extremes give the first of equal elements the adjoint, and NaN comes first",
          "[nn][network][reduction]") {
  for (const char* name : {"ReduceMax", "ReduceMin"}) {
    OperatorRun run(description_of({name, {{2, 3}}, {{"axes", Integers{1}}}, {}, 13}));
    const double x[] = {4, 4, 4, 1, std::nan(""), 2};
    std::copy_n(x, 6, run.inputs[0].data());
    run.forward(nn::Mode::input_gradient);
    CHECK(run.results()[0] == 4);
    CHECK(std::isnan(run.results()[1]));
    CHECK(run.gradient(1)[0] == std::vector<double>{1 + std::cos(1.0), 1, 1, 1, 1 + std::cos(2.0), 1});
  }
}

TEST_CASE("logarithms of sums of exponentials stay finite far out", "[nn][network][reduction]") {
  const OperatorCase given{"ReduceLogSumExp", {{5, 2}}, {{"axes", Integers{1}}}, {}, 13};
  const auto y =
      results_of(given, {{1e300, 1e300, -1e300, -1e300, 700, 800, -infinity, -infinity, infinity, 0}});
  CHECK(y[0] == 1e300);
  CHECK(y[1] == -1e300);
  CHECK(y[2] == 800);
  CHECK(y[3] == -infinity);
  CHECK(y[4] == infinity);
}

TEST_CASE("adjoints of softmax agree with central differences", "[nn][network][reduction][gradient]") {
  for (const char* name : {"Softmax", "LogSoftmax"}) {
    for (const std::int64_t axis : {-4, 1, 2, 3}) {
      check_operator({name, {{2, 3, 4, 2}}, {{"axis", axis}}, {}, 13, -3, 3});
      check_operator({name, {{2, 3, 4, 2}}, {{"axis", axis}}, {}, 11, -3, 3});
    }
    check_operator({name, {{4, 5}}, {}, {}, 13, -3, 3});
    check_operator({name, {{2, 3, 4}}, {}, {}, 9, -3, 3});
    check_operator({name, {{2, 3, 1, 70}}, {{"axis", std::int64_t(1)}}, {}, 13, -3, 3});
    check_operator({name, {{1, 2, 1, 150}}, {{"axis", std::int64_t(3)}}, {}, 13, -3, 3});
  }
}

TEST_CASE("softmax adds to one, does not see a common shift, and stays finite far out",
          "[nn][network][reduction]") {
  const std::vector<double> x = {1, 2, 3, 1001, 1002, 1003, -2000, 0, 1e300};
  const auto y = results_of({"Softmax", {{3, 3}}}, {x}),
             logarithm = results_of({"LogSoftmax", {{3, 3}}}, {x});
  const double sum = 1 + std::exp(1.0) + std::exp(2.0);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(y[i] == Approx(std::exp(static_cast<double>(i)) / sum).epsilon(1e-14));
    CHECK(logarithm[i] == Approx(static_cast<double>(i) - std::log(sum)).epsilon(1e-14));
    CHECK(y[i + 3] == y[i]);
    CHECK(logarithm[i + 3] == logarithm[i]);
  }
  CHECK(std::vector<double>(y.begin() + 6, y.end()) == std::vector<double>{0, 0, 1});
  CHECK(logarithm[8] == 0);
}

TEST_CASE("axes of reductions that make no sense are refused", "[nn][network][reduction]") {
  CHECK(complaint_of({"ReduceMean", {{2, 3}}, {{"axes", Integers{2}}}, {}, 13}) == "axis 2 of 2 axes");
  CHECK(complaint_of({"ReduceMean", {{2, 3}}, {{"axes", Integers{0, -2}}}, {}, 13}) ==
        "axis -2 is named twice");
  CHECK(complaint_of({"ReduceMean", {{}}, {{"axes", Integers{0}}}, {}, 13}) == "a scalar has no axes");
  CHECK(complaint_of({"ReduceMean", {{2, 3}}, {{"axes", Integers{0}}}, {}, 18}) ==
        "attribute 'axes' is not supported");
  CHECK(complaint_of({"ReduceSum", {{2, 3}, {1}}}) ==
        "input 1 is computed; only a constant one is supported");
  CHECK(complaint_of({"Softmax", {{2, 3}}, {{"axis", std::int64_t(2)}}}) == "axis 2 of 2 axes");
  CHECK(complaint_of({"Softmax", {{}}, {{"axis", std::int64_t(0)}}}) == "a scalar has no axes");
}
