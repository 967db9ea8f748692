#include <filesystem>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/differential.hpp"
#include "../../support/random_network.hpp"
#include "../../support/threads.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;

Numbers drawn(std::size_t count, std::uint64_t seed) {
  tapestry::Random random(seed);
  Numbers values(count);
  for (double& value : values) value = static_cast<double>(static_cast<float>(random.uniform(-1, 1)));
  return values;
}

double largest(const Numbers& values) {
  double most = 0;
  for (const double value : values) most = std::isnan(value) ? HUGE_VAL : std::max(most, std::abs(value));
  return most;
}

Numbers difference(Numbers a, const Numbers& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

double dot(const Numbers& a, const Numbers& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// A network with its inputs one behind the other, and the objective Σ w·y over the first of its results,
/// without weights for some.
template <class T>
class Run {
 public:
  Run(const nn::NetworkDescription& description, bool simplifies, std::size_t outputs)
      : network(description, {}, false, simplifies), outputs_(outputs) {
    for (std::size_t i = 0; i < network.input_count(); ++i) input_size += nn::size_of(network.input_shape(i));
    for (std::size_t o = 0; o < outputs; ++o) {
      weights_.push_back(drawn(nn::size_of(network.output_shape(o)), 900 + o));
      if (o > 0 && (o * 7 + input_size) % 5 == 0) weights_.back().clear();
    }
  }

  void forward(const Numbers& x, nn::Mode mode = nn::Mode::inference) {
    inputs_.clear();
    std::vector<const T*> addresses;
    for (std::size_t i = 0, next = 0; i < network.input_count(); ++i) {
      inputs_.emplace_back(nn::size_of(network.input_shape(i)));
      for (std::size_t k = 0; k < inputs_.back().size(); ++k)
        inputs_.back().data()[k] = static_cast<T>(x[next++]);
    }
    for (const auto& one : inputs_) addresses.push_back(one.data());
    network.forward(addresses, pass, mode);
  }

  [[nodiscard]] Numbers results() const {
    Numbers all;
    for (std::size_t o = 0; o < outputs_; ++o)
      all.insert(all.end(), pass.output(o), pass.output(o) + nn::size_of(network.output_shape(o)));
    return all;
  }

  [[nodiscard]] double objective() const {
    double sum = 0;
    for (std::size_t o = 0; o < outputs_; ++o)
      for (std::size_t i = 0; i < weights_[o].size(); ++i)
        sum += weights_[o][i] * static_cast<double>(pass.output(o)[i]);
    return sum;
  }

  /// The gradient of the objective by the inputs, and in training by the constants behind them.
  [[nodiscard]] Numbers gradient(const Numbers& x, nn::Mode mode) {
    forward(x, mode);
    std::vector<nn::Buffer<T>> seeds(outputs_);
    std::vector<const T*> adjoints(network.output_count(), nullptr);
    for (std::size_t o = 0; o < outputs_; ++o) {
      if (weights_[o].empty()) continue;
      seeds[o].resize(weights_[o].size());
      std::transform(weights_[o].begin(), weights_[o].end(), seeds[o].data(),
                     [](double w) { return static_cast<T>(w); });
      adjoints[o] = seeds[o].data();
    }
    std::vector<T> sums(input_size, T(0)), weights(network.weights().size(), T(0));
    std::vector<T*> goals;
    for (std::size_t i = 0, next = 0; i < inputs_.size(); next += inputs_[i++].size())
      goals.push_back(sums.data() + next);
    const bool trains = mode == nn::Mode::training;
    network.adjoint(pass, adjoints, goals, trains ? weights.data() : nullptr);
    if (trains) sums.insert(sums.end(), weights.begin(), weights.end());
    return {sums.begin(), sums.end()};
  }

  nn::Network<T> network;
  nn::NetworkPass<T> pass;
  std::size_t input_size = 0;

 private:
  std::size_t outputs_;
  std::vector<Numbers> weights_;
  std::vector<nn::Buffer<T>> inputs_;
};

/// A slope by differences, and its largest error.
struct Slope {
  double value = 0, error = 0;
  bool is_smooth = false;  ///< within the steps
};

/// \param value  of the objective, a step along the direction D(h) errs by h²·f'''/6, a third of its
/// difference to D(2h), and by rounding: values of a network err by some 100 ε of the largest, over h.
/// Where f is not smooth D(h) and D(2h) differ by far more; but they agree where a kink lies at the
/// point itself, as of zeros by any weights. There the slopes to both sides differ as much over h as
/// over 2h, elsewhere half as much.
template <class Value>
Slope slope_of(Value value, double magnitude) {
  constexpr double h = 1e-5;
  const double at = value(0), above = value(h), below = value(-h), far_above = value(2 * h),
               far_below = value(-2 * h);
  const double near = (above - below) / (2 * h), far = (far_above - far_below) / (4 * h);
  const double bend = (above - 2 * at + below) / h, far_bend = (far_above - 2 * at + far_below) / (2 * h);
  const double rounding = 100 * std::numeric_limits<double>::epsilon() * (1 + magnitude) / h;
  const double rough = 1e-6 * (1 + magnitude + std::abs(near));
  return {
      near, std::abs(near - far) + rounding,
      std::abs(near - far) <= rough + 2 * rounding && std::abs(far_bend - 2 * bend) <= rough + 8 * rounding};
}

/// Counts over random networks.
struct Tally {
  std::size_t smooth = 0, rough = 0;  ///< slopes that were compared, and that could not be
  std::size_t kinked = 0;             ///< gradients in float beside a kink
  std::size_t beside = 0;             ///< networks with a wrong slope at one point and none at another
  std::string problems{};             ///< of the network at hand
  std::string slopes{};               ///< wrong slopes at this point

  void expect(bool holds, const std::string& what) {
    if (!holds) problems += (problems.empty() ? "" : "; ") + what;
  }
  void expect_at_most(double found, double bound, const std::string& what) {
    expect(found <= bound, what + ": off by " + std::to_string(found / bound) + " of what is allowed");
  }
};

void check_slope(const Slope& slope, double found, const char* what, Tally& tally) {
  ++(slope.is_smooth ? tally.smooth : tally.rough);
  const double error = std::abs(found - slope.value);
  if (slope.is_smooth && !(error <= slope.error))
    tally.slopes += std::string("; ") + what + ": off by " + std::to_string(error / slope.error);
}

/// Input and weight gradients against differences along drawn directions.
void check_slopes(Run<double>& run, const Numbers& x, std::uint64_t seed, Tally& tally) {
  const double magnitude = largest(run.results()) * static_cast<double>(run.results().size());
  const Numbers gradient = run.gradient(x, nn::Mode::input_gradient),
                all = run.gradient(x, nn::Mode::training);
  const Numbers by_inputs(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(x.size()));
  const Numbers by_weights(all.begin() + static_cast<std::ptrdiff_t>(x.size()), all.end());
  tally.expect(by_inputs == gradient, "input gradients of two modes differ");
  const Numbers direction = drawn(x.size(), seed);
  check_slope(slope_of(
                  [&](double step) {
                    Numbers moved = x;
                    for (std::size_t i = 0; i < x.size(); ++i) moved[i] += step * direction[i];
                    run.forward(moved);
                    return run.objective();
                  },
                  magnitude),
              dot(gradient, direction), "slope by the inputs", tally);
  if (run.network.weights().empty()) return;
  const Numbers weights(run.network.weights().begin(), run.network.weights().end());
  const Numbers along = drawn(weights.size(), seed + 1);
  check_slope(slope_of(
                  [&](double step) {
                    auto moved = weights;
                    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += step * along[i];
                    run.network.set_weights(moved);
                    run.forward(x);
                    return run.objective();
                  },
                  magnitude),
              dot(by_weights, along), "slope by the weights", tally);
  run.network.set_weights(weights);
}

/// Float against double. Where a kink is so near that it lies on the other side in float, the gradient in
/// double jumps a little beside x, too.
void check_float(const nn::NetworkDescription& description, std::size_t outputs, Run<double>& exact,
                 const Numbers& x, Tally& tally) {
  Run<float> run(description, true, outputs);
  exact.forward(x);
  run.forward(x);
  // Values of a network as deep as these are good to 1000 ε of the largest.
  const Numbers results = exact.results();
  tally.expect_at_most(largest(difference(run.results(), results)), 1e-4 * (1 + largest(results)),
                       "results in float");
  const Numbers expected = exact.gradient(x, nn::Mode::input_gradient);
  const double bound = 1e-3 * (1 + largest(expected));
  const double error = largest(difference(run.gradient(x, nn::Mode::input_gradient), expected));
  if (error <= bound) return;
  for (std::uint64_t i = 0; i < 8; ++i) {
    Numbers beside = drawn(x.size(), 70 + i);
    for (std::size_t k = 0; k < x.size(); ++k) beside[k] = x[k] + 1e-5 * beside[k];
    if (largest(difference(exact.gradient(beside, nn::Mode::input_gradient), expected)) <= bound / 2)
      continue;
    ++tally.kinked;
    return;
  }
  tally.expect_at_most(error, bound, "gradient in float");
}

/// The description with every value of a node as a further result: so nothing can be merged.
nn::NetworkDescription opened(nn::NetworkDescription description) {
  for (const nn::Node& node : description.nodes)
    for (const std::string& name : node.outputs)
      if (std::ranges::count(description.outputs, name) == 0) description.outputs.push_back(name);
  return description;
}

/// Results of a network for some of a batch, one behind the other, and the pullback of the results
/// themselves.
struct BatchRun {
  std::vector<std::vector<float>> results, gradients;  ///< by outputs, by inputs
  std::vector<float> weights;

  /// \param first  of the batch of inputs
  BatchRun(const nn::Network<float>& network, const std::vector<nn::Buffer<float>>& inputs, std::size_t first,
           std::size_t count)
      : weights(network.weights().size(), 0.F) {
    std::vector<const float*> addresses, adjoints;
    std::vector<float*> goals;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const std::size_t size = nn::size_of(network.input_shape(i));
      addresses.push_back(inputs[i].data() + first * size);
      gradients.emplace_back(count * size, 0.F);
    }
    for (auto& gradient : gradients) goals.push_back(gradient.data());
    nn::NetworkPass<float> pass;
    network.forward(addresses, pass, nn::Mode::training, count);
    for (std::size_t o = 0; o < network.output_count(); ++o)
      results.emplace_back(pass.output(o), pass.output(o) + count * nn::size_of(network.output_shape(o)));
    for (const auto& result : results) adjoints.push_back(result.data());
    network.adjoint(pass, adjoints, goals, weights.data());
  }
};

/// Each of a batch has the same bits as alone, and the adjoint of the weights is the sum of theirs.
void check_batch(const nn::NetworkDescription& description, std::uint64_t seed, Tally& tally) {
  constexpr std::size_t batch = 3;
  const nn::Network<float> network(description);
  std::vector<nn::Buffer<float>> inputs;
  for (std::size_t i = 0; i < network.input_count(); ++i) {
    const Numbers values = drawn(batch * nn::size_of(network.input_shape(i)), seed + i);
    inputs.emplace_back(values.size());
    std::transform(values.begin(), values.end(), inputs.back().data(),
                   [](double value) { return static_cast<float>(value); });
  }
  const BatchRun together(network, inputs, 0, batch);
  Numbers sums(network.weights().size(), 0.0);
  double size = 0;  // of what is summed
  const auto is_part = [](const auto& parts, const auto& all, std::size_t n) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!std::equal(parts[i].begin(), parts[i].end(),
                      all[i].begin() + static_cast<std::ptrdiff_t>(n * parts[i].size())))
        return false;
    return true;
  };
  for (std::size_t n = 0; n < batch; ++n) {
    const BatchRun alone(network, inputs, n, 1);
    tally.expect(is_part(alone.results, together.results, n), "results of one of a batch differ");
    tally.expect(is_part(alone.gradients, together.gradients, n), "gradients of one of a batch differ");
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += static_cast<double>(alone.weights[i]);
    size += largest({alone.weights.begin(), alone.weights.end()});
  }
  // Terms are summed in another order, some 1000 of them.
  tally.expect_at_most(largest(difference(sums, {together.weights.begin(), together.weights.end()})),
                       1e-4 * (1 + size), "weight gradients of a batch");
}

