// Random programs whose extents depend on their values, against the same programs as loops over numbers.
#include <tapestry/core/random.hpp>
#include <tapestry/nn/network/staged_network.hpp>

#include "../../support/differential.hpp"
#include "../../support/threads.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;
using Names = std::vector<std::string>;
constexpr std::size_t input_size = 12;

/// A network of lists of numbers, and the same as functions of all values by their names.
class RandomStages {
 public:
  using Values = std::map<std::string, Numbers>;

  explicit RandomStages(std::uint64_t seed) : random_(seed) {
    description.path = "random stages " + std::to_string(seed);
    description.opset = 18;
    description.inputs = {{"x", {input_size}}};
    description.constants["zero"] = {{1}, nn::ElementType::integer, Numbers{0}};
    lists_ = {"x"};
    for (std::size_t i = 3 + random_.index(8); i > 0; --i) add();
    for (const std::string& name : lists_)
      if (name != "x" && (name == lists_.back() || random_.chance(0.4))) description.outputs.push_back(name);
  }

  nn::NetworkDescription description{};

  [[nodiscard]] Values evaluated(const Numbers& x) const {
    Values values{{"x", x}};
    for (const auto& step : steps_) step(values);
    return values;
  }

 private:
  void add() {
    const std::string from = lists_[random_.index(lists_.size())];
    switch (random_.index(6)) {
      case 0:
        return add_function(from);
      case 1:
        return add_joined(from);
      case 2:
        return add_chosen(from);
      case 3:
        return add_largest(from);
      case 4:
        return add_branches(from);
      default:
        return add_rounds(from);
    }
  }

  std::string name(const char* kind) { return kind + std::to_string(count_++); }
  std::string number(double value) {
    const std::string own = name("c");
    description.constants[own] = {{}, nn::ElementType::floating, Numbers{value}};
    return own;
  }
  std::string node(const char* operation, Names inputs,
                   std::map<std::string, nn::Attribute> attributes = {}) {
    const std::string result = name("v");
    description.nodes.push_back({"", operation, std::move(inputs), {result}, std::move(attributes)});
    return result;
  }
  void list(const std::string& result, std::function<Numbers(const Values&)> function) {
    lists_.push_back(result);
    steps_.push_back([result, function = std::move(function)](Values& values) {
      Numbers own = function(values);
      values[result] = std::move(own);
    });
  }

  void add_function(const std::string& from) {
    const auto [operation, function] = std::vector<std::pair<const char*, double (*)(double)>>{
        {"Sin", [](double x) { return std::sin(x); }},
        {"Tanh", [](double x) { return std::tanh(x); }},
        {"Atan", [](double x) { return std::atan(x); }}}[random_.index(3)];
    list(node(operation, {from}), [from, function = function](const Values& values) {
      Numbers y = values.at(from);
      for (double& value : y) value = function(value);
      return y;
    });
  }

  /// The list behind another one.
  void add_joined(const std::string& from) {
    const std::string other = lists_[random_.index(lists_.size())];
    list(node("Concat", {from, other}, {{"axis", std::int64_t(0)}}), [from, other](const Values& values) {
      Numbers y = values.at(from);
      y.insert(y.end(), values.at(other).begin(), values.at(other).end());
      return y;
    });
  }

  /// Values above a threshold, perhaps none.
  void add_chosen(const std::string& from) {
    const double least = random_.uniform(-0.9, 1.2);
    const std::string places = node("NonZero", {node("Greater", {from, number(least)})});
    list(node("Gather", {from, node("Squeeze", {places, "zero"})}), [from, least](const Values& values) {
      Numbers y;
      for (const double value : values.at(from))
        if (value > least) y.push_back(value);
      return y;
    });
  }

  /// The largest values, as many as are positive.
  void add_largest(const std::string& from) {
    const std::string truths = node("Cast", {node("Greater", {from, number(0)})}, {{"to", std::int64_t(7)}});
    const std::string count = node("ReduceSum", {truths, "zero"}, {{"keepdims", std::int64_t(1)}});
    list(node("TopK", {from, count}), [from](const Values& values) {
      Numbers y = values.at(from);
      const auto positive = std::ranges::count_if(y, [](double value) { return value > 0; });
      std::ranges::stable_sort(y, std::greater{});
      y.resize(static_cast<std::size_t>(positive));
      return y;
    });
    description.nodes.back().outputs.push_back(name("places"));
  }

  static std::shared_ptr<const nn::Subgraph> graph(nn::Subgraph subgraph) {
    return std::make_shared<const nn::Subgraph>(std::move(subgraph));
  }

  /// Sines if the sum is over a threshold, else twice the list behind itself.
  void add_branches(const std::string& from) {
    const double least = random_.uniform(-1, 1);
    const std::string sum = node("ReduceSum", {from}, {{"keepdims", std::int64_t(0)}});
    const auto otherwise =
        graph({{}, {"t"}, {}, {{"", "Concat", {from, from}, {"t"}, {{"axis", std::int64_t(0)}}}}, {from}});
    const auto then = graph({{}, {"t"}, {}, {{"", "Sin", {from}, {"t"}, {}}}, {from}});
    list(node("If", {node("Greater", {sum, number(least)}), from, from},
              {{"else_branch", otherwise}, {"then_branch", then}}),
         [from, least](const Values& values) {
           Numbers y = values.at(from);
           double total = 0;
           for (const double value : y) total += value;
           if (total > least)
             for (double& value : y) value = std::sin(value);
           else
             y.insert(y.end(), values.at(from).begin(), values.at(from).end());
           return y;
         });
  }

