#pragma once
#include <tapestry/core/random.hpp>
#include "../../examples/programs/shell/program.hpp"
#include "../support/serve.hpp"

namespace tapestry::benchmarks {
/// Options of each program that runs a network.
struct NetworkOptions {
  std::string model{};  ///< an ONNX file of one input, a picture [1, 3, size, size]
  std::string input{};  ///< its values, floats of this machine one after the other
  std::size_t size = 416;
  int threads = 1;
  bool wants_gradient = false;
  double seconds = 0;
};

/// Weights of the sum of all outputs whose gradient is computed; the same numbers in every program.
template <class T>
[[nodiscard]] std::vector<T> weighting(std::size_t count) {
  Random random(2);
  std::vector<T> weights(count);
  for (T& weight : weights) weight = static_cast<T>(random.normal());
  return weights;
}

/// The main function of a program that runs one library on one network.
template <Engine E>
int run_network_worker(int argc, char** argv) {
  auto app = shell::command_line(
      "Runs a network again and again, for the benchmark that starts it. Reads requests from the standard "
      "input unless --seconds is given.");
  NetworkOptions options;
  app.add_option("--model", options.model, "ONNX file")->required();
  app.add_option("--input", options.input, "File of the picture's values, floats [1, 3, size, size]")
      ->required();
  app.add_option("--size", options.size, "Width and height of the picture, in pixels");
  app.add_option("--threads", options.threads, "Threads");
  app.add_flag("--gradient", options.wants_gradient, "Compute the gradient to the picture, too");
  app.add_option("--seconds", options.seconds, "Run that long, print the times and leave");
  return shell::run_program(app, argc, argv, [&] {
    Replies replies;
    E engine(options);
    run_or_serve(engine, replies, options.seconds);
    return 0;
  });
}
}  // namespace tapestry::benchmarks
