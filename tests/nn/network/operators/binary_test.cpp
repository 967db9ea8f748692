#include "../../../support/operator_case.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// Pairs of extents with every way of repeating an operand.
const std::vector<std::vector<nn::Shape>> pairs = {
    {{2, 3, 2, 3}, {2, 3, 2, 3}},  // alike
    {{2, 3, 2, 3}, {}},            // a scalar
    {{1}, {2, 3, 2, 3}},
    {{2, 3, 2, 3}, {3, 1, 1}},  // a number a channel
    {{2, 3, 2, 3}, {2, 3, 1, 1}},
    {{2, 3, 2, 3}, {2, 1, 2, 3}},  // a picture for all channels
    {{2, 3, 2, 3}, {3}},           // a row
    {{2, 3, 2, 3}, {2, 1}},        // a column
    {{2, 1, 2, 1}, {3, 1, 4}},     // both repeated
    {{4, 1}, {1, 5}},
    {{2, 1, 3, 1, 2}, {4, 1, 2, 1}},  // five axes
};

/// Results by the definition: each element's coordinates, modulo the operand's extents.
std::vector<double> repeated(const nn::Shape& shape, const nn::Shape& operand,
                             const nn::Buffer<double>& values) {
  std::vector<double> all;
  for (std::size_t i = 0; i < nn::size_of(shape); ++i) {
    std::size_t rest = i, place = 0, stride = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      const std::size_t extent = shape[shape.size() - 1 - axis], at = rest % extent;
      rest /= extent;
      if (axis >= operand.size()) continue;
      const std::size_t own = operand[operand.size() - 1 - axis];
      place += at % own * stride;
      stride *= own;
    }
    all.push_back(values.data()[place]);
  }
  return all;
}
}  // namespace

TEST_CASE("operands are repeated along axes of extent 1 and those that they lack", "[nn][network]") {
  for (const auto& shapes : pairs) {
    const OperatorCase given{"Sub", shapes};
    OperatorRun run(description_of(given));
    run.draw(given, 3);
    run.forward(nn::Mode::inference);
    CAPTURE(shapes);
    const nn::Shape& shape = run.network.output_shape(0);
    const auto a = repeated(shape, shapes[0], run.inputs[0]), b = repeated(shape, shapes[1], run.inputs[1]);
    const auto results = run.results();
    for (std::size_t i = 0; i < results.size(); ++i) CHECK(results[i] == a[i] - b[i]);
  }
}

TEST_CASE("adjoints of functions of two operands agree with central differences", "[nn][network][gradient]") {
  for (const auto& shapes : pairs) {
    for (const char* name : {"Add", "Sub", "Mul", "Sum", "Mean"}) check_operator({name, shapes});
    for (const char* name : {"Div", "Pow"}) check_operator({name, shapes, {}, {}, 15, 0.5, 2});
    check_operator({"Mod", shapes, {{"fmod", std::int64_t(1)}}, {}, 13, 1.5, 1.9});
    check_operator({"Max", shapes});
    check_operator({"Min", shapes});
  }
  for (const nn::Shape& slope : std::vector<nn::Shape>{{3, 1, 1}, {}, {1}, {2, 3, 2, 3}, {3}})
    check_operator({"PRelu", {{2, 3, 2, 3}, slope}, {}, {}, 16, -1, 1, {0}});
  check_operator({"PRelu", {{4, 3}, {3}}, {}, {}, 9, -1, 1, {0}});
}

TEST_CASE("adjoints of any number of operands agree with central differences", "[nn][network][gradient]") {
  for (const char* name : {"Sum", "Mean", "Max", "Min"}) {
    check_operator({name, {{2, 3, 2, 2}}});
    check_operator({name, {{2, 3, 2, 2}, {3, 1, 1}, {2, 3, 1, 2}, {2}}});
    check_operator({name, {{1, 3}, {2, 1}, {2, 3}}});
  }
}

TEST_CASE("adjoints of constant operands beside computed ones are left out", "[nn][network][gradient]") {
  check_operator({"Mul", {{2, 3, 2, 2}}, {}, {{1, numbers({3, 1, 1}, {2, -1, 3})}}});
  check_operator({"Div", {{2, 3, 2, 2}}, {}, {{0, numbers({}, {2})}}, 14, 1, 2});
  check_operator({"Pow", {{2, 3, 2, 2}}, {}, {{1, numbers({}, {2})}}});
  check_operator({"Where", {{2, 2, 2, 2}, {2, 2, 2, 2}}, {}, {{0, numbers({2, 1, 1}, {1, 0})}}});
  check_operator(
      {"Where", {{2, 1, 3}, {3}}, {}, {{0, numbers({2, 2, 3}, {1, 0, 1, 1, 0, 0, 0, 1, 0, 1, 1, 0})}}});
}

TEST_CASE("a value that is both operands gets the sum of both adjoints", "[nn][network][gradient]") {
  for (const char* name : {"Mul", "Add", "Div", "Pow", "Sum", "Max"})
    for (const bool is_behind : {false, true}) {
      auto description = description_of({name, {{2, 3}}}, is_behind);
      nn::Node& node = description.nodes.back();
      node.inputs.push_back(node.inputs[0]);
      OperatorRun run(description);
      run.draw({name, {}, {}, {}, 17, 0.5, 2}, 5);
      CAPTURE(name, is_behind);
      CHECK(adjoint_error(run, 1) <= 1);
    }
}

