#pragma once
#include <cstdio>
#include <tapestry/detect/detector.hpp>

namespace tapestry::shell {
/// Times of a detector's operations, forward and backward to a picture.
/// \param input  as the detector takes it
/// \param pass   memory to use
inline nn::PassTimes operation_times(const detect::Detector<float>& detector, const Array<float, 4>& input,
                                     detect::Pass<float>& pass) {
  nn::PassTimes times;
  pass.times = &times;
  detector.forward(input, pass);
  pass.times = nullptr;
  detector.forward(input, pass, detect::Mode::input_gradient);
  pass.times = &times;
  auto gradient = zeros<float, 4>(input.shape());
  detector.input_adjoint(pass, pass.logits, gradient);
  pass.times = nullptr;
  return times;
}

/// Prints the time of each operation in a pass, longest first.
inline void print_profile(std::FILE* to, const char* title, const nn::OperationTimes& times) {
  const auto passes = static_cast<double>(times.passes);
  const auto print = [&](const std::string& name, const std::string& calls, double seconds) {
    std::fprintf(to, "  %-22s %7s %11.3f ms %6.1f %%\n", name.c_str(), calls.c_str(), 1e3 * seconds / passes,
                 100 * seconds / times.seconds);
  };
  using Kind = std::pair<std::string, nn::OperationTimes::Kind>;
  std::vector<Kind> kinds(times.kinds.begin(), times.kinds.end());
  std::ranges::stable_sort(kinds,
                           [](const Kind& a, const Kind& b) { return a.second.seconds > b.second.seconds; });
  std::fprintf(to, "%s: calls and time of a pass, mean of %zu\n", title, times.passes);
  double between = times.seconds;
  for (const auto& [name, kind] : kinds) {
    print(name, std::to_string(kind.calls / times.passes), kind.seconds);
    between -= kind.seconds;
  }
  print("between operations", "", between);
  print("sum", "", times.seconds);
}
}  // namespace tapestry::shell
