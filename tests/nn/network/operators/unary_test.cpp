#include "../../../support/operator_case.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
std::vector<OperatorCase> smooth_cases() {
  const std::vector<nn::Shape> picture = {{2, 3, 2, 3}};
  return {
      {"Relu", picture, {}, {}, 14, -2, 2, {0}},
      {"LeakyRelu", picture, {{"alpha", 0.25}}, {}, 16, -2, 2, {0}},
      {"Sigmoid", picture, {}, {}, 13, -4, 4},
      {"HardSigmoid", picture, {}, {}, 6, -4, 4, {-2.5, 2.5}},
      {"HardSigmoid", picture, {{"alpha", 0.5}, {"beta", 0.25}}, {}, 6, -2, 2, {-0.5, 1.5}},
      {"HardSwish", picture, {}, {}, 14, -5, 5, {-3, 3}},
      {"HardMish", picture, {}, {}, 18, -5, 5, {-2, 0}},
      {"Mish", picture, {}, {}, 18, -4, 4},
      {"Swish", picture, {}, {}, 13, -4, 4},
      {"Swish", picture, {{"alpha", 1.5}}, {}, 24, -4, 4},
      {"Elu", picture, {{"alpha", 0.5}}, {}, 6, -2, 2, {0}},
      {"Selu", picture, {}, {}, 6, -2, 2, {0}},
      {"Celu", picture, {{"alpha", 2.0}}, {}, 12, -2, 2, {0}},
      {"Softplus", picture, {}, {}, 1, -4, 4},
      {"Softsign", picture, {}, {}, 1, -4, 4, {0}},
      {"ThresholdedRelu", picture, {{"alpha", 0.5}}, {}, 10, -2, 2, {0.5}},
      {"Tanh", picture, {}, {}, 13, -3, 3},
      {"Gelu", picture, {}, {}, 20, -3, 3},
      {"Gelu", picture, {{"approximate", std::string("tanh")}}, {}, 20, -3, 3},
      {"Erf", picture, {}, {}, 13, -2, 2},
      {"Exp", picture, {}, {}, 13, -2, 2},
      {"Log", picture, {}, {}, 13, 0.5, 3},
      {"Sqrt", picture, {}, {}, 13, 0.5, 3},
      {"Reciprocal", picture, {}, {}, 13, 0.5, 3},
      {"Abs", picture, {}, {}, 13, -2, 2, {0}},
      {"Neg", picture, {}, {}, 13, -2, 2},
      {"Sin", picture, {}, {}, 7, -3, 3},
      {"Cos", picture, {}, {}, 7, -3, 3},
      {"Atan", picture, {}, {}, 7, -3, 3},
      {"Tan", picture, {}, {}, 7, -1.2, 1.2},
      {"Asin", picture, {}, {}, 7, -0.9, 0.9},
      {"Acos", picture, {}, {}, 7, -0.9, 0.9},
      {"Sinh", picture, {}, {}, 9, -2, 2},
      {"Cosh", picture, {}, {}, 9, -2, 2},
      {"Asinh", picture, {}, {}, 9, -3, 3},
      {"Acosh", picture, {}, {}, 9, 1.3, 4},
      {"Atanh", picture, {}, {}, 9, -0.9, 0.9},
      {"Shrink", picture, {{"lambd", 0.5}, {"bias", 0.25}}, {}, 9, -2, 2, {-0.5, 0.5}},
      {"Clip", picture, {{"min", -0.5}, {"max", 0.75}}, {}, 6, -2, 2, {-0.5, 0.75}},
      {"Clip", picture, {}, {{1, numbers({}, {-0.5})}, {2, numbers({}, {0.75})}}, 13, -2, 2, {-0.5, 0.75}},
      {"Sigmoid", {{5}}, {}, {}, 13, -4, 4},
      {"Sigmoid", {{2, 3, 1, 2, 2}}, {}, {}, 13, -4, 4},
  };
}
}  // namespace

TEST_CASE("adjoints of functions of each element agree with central differences", "[nn][network][gradient]") {
  for (const OperatorCase& given : smooth_cases()) check_operator(given);
}