TEST_CASE("slopes of PRelu are weights that training changes", "[nn][network][gradient]") {
  const nn::Network<double> network(
      description_of({"PRelu", {{1, 2, 1, 2}}, {}, {{1, numbers({2, 1, 1}, {0.25, 0.5})}}}));
  REQUIRE(network.weight_blocks().size() == 1);
  nn::Buffer<double> x(4);
  const double values[] = {-1, 2, -3, -4};
  std::copy_n(values, 4, x.data());
  nn::NetworkPass<double> pass;
  network.forward({x.data()}, pass, nn::Mode::training);
  std::vector<double> weights(4, 1.0), gradient(2, 10.0);
  network.adjoint(pass, {weights.data()}, {nullptr}, gradient.data());
  CHECK(gradient == std::vector<double>{9, 3});
}

TEST_CASE("integers are divided towards zero, and remainders take the sign that ONNX says", "[nn][network]") {
  const auto type = nn::ElementType::integer;
  const std::vector<std::vector<double>> values = {{-7, 7, -7, 7, 6}, {2, -2, -2, 2, 3}};
  CHECK(results_of({"Div", {{5}, {5}}}, values, type) == std::vector<double>{-3, -3, 3, 3, 2});
  CHECK(results_of({"Mod", {{5}, {5}}}, values, type) == std::vector<double>{1, -1, -1, 1, 0});
  CHECK(results_of({"Mod", {{5}, {5}}, {{"fmod", std::int64_t(1)}}}, values, type) ==
        std::vector<double>{-1, 1, -1, 1, 0});
  CHECK(results_of({"Pow", {{2}, {2}}}, {{2, 3}, {-1, 3}}, type) == std::vector<double>{0, 27});
  CHECK(results_of({"Div", {{2}, {2}}}, {{1, 1}, {2, 4}}) == std::vector<double>{0.5, 0.25});
}

TEST_CASE("comparisons and logic give truths", "[nn][network]") {
  const std::vector<std::vector<double>> values = {{1, 2, 3}, {2, 2, 2}};
  const auto of = [&](const char* name) { return results_of({name, {{3}, {3}}}, values); };
  CHECK(of("Equal") == std::vector<double>{0, 1, 0});
  CHECK(of("Greater") == std::vector<double>{0, 0, 1});
  CHECK(of("GreaterOrEqual") == std::vector<double>{0, 1, 1});
  CHECK(of("Less") == std::vector<double>{1, 0, 0});
  CHECK(of("LessOrEqual") == std::vector<double>{1, 1, 0});
  const std::vector<std::vector<double>> truths = {{0, 0, 1, 1}, {0, 1, 0, 1}};
  const auto type = nn::ElementType::boolean;
  CHECK(results_of({"And", {{4}, {4}}}, truths, type) == std::vector<double>{0, 0, 0, 1});
  CHECK(results_of({"Or", {{4}, {4}}}, truths, type) == std::vector<double>{0, 1, 1, 1});
  CHECK(results_of({"Xor", {{4}, {4}}}, truths, type) == std::vector<double>{0, 1, 1, 0});
}

TEST_CASE("of equal operands the first gets the adjoint, and NaN comes before everything", "[nn][network]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* name : {"Max", "Min"}) {
    OperatorRun run(description_of({name, {{3}, {3}}}));
    const double a[] = {1, nan, 2}, b[] = {1, 5, nan};
    std::copy_n(a, 3, run.inputs[0].data());
    std::copy_n(b, 3, run.inputs[1].data());
    run.forward(nn::Mode::input_gradient);
    CHECK(run.results()[0] == 1);
    CHECK(std::isnan(run.results()[1]));
    CHECK(std::isnan(run.results()[2]));
    const auto gradient = run.gradient(1);
    CHECK(gradient[0][0] == 1 + std::cos(1.0));
    CHECK(gradient[1][0] == 1);
    CHECK(gradient[0][1] == 1 + std::cos(2.0));
    CHECK(gradient[1][2] == 1 + std::cos(3.0));
  }
}

TEST_CASE("a long repeated operand's adjoint keeps its digits in float", "[nn][network][gradient]") {
  const std::size_t count = 300000;
  const nn::Network<float> network(description_of({"Add", {{count, 3}, {3}}}));
  nn::Buffer<float> a(3 * count);
  a.fill_zero();
  nn::NetworkPass<float> pass;
  std::vector<float> zeros(3);
  network.forward({a.data(), zeros.data()}, pass, nn::Mode::input_gradient);
  std::vector<float> weights(3 * count, 0.1F), gradient(3);
  network.adjoint(pass, {weights.data()}, {nullptr, gradient.data()});
  for (const float sum : gradient) CHECK(static_cast<double>(sum) == Approx(30000).epsilon(1e-7));
}

TEST_CASE("operands that do not go together are refused", "[nn][network]") {
  CHECK(complaint_of({"Add", {{2, 3}, {2, 4}}}) == "operands of [2, 3] and [2, 4] do not go together");
  CHECK(complaint_of({"Where", {{2}, {2}, {3}}}) == "operands of [2] and [3] do not go together");
  CHECK(complaint_of({"PRelu", {{2, 1}, {2, 3}}}) == "the slope is [2, 3], expected what goes with [2, 1]");
  CHECK(complaint_of({"Mod", {{2}, {2}}}) == "fmod is 0, expected 1 for numbers that are not integers");
  CHECK(complaint_of({"Add", {{2}}}) == "1 operands, expected 2");
  CHECK(complaint_of({"Sum", {}}) == "0 operands, expected at least 1");
}