/// \param point  number of the point; 0, 1, … give different ones
void check_network(std::uint64_t seed, std::uint64_t point, Tally& tally) {
  const nn::NetworkDescription description = RandomNetwork(seed).description;
  const std::size_t outputs = description.outputs.size();
  Run<double> run(description, true, outputs), open(opened(description), true, outputs);
  const Numbers x = drawn(run.input_size, seed + 17 + 100000000 * point);
  open.forward(x);
  const Numbers plain = open.results();
  run.forward(x);
  const Numbers results = run.results();
  const double scale = 1 + largest(plain);
  tally.expect_at_most(scale, 1e6, "values");
  // Merging changes the order of sums and products: some 1000 ε.
  tally.expect_at_most(largest(difference(results, plain)), 1e-12 * scale, "merged results");
  for (const nn::Mode mode : {nn::Mode::input_gradient, nn::Mode::training}) {
    run.forward(x, mode);
    tally.expect(run.results() == results, "results of two modes differ");
  }
  check_slopes(run, x, seed + 23, tally);
  check_slopes(open, x, seed + 29, tally);
  check_float(description, outputs, run, x, tally);
  if (seed % 4 == 1) check_batch(description, seed + 31, tally);
  if (seed % 4 != 0) return;
  const Numbers gradient = run.gradient(x, nn::Mode::training);
  const Threads threads(3);
  tally.expect(run.gradient(x, nn::Mode::training) == gradient, "gradients on three threads differ");
  tally.expect(run.results() == results, "results on three threads differ");
}

