#pragma once
#include "../../examples/programs/shell/program.hpp"
#include "../support/serve.hpp"
#include "decisions.hpp"

namespace tapestry::benchmarks {
struct WorkerOptions {
  std::string cfg{}, weights{};
  std::size_t size = 416;
  int threads = 1;
  bool wants_gradient = false;
  std::string engine{};
  double seconds = 0;
};

/// Result of a pass: the logits of all heads one after the other, or the gradient and the decisions that led
/// to it.
struct Answer {
  std::vector<float> values{};
  Decisions decisions{};
};

inline void append(std::vector<float>& all, const float* values, std::size_t count) {
  all.resize(all.size() + count);
  std::copy_n(values, count, all.end() - static_cast<std::ptrdiff_t>(count));
}

[[nodiscard]] inline std::string decisions_path(const std::string& answer_path) {
  return answer_path + ".decisions";
}

inline void write_numbers(const std::string& path, const Answer& answer) {
  write_numbers(path, answer.values);
  if (!answer.decisions.chosen.empty()) write_decisions(decisions_path(path), answer.decisions);
}

/// The main function of a program that runs one library on one network. The library's answer is an Answer.
/// \param engines  the values of --engine, for the help
template <Engine Detector>
int run_worker(int argc, char** argv, const std::string& engines) {
  auto app = shell::command_line(
      "Runs a detector again and again, for the benchmark that starts it. Reads requests from the standard "
      "input unless --seconds is given.");
  WorkerOptions options;
  app.add_option("--cfg", options.cfg, "Darknet cfg file")->required();
  app.add_option("--weights", options.weights, "Its weights, of version 0.2.5")->required();
  app.add_option("--size", options.size, "Width and height of the picture, in pixels");
  app.add_option("--threads", options.threads, "Threads");
  app.add_flag("--gradient", options.wants_gradient, "Compute the gradient to the picture, too");
  app.add_option("--engine", options.engine, engines);
  app.add_option("--seconds", options.seconds, "Run that long, print the times and leave");
  return shell::run_program(app, argc, argv, [&] {
    Replies replies;
    const Problem problem = make_problem(options.cfg, options.size);
    Detector engine(problem, options);
    run_or_serve(engine, replies, options.seconds);
    return 0;
  });
}
}  // namespace tapestry::benchmarks