TEST_CASE("functions of each element take the values of their definitions", "[nn][network]") {
  const std::vector<double> x = {-2, -0.5, 0, 1, 3};
  const auto of = [&](const char* name) { return results_of({name, {{5}}}, {x}); };
  CHECK(of("Relu") == std::vector<double>{0, 0, 0, 1, 3});
  CHECK(of("LeakyRelu") == std::vector<double>{-0.02, -0.005, 0, 1, 3});
  CHECK(of("Abs") == std::vector<double>{2, 0.5, 0, 1, 3});
  CHECK(of("Sign") == std::vector<double>{-1, -1, 0, 1, 1});
  CHECK(of("Not") == std::vector<double>{0, 0, 1, 0, 0});
  CHECK(of("Floor") == std::vector<double>{-2, -1, 0, 1, 3});
  CHECK(of("Ceil") == std::vector<double>{-2, 0, 0, 1, 3});
  CHECK(of("HardSwish")[4] == 3);
  CHECK(of("HardMish") == std::vector<double>{0, -0.375, 0, 1, 3});
  CHECK(of("ThresholdedRelu") == std::vector<double>{0, 0, 0, 0, 3});
  const auto near = [&](const char* name, auto function) {
    const auto y = of(name);
    for (std::size_t i = 0; i < x.size(); ++i) {
      CAPTURE(name, x[i]);
      CHECK(y[i] == Approx(function(x[i])).epsilon(4e-15).margin(1e-300));
    }
  };
  near("Sigmoid", [](double v) { return 1 / (1 + std::exp(-v)); });
  near("Swish", [](double v) { return v / (1 + std::exp(-v)); });
  near("Mish", [](double v) { return v * std::tanh(std::log1p(std::exp(v))); });
  near("Softplus", [](double v) { return std::log1p(std::exp(v)); });
  near("Softsign", [](double v) { return v / (1 + std::abs(v)); });
  near("Elu", [](double v) { return v > 0 ? v : std::expm1(v); });
  near("Gelu", [](double v) { return v * 0.5 * (1 + std::erf(v / std::sqrt(2.0))); });
  near("Tanh", [](double v) { return std::tanh(v); });
  near("Tan", [](double v) { return std::tan(v); });
  near("Sinh", [](double v) { return std::sinh(v); });
  near("Cosh", [](double v) { return std::cosh(v); });
  near("Asinh", [](double v) { return std::asinh(v); });
  near("Exp", [](double v) { return std::exp(v); });
}

TEST_CASE("inverse functions end where their ranges do", "[nn][network]") {
  const auto of = [](const char* name, double x) { return results_of({name, {{1}}}, {{x}}).at(0); };
  CHECK(of("Asin", 1) == std::asin(1.0));
  CHECK(of("Acos", -1) == std::acos(-1.0));
  CHECK(of("Acosh", 1) == 0);
  CHECK(of("Atanh", 1) == std::numeric_limits<double>::infinity());
  for (const auto& [name, x] :
       {std::pair("Asin", 1.5), std::pair("Acos", -2.0), std::pair("Acosh", 0.5), std::pair("Atanh", 3.0)})
    CHECK(std::isnan(of(name, x)));
}

TEST_CASE("a shrinkage keeps what lies between its ends at 0, and NaN", "[nn][network]") {
  const OperatorCase shrink{"Shrink", {{6}}, {{"lambd", 1.0}, {"bias", 0.5}}};
  const auto y = results_of(shrink, {{-2, -1, 0.5, 1, 3, std::nan("")}});
  CHECK(std::vector<double>(y.begin(), y.end() - 1) == std::vector<double>{-1.5, 0, 0, 0, 2.5});
  CHECK(std::isnan(y.back()));
}

TEST_CASE("infinities are told by their sign where that is asked for", "[nn][network]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> x = {infinity, -infinity, 1, std::nan("")};
  CHECK(results_of({"IsInf", {{4}}}, {x}) == std::vector<double>{1, 1, 0, 0});
  CHECK(results_of({"IsInf", {{4}}, {{"detect_negative", std::int64_t(0)}}}, {x}) ==
        std::vector<double>{1, 0, 0, 0});
  CHECK(results_of({"IsInf", {{4}}, {{"detect_positive", std::int64_t(0)}}}, {x}) ==
        std::vector<double>{0, 1, 0, 0});
}

TEST_CASE("halves are rounded to the even integer", "[nn][network]") {
  CHECK(results_of({"Round", {{9}}}, {{-2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 2.4, 2.6, 4503599627370497.0}}) ==
        std::vector<double>{-2, -2, 0, 0, 2, 2, 2, 3, 4503599627370497.0});
}

TEST_CASE("a clip keeps to the upper bound where the lower one is above it", "[nn][network]") {
  const OperatorCase clip{"Clip", {{3}}, {}, {{1, numbers({}, {2.0})}, {2, numbers({}, {1.0})}}};
  CHECK(results_of(clip, {{0, 1.5, 3}}) == std::vector<double>{1, 1, 1});
}