/// Path of a failing network's file, to read it elsewhere.
std::string saved(std::uint64_t seed) {
  const auto path =
      std::filesystem::temp_directory_path() / ("tapestry-network-" + std::to_string(seed) + ".onnx");
  tapestry::io::write_onnx(path.string(), RandomNetwork(seed).description);
  return path.string();
}
}  // namespace

TEST_CASE("random networks are right in every mode, precision and form",
          "[nn][network][differential][long]") {
  DifferentialRun networks("random networks", 20);
  Tally tally;
  while (networks.next()) {
    INFO(networks.repeat());
    tally.problems.clear();
    tally.slopes.clear();
    try {
      check_network(networks.seed(), 0, tally);
      if (!tally.slopes
               .empty()) {  // by a kink within a fraction of a step, or by a mistake, which is everywhere
        tally.slopes.clear();
        ++tally.beside;
        check_network(networks.seed(), 1, tally);
      }
    } catch (const tapestry::Error& error) {
      tally.expect(false, error.what());
    }
    tally.problems += tally.slopes;
    if (!tally.problems.empty()) FAIL_CHECK(tally.problems << "; see " << saved(networks.seed()));
  }
  CHECK(tally.rough <= 4 + (tally.smooth + tally.rough) / 20);  // a network alone has four
  CHECK(tally.beside <= 3 + tally.smooth / 1000);
  CHECK(tally.kinked <= 3 + tally.smooth / 400);
}
