#pragma once
#include <memory>
#include "../../examples/programs/shell/program.hpp"
#include "../support/serve.hpp"
#include "objectives.hpp"

namespace tapestry::benchmarks {
/// One way to compute one objective. run() leaves value and gradient; a way that computes the value alone
/// leaves the gradient empty.
class Computation {
 public:
  Computation() = default;
  Computation(const Computation&) = delete;
  Computation& operator=(const Computation&) = delete;
  virtual ~Computation() = default;
  virtual void run() = 0;
  /// Brings value and gradient to where answer() finds them, if run() did not.
  virtual void finish() {}
  [[nodiscard]] std::string name() const { return "autodiff"; }
  /// Value and gradient.
  [[nodiscard]] virtual std::vector<double> answer() {
    finish();
    std::vector<double> numbers{value_};
    numbers.insert(numbers.end(), gradient_.begin(), gradient_.end());
    return numbers;
  }

 protected:
  double value_ = 0;
  std::vector<double> gradient_{};
};

/// The derivatives of an objective: of a Jacobian, its entries.
template <class Objective>
[[nodiscard]] std::size_t entry_count(const Objective& objective) {
  if constexpr (requires { Objective::entries; }) {
    return Objective::entries;
  } else {
    return objective.start().size();
  }
}

/// The main function of a program that computes objectives.
/// \param make  make(objective, variant, threads) returns the Computation, or null if there is no such
/// variant
template <class Make>
int run_worker(int argc, char** argv, Make make) {
  auto app =
      shell::command_line("Differentiates an objective again and again, for the benchmark that starts it.");
  std::string case_name, variant;
  app.add_option("--case", case_name, "Objective")->required();
  std::ptrdiff_t threads = 1;
  app.add_option("--variant", variant, "How it is differentiated");
  app.add_option("--threads", threads, "How many of them are computed side by side")
      ->check(CLI::Range(1, 1024));
  return shell::run_program(app, argc, argv, [&] {
    Replies replies;
    std::unique_ptr<Computation> computation;
    for_each_objective([&](const auto& objective) {
      if (objective.name == case_name) computation = make(objective, variant, threads);
    });
    if (!computation)
      throw Error(ErrorKind::usage, "there is no variant '" + variant + "' of '" + case_name + "'");
    serve(*computation, replies);
    return 0;
  });
}
}  // namespace tapestry::benchmarks
