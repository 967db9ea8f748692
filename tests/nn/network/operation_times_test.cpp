#include "../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
/// Two of Relu(Neg(x)) and their sum's root, beside an Exp that no adjoint reaches.
nn::NetworkDescription description() {
  nn::NetworkDescription network{"test.onnx", 13, {{"x", {2, 3}}}, {"y", "e"}, {}, {}};
  const auto add = [&](const std::string& operation, std::vector<std::string> inputs,
                       const std::string& output) {
    network.nodes.push_back({"", operation, std::move(inputs), {output}, {}});
  };
  add("Neg", {"x"}, "n");
  add("Relu", {"n"}, "r");
  add("Relu", {"x"}, "s");
  add("Add", {"r", "s"}, "a");
  add("Sqrt", {"a"}, "y");
  add("Exp", {"x"}, "e");
  return network;
}

std::map<std::string, std::size_t> calls_of(const nn::OperationTimes& times) {
  std::map<std::string, std::size_t> calls;
  for (const auto& [name, kind] : times.kinds) calls[name] = kind.calls;
  return calls;
}

double sum_of(const nn::OperationTimes& times) {
  double sum = 0;
  for (const auto& [name, kind] : times.kinds) {
    CHECK(kind.seconds >= 0);
    sum += kind.seconds;
  }
  return sum;
}
}  // namespace

TEST_CASE("a pass counts each operation by its operator's name, with the same bits", "[nn][network][times]") {
  const nn::Network<float> network(description(), {}, false, false);
  const std::vector<float> x{1, -2, 3, -4, 5, -6}, seed{1, 2, 3, 4, 5, 6};
  nn::Buffer<float> input(x.size());
  std::copy(x.begin(), x.end(), input.data());
  nn::PassTimes times;
  std::vector<std::vector<float>> results, gradients;
  nn::NetworkPass<float> pass;
  for (nn::PassTimes* const measured : {static_cast<nn::PassTimes*>(nullptr), &times}) {
    pass.set_times(measured);
    for (int run = 0; run < 2; ++run) {
      network.forward({input.data()}, pass, nn::Mode::input_gradient);
      std::vector<float> gradient(x.size(), 0.0F);
      network.adjoint(pass, {seed.data(), nullptr}, {gradient.data()});
      results.emplace_back(pass.output(0), pass.output(0) + x.size());
      gradients.push_back(gradient);
    }
  }
  CHECK(results[3] == results[0]);
  CHECK(gradients[3] == gradients[0]);
  CHECK(times.forward.passes == 2);
  CHECK(calls_of(times.forward) ==
        std::map<std::string, std::size_t>{{"Neg", 2}, {"Relu", 4}, {"Add", 2}, {"Sqrt", 2}, {"Exp", 2}});
  CHECK(times.adjoint.passes == 2);
  CHECK(calls_of(times.adjoint) ==
        std::map<std::string, std::size_t>{{"Neg", 2}, {"Relu", 4}, {"Add", 2}, {"Sqrt", 2}});
  CHECK(sum_of(times.forward) <= times.forward.seconds);
  CHECK(sum_of(times.adjoint) <= times.adjoint.seconds);
  CHECK(times.forward.seconds > 0);

  pass.set_times(nullptr);
  network.forward({input.data()}, pass);
  CHECK(times.forward.passes == 2);
}

TEST_CASE("a batch of an operation that takes one picture a call is one call", "[nn][network][times]") {
  const nn::Network<float> network(description());
  nn::Buffer<float> input(18);
  input.fill_zero();
  nn::PassTimes times;
  nn::NetworkPass<float> pass;
  pass.set_times(&times);
  network.forward({input.data()}, pass, nn::Mode::inference, 3);
  CHECK(times.forward.kinds.at("Relu").calls == 2);
}

TEST_CASE("times of passes add up", "[nn][network][times]") {
  nn::OperationTimes one, other;
  one.start_pass() += 5;
  one.start_call("Conv \"first\"") += 2;
  one.start_call("Conv \"second\"") += 1;
  other.start_pass() += 0.5;
  other.start_call("layout of \"x\"") += 0.25;
  other.start_call("Conv \"first\"") += 0.125;
  one += other;
  CHECK(one.passes == 2);
  CHECK(one.seconds == 5.5);
  CHECK(calls_of(one) == std::map<std::string, std::size_t>{{"Conv", 3}, {"layout", 1}});
  CHECK(one.kinds.at("Conv").seconds == 3.125);
  CHECK(one.kinds.at("layout").seconds == 0.25);
}
