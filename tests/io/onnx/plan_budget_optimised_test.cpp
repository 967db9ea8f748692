// Models of a kilobyte whose loops grow: a model beyond the budget of docs/SECURITY.md is refused soon,
// before memory is taken. Peaks are the whole process's.

#include <fstream>
#include <iostream>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/nn/network/staged_network.hpp>  // PlanBudget

#include "../../support/catch.hpp"
#include "../../support/looping_models.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// MiB of a line of the process's status.
double mib_of(const std::string& line) {
  std::ifstream status("/proc/self/status");
  std::string name;
  for (double kib = 0; status >> name; status.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (name == line + ":" && status >> kib) return kib / 1024;
  return 0;
}

/// Cost of a model's plan and of one pass, and the sentence that refused it.
struct Outcome {
  std::string refusal{};
  ErrorKind kind{};
  double seconds = 0, mib = 0;
};

Outcome outcome_of(const std::string& name, const std::string& bytes) {
  Outcome outcome;
  std::ofstream("/proc/self/clear_refs") << 5 << std::flush;  // the peak starts from now
  const double before = mib_of("VmRSS");
  const std::clock_t begin = std::clock();
  try {
    const nn::StagedNetwork<float> network(io::parse_onnx(bytes, "loop.onnx"));
    nn::StagedPass<float> pass;
    const std::vector<float> x(nn::size_of(network.input_shape(0)) + 32, 0.5F);
    network.forward({x.data()}, pass, nn::Mode::input_gradient);
  } catch (const Error& error) {
    outcome.refusal = error.what();
    outcome.kind = error.kind();
  }
  outcome.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  outcome.mib = mib_of("VmHWM") - before;
  std::cout << name << " (" << bytes.size() << " bytes): " << outcome.seconds << " s, " << outcome.mib
            << " MiB; " << outcome.refusal << '\n';
  return outcome;
}

void check_refused(const std::string& name, const std::string& bytes, const char* sentence) {
  CAPTURE(name);
  const Outcome outcome = outcome_of(name, bytes);
  CHECK_THAT(outcome.refusal, contains(sentence) && contains("loop.onnx: Loop \"y\""));
  CHECK(outcome.kind == ErrorKind::limit);
  CHECK(outcome.mib <= 256);
  CHECK(outcome.seconds <= 5);  // 1 is the aim; machines differ, and others may run
}
}  // namespace

TEST_CASE("X29: loops beyond the budget are refused soon and in little memory", "[io][onnx][budget]") {
  check_refused("seven deep", onnx::nested_loops(7, 10), "more nodes, with those of loops, than");
  check_refused("sixteen deep", onnx::nested_loops(16, 999), "more nodes, with those of loops, than");
  check_refused("doubling", onnx::doubling_loop(28), "more bytes in loops than");
  check_refused("doubling on", onnx::doubling_loop(1000), "more bytes in loops than");
  check_refused("doubling by value", onnx::doubling_loop_by_value(1000), "more bytes in loops than");
  check_refused("scan of 1e5", onnx::scanning_loop(1000, 100000), "more bytes in loops than");
}

TEST_CASE("loops within the budget run", "[io][onnx][budget]") {
  CHECK(outcome_of("four deep", onnx::nested_loops(4, 10)).refusal.empty());
  CHECK(outcome_of("thousand rounds", onnx::nested_loops(1, 1000)).refusal.empty());
  CHECK(outcome_of("doubling", onnx::doubling_loop(20)).refusal.empty());
  CHECK(outcome_of("scan of 1e5", onnx::scanning_loop(80, 100000)).refusal.empty());
  CHECK(outcome_of("scan of a thousand rounds", onnx::scanning_loop(1000, 100)).refusal.empty());
}