  /// Halves the list while the sum of its squares is over a half, at most three times.
  void add_rounds(const std::string& from) {
    const std::string most = name("c"), half = number(0.5), goes_on = name("c");
    description.constants[most] = {{}, nn::ElementType::integer, Numbers{3}};
    description.constants[goes_on] = {{}, nn::ElementType::boolean, Numbers{1}};
    const auto body = graph({{"i", "goes on", "v"},
                             {"is large", "w"},
                             {},
                             {{"", "Mul", {"v", half}, {"w"}, {}},
                              {"", "ReduceSumSquare", {"w"}, {"s"}, {{"keepdims", std::int64_t(0)}}},
                              {"", "Greater", {"s", half}, {"is large"}, {}}},
                             {half}});
    list(node("Loop", {most, goes_on, from, half}, {{"body", body}}), [from](const Values& values) {
      Numbers y = values.at(from);
      for (int round = 0; round < 3; ++round) {
        double squares = 0;
        for (double& value : y) {
          value *= 0.5;
          squares += value * value;
        }
        if (!(squares > 0.5)) break;
      }
      return y;
    });
  }

  tapestry::Random random_;
  std::size_t count_ = 0;
  Names lists_{};
  std::vector<std::function<void(Values&)>> steps_{};
};

template <class T>
struct Run {
  nn::StagedNetwork<T> network;
  nn::StagedPass<T> pass{};

  explicit Run(const nn::NetworkDescription& description) : network(description) {}

  std::vector<Numbers> operator()(const Numbers& x) {
    std::vector<T> values(x.begin(), x.end());
    values.resize(values.size() + 64);
    network.forward({values.data()}, pass, nn::Mode::input_gradient);
    inputs_ = std::move(values);
    std::vector<Numbers> all;
    for (std::size_t k = 0; k < pass.output_count(); ++k)
      all.emplace_back(pass.output(k), pass.output(k) + nn::size_of(pass.output_shape(k)));
    return all;
  }
  Numbers gradient() {
    std::vector<std::vector<T>> weights;
    std::vector<const T*> adjoints;
    for (std::size_t k = 0; k < pass.output_count(); ++k) {
      weights.emplace_back(nn::size_of(pass.output_shape(k)) + 64);
      for (std::size_t i = 0; i < weights.back().size(); ++i)
        weights.back()[i] = static_cast<T>(weight(k, i));
    }
    for (const auto& list : weights) adjoints.push_back(list.data());
    std::vector<T> sum(input_size);
    network.adjoint(pass, adjoints, {sum.data()});
    return {sum.begin(), sum.end()};
  }
  static double weight(std::size_t k, std::size_t i) {
    return std::cos(1.0 + static_cast<double>(3 * k + i));
  }

 private:
  std::vector<T> inputs_{};
};

double objective(const std::vector<Numbers>& results) {
  double sum = 0;
  for (std::size_t k = 0; k < results.size(); ++k)
    for (std::size_t i = 0; i < results[k].size(); ++i) sum += Run<double>::weight(k, i) * results[k][i];
  return sum;
}

std::vector<Numbers> expected(const RandomStages& program, const Numbers& x) {
  const auto values = program.evaluated(x);
  std::vector<Numbers> all;
  for (const std::string& name : program.description.outputs) all.push_back(values.at(name));
  return all;
}

bool is_close(const std::vector<Numbers>& a, const std::vector<Numbers>& b, double tolerance) {
  return std::ranges::equal(a, b, [&](const Numbers& one, const Numbers& other) {
    return std::ranges::equal(
        one, other, [&](double x, double y) { return std::abs(x - y) <= tolerance * (1 + std::abs(y)); });
  });
}

/// \returns the fault, or nothing
std::string judged(std::uint64_t seed) {
  const RandomStages program(seed);
  tapestry::Random random(seed + 77);
  Numbers x(input_size), direction(input_size);
  for (double& value : x) value = static_cast<double>(static_cast<float>(random.uniform(-1.5, 1.5)));
  for (double& value : direction) value = random.uniform(-1, 1);
  Run<double> run(program.description);
  const auto results = run(x);
  if (!is_close(results, expected(program, x), 1e-14)) return "values";
  const Numbers gradient = run.gradient();
  Run<float> single(program.description);
  if (!is_close(single(x), results, 1e-5)) return "values in float";
  const Numbers of_single = single.gradient();
  double slope = 0;
  for (std::size_t i = 0; i < input_size; ++i) {
    slope += gradient[i] * direction[i];
    if (std::abs(of_single[i] - gradient[i]) > 1e-4 * (1 + std::abs(gradient[i]))) return "gradient in float";
  }
  const double h = 1e-6;
  const auto at = [&](double step) {
    Numbers moved = x;
    for (std::size_t i = 0; i < input_size; ++i) moved[i] += step * direction[i];
    return objective(expected(program, moved));
  };
  if (std::abs((at(h) - at(-h)) / (2 * h) - slope) > 1e-6 * (1 + std::abs(slope))) return "gradient";
  if (run(x) != results || run.pass.made_count() != 0 || run.gradient() != gradient) return "a second run";
  const Threads threads(3);
  if (run(x) != results || run.gradient() != gradient) return "three threads";
  return "";
}
}  // namespace

TEST_CASE("random programs whose extents depend on values are right, forwards and backwards",
          "[nn][network][differential][long]") {
  DifferentialRun programs("random stages", 10);
  std::string problems;
  while (programs.next()) {
    INFO(programs.repeat());
    std::string problem;
    try {
      problem = judged(programs.seed());
    } catch (const std::exception& error) {
      problem = error.what();
    }
    if (!problem.empty()) problems += programs.repeat() + ": " + problem + "\n";
  }
  CHECK(problems == "");
}
