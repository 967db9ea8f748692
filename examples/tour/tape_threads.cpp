// A tape for each thread: the gradient of a loss over many samples, in parts that are added in a fixed order,
// so that any number of threads gives the same bits.
#include <cstdio>
#include <tapestry/autodiff.hpp>
#include <tapestry/core/parallel.hpp>

namespace {
constexpr std::size_t sample_count = 20000, part_size = 1000;

/// The slopes of Σ softplus(−y·(w·x + b)) by w and b, over some of the samples.
std::vector<double> gradient_of_part(double weight, double bias, tapestry::BlockRange part) {
  tapestry::Tape<double> tape;  // one a part, so no threads share it
  const auto scope = tape.activate();
  const auto w = tape.input(weight), b = tape.input(bias);
  tapestry::Variable<double> loss = 0;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    const double x = std::sin(static_cast<double>(i)),
                 y = x + 0.3 * std::cos(7.0 * static_cast<double>(i)) > 0.2 ? 1 : -1;
    loss += softplus(-y * (w * x + b));
  }
  tape.reverse(loss);
  return {w.adjoint(), b.adjoint()};
}

std::vector<double> gradient(double weight, double bias) {
  std::vector<std::vector<double>> parts(tapestry::block_count(sample_count, part_size));
  tapestry::parallel_for(parts.size(), [&](std::size_t part) {
    parts[part] = gradient_of_part(weight, bias, tapestry::block_range(part, sample_count, part_size));
  });
  std::vector<double> total(2);
  for (const auto& part : parts)
    for (std::size_t i = 0; i < 2; ++i) total[i] += part[i] / sample_count;
  return total;
}
}  // namespace

int main() {
  double weight = 0, bias = 0;
  for (int step = 0; step < 60; ++step) {
    const auto slopes = gradient(weight, bias);
    weight -= 4 * slopes[0];
    bias -= 4 * slopes[1];
  }
  const auto on_all_threads = gradient(weight, bias);
  tapestry::limit_threads(1);
  const auto on_one_thread = gradient(weight, bias);
  std::printf("weight %.4f, bias %.4f\n", weight, bias);
  std::printf("gradients of one and of all threads: %s\n",
              on_one_thread == on_all_threads ? "the same bits" : "differ");
}