TEMPLATE_TEST_CASE("functions of each element stay finite far out, and NaN stays NaN", "[nn][network]", float,
                   double) {
  using Limits = std::numeric_limits<TestType>;
  const TestType far = Limits::max() / 4;
  for (const char* name :
       {"Relu",  "LeakyRelu", "Sigmoid", "HardSigmoid", "HardSwish", "HardMish", "Mish",
        "Swish", "Elu",       "Selu",    "Celu",        "Softplus",  "Softsign", "ThresholdedRelu",
        "Tanh",  "Gelu",      "Erf",     "Abs",         "Neg",       "Floor",    "Ceil",
        "Round", "Sign",      "Atan",    "Clip"}) {
    const nn::Network<TestType> network(test::description_of({name, {{5}}, {}, {}, 20}));
    nn::Buffer<TestType> x(5);
    const TestType values[] = {far, -far, 100, -100, Limits::quiet_NaN()};
    std::copy_n(values, 5, x.data());
    nn::NetworkPass<TestType> pass;
    network.forward({x.data()}, pass, nn::Mode::input_gradient);
    std::vector<TestType> weights(4, TestType(1)), gradient(5);
    weights.push_back(0);
    network.adjoint(pass, {weights.data()}, {gradient.data()});
    CAPTURE(name);
    for (std::size_t i = 0; i < 4; ++i) {
      CAPTURE(values[i], pass.output(0)[i], gradient[i]);
      CHECK(std::isfinite(pass.output(0)[i]));
      CHECK(std::isfinite(gradient[i]));
    }
    CHECK(std::isnan(pass.output(0)[4]));
  }
}

TEMPLATE_TEST_CASE("functions in loops of vectors keep to their bound", "[nn][network]", float, double) {
  const std::size_t count = 8001;
  const std::pair<const char*, long double (*)(long double)> functions[] = {
      {"Sigmoid", [](long double v) { return 1 / (1 + std::exp(-v)); }},
      {"Swish", [](long double v) { return v / (1 + std::exp(-v)); }},
      {"Exp", [](long double v) { return std::exp(v); }},
      {"Mish", [](long double v) { return v * std::tanh(std::log1p(std::exp(v))); }},
      {"Tanh", [](long double v) { return std::tanh(v); }},
      {"Softplus", [](long double v) { return std::log1p(std::exp(v)); }}};
  for (const auto& [name, function] : functions)
    for (const TestType largest : {TestType(80), TestType(0.5)}) {
      const nn::Network<TestType> network(test::description_of({name, {{count}}}));
      nn::Buffer<TestType> x(count);
      for (std::size_t i = 0; i < count; ++i) x.data()[i] = largest * (static_cast<TestType>(i) / 4000 - 1);
      nn::NetworkPass<TestType> pass;
      network.forward({x.data()}, pass);
      long double worst = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const long double expected = function(static_cast<long double>(x.data()[i]));
        const long double error = std::abs(static_cast<long double>(pass.output(0)[i]) - expected);
        if (expected != 0) worst = std::max(worst, error / std::abs(expected));
      }
      const auto epsilons =
          static_cast<double>(worst) / static_cast<double>(std::numeric_limits<TestType>::epsilon());
      CAPTURE(name, largest);
      CHECK(epsilons <= 8);
    }
}

TEST_CASE("large tensors get the same values and bits of signs as small ones", "[nn][network]") {
  const std::size_t count = 200003;
  const nn::Network<float> network(test::description_of({"LeakyRelu", {{count}}}, true));
  nn::Buffer<float> x(count);
  for (std::size_t i = 0; i < count; ++i) x.data()[i] = i % 3 == 0 ? -1.0F : 2.0F;
  nn::NetworkPass<float> pass;
  network.forward({x.data()}, pass, nn::Mode::input_gradient);
  std::vector<float> weights(count, 1.0F), gradient(count, 0.5F);
  network.adjoint(pass, {weights.data()}, {gradient.data()});
  bool is_right = true;
  for (std::size_t i = 0; i < count; ++i)
    is_right = is_right && pass.output(0)[i] == (i % 3 == 0 ? -0.01F : 2.0F) &&
               gradient[i] == (i % 3 == 0 ? 0.51F : 1.5F);
  CHECK(is_right);
}

TEST_CASE("settings of functions that make no sense are refused", "[nn][network]") {
  CHECK(complaint_of({"Gelu", {{2}}, {{"approximate", std::string("fast")}}, {}, 20}) ==
        "approximate is 'fast', expected 'none' or 'tanh'");
  CHECK(complaint_of({"LeakyRelu", {{2}}, {{"alpha", std::string("a")}}}) ==
        "attribute 'alpha' is not a number");
  CHECK(complaint_of({"Relu", {{2}}, {{"alpha", 1.0}}}) == "attribute 'alpha' is not supported");
  CHECK(complaint_of({"Clip", {{2}}, {}, {{1, numbers({2}, {0, 1})}}}) == "min has 2 elements, expected 1");
  CHECK(complaint_of({"Clip", {{2}, {}}}) == "input 1 is computed; only a constant one is supported");
  CHECK(complaint_of({"Relu", {}}) == "0 operands, expected 1");
}
