#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/nn/detail/layout.hpp>
#include <tapestry/nn/network/network.hpp>
#include "catch.hpp"
#include "finite_difference.hpp"

namespace tapestry::test {
/// A node of a network's vocabulary with the extents of its operands.
struct OperatorCase {
  std::string operation;
  std::vector<nn::Shape> shapes;  ///< of the operands that the network is given, in the node's order
  std::map<std::string, nn::Attribute> attributes{};
  std::map<std::size_t, nn::Constant> constants{};  ///< the other operands, by their places
  std::int64_t opset = 17;
  double low = -1, high = 1;    ///< range of random values
  std::vector<double> kinks{};  ///< operands keep 0.01 away from these
  std::size_t output_count = 1;
  std::size_t smooth_outputs = 1;  ///< so many have an adjoint
};

inline nn::Constant integers(std::vector<double> values) {
  const std::size_t count = values.size();
  return {{count}, nn::ElementType::integer, std::move(values)};
}
inline nn::Constant numbers(nn::Shape shape, std::vector<double> values) {
  return {std::move(shape), nn::ElementType::floating, std::move(values)};
}

/// A network of the one node, or of that node behind an Identity for each operand: then the node is handed
/// adjoints to write, and the network's input else such to add to.
inline nn::NetworkDescription description_of(const OperatorCase& given, bool is_behind = false,
                                             nn::ElementType type = nn::ElementType::floating) {
  nn::NetworkDescription description;
  description.path = "net.onnx";
  description.opset = given.opset;
  nn::Node node{"", given.operation, {}, {}, given.attributes};
  std::size_t next = 0;
  for (std::size_t place = 0; place < given.constants.size() + given.shapes.size(); ++place) {
    const std::string name = "x" + std::to_string(place);
    node.inputs.push_back(name);
    if (const auto constant = given.constants.find(place); constant != given.constants.end()) {
      description.constants[name] = constant->second;
      continue;
    }
    const nn::Shape& shape = given.shapes.at(next++);
    description.inputs.push_back({name, {shape.begin(), shape.end()}, type});
    if (!is_behind) continue;
    description.nodes.push_back({"", "Identity", {name}, {"behind " + name}, {}});
    node.inputs.back() = "behind " + name;
  }
  for (std::size_t i = 0; i < given.output_count; ++i) {
    node.outputs.push_back("y" + std::to_string(i));
    description.outputs.push_back(node.outputs.back());
  }
  description.nodes.push_back(std::move(node));
  return description;
}

/// A network in double with values for its inputs.
class OperatorRun {
 public:
  explicit OperatorRun(const nn::NetworkDescription& description, bool channels_last = false)
      : network(description, {}, channels_last) {
    for (std::size_t i = 0; i < network.input_count(); ++i)
      inputs.emplace_back(nn::size_of(network.input_shape(i)));
  }

  void draw(const OperatorCase& given, std::uint64_t seed) {
    Random random(seed);
    for (auto& input : inputs)
      for (std::size_t i = 0; i < input.size(); ++i) {
        double value = random.uniform(given.low, given.high);
        for (const double kink : given.kinks)
          if (std::abs(value - kink) < 0.01) value = kink + 0.02;
        input.data()[i] = value;
      }
  }

  void forward(nn::Mode mode) {
    std::vector<const double*> pointers;
    for (const auto& input : inputs) pointers.push_back(input.data());
    network.forward(pointers, pass, mode);
  }

  /// All results, one behind the other.
  [[nodiscard]] std::vector<double> results() const {
    std::vector<double> all;
    for (std::size_t i = 0; i < network.output_count(); ++i)
      all.insert(all.end(), pass.output(i), pass.output(i) + nn::size_of(network.output_shape(i)));
    return all;
  }

  /// Σ wᵢ·yᵢ over the first outputs, with wᵢ = cos(1 + i) an element of one of them; or Σ |wᵢ·yᵢ|
  [[nodiscard]] double weighted_sum(std::size_t outputs, bool of_magnitudes = false) const {
    double sum = 0;
    for (std::size_t o = 0; o < outputs; ++o)
      for (std::size_t i = 0; i < nn::size_of(network.output_shape(o)); ++i) {
        const double term = weight(i) * pass.output(o)[i];
        sum += of_magnitudes ? std::abs(term) : term;
      }
    return sum;
  }

  /// The weighted sum's derivative with respect to every input, added to ones.
  [[nodiscard]] std::vector<std::vector<double>> gradient(std::size_t outputs) {
    std::vector<nn::Buffer<double>> weights;
    std::vector<const double*> adjoints(network.output_count(), nullptr);
    for (std::size_t o = 0; o < outputs; ++o) {
      weights.emplace_back(nn::size_of(network.output_shape(o)));
      for (std::size_t i = 0; i < weights.back().size(); ++i) weights.back().data()[i] = weight(i);
      adjoints[o] = weights.back().data();
    }
    std::vector<std::vector<double>> sums;
    for (const auto& input : inputs) sums.emplace_back(input.size(), 1.0);
    std::vector<double*> goals;
    for (auto& sum : sums) goals.push_back(sum.data());
    network.adjoint(pass, adjoints, goals);
    return sums;
  }

  nn::Network<double> network;
  nn::NetworkPass<double> pass;
  std::vector<nn::Buffer<double>> inputs;

 private:
  [[nodiscard]] static double weight(std::size_t i) { return std::cos(1.0 + static_cast<double>(i)); }
};

/// Largest difference between the adjoints of a network and central differences of each input element, in
/// units of their largest error: rounding, a few ε·Σ|wᵢ·yᵢ|/h, and truncation, h²·|f'''|/6 with third
/// derivatives up to 600. With h = ε^(1/3) both are multiples of h².
inline double adjoint_error(OperatorRun& run, std::size_t outputs) {
  run.forward(nn::Mode::input_gradient);
  const auto gradient = run.gradient(outputs);
  const double step = central_difference_step<double>();
  const double bound = step * step * (100 + 4 * run.weighted_sum(outputs, true));
  double worst = 0;
  for (std::size_t input = 0; input < run.inputs.size(); ++input)
    for (std::size_t i = 0; i < run.inputs[input].size(); ++i) {
      const double slope = slope_by(run.inputs[input].data()[i], step, [&] {
        run.forward(nn::Mode::inference);
        return run.weighted_sum(outputs);
      });
      const double error = std::abs(gradient[input][i] - 1 - slope) / bound;
      worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
    }
  return worst;
}

/// Adjoints against central differences, written and added to, with tensors of four axes stored either way;
/// and results that depend neither on that nor on the values that a pass keeps.
inline void check_operator(const OperatorCase& given) {
  std::vector<double> first;
  for (const bool is_behind : {false, true})
    for (const bool channels_last : {false, true}) {
      CAPTURE(given.operation, given.shapes, given.opset, is_behind, channels_last);
      OperatorRun run(description_of(given, is_behind), channels_last);
      run.draw(given, 7);
      if (channels_last)  // the same numbers, stored the other way
        for (std::size_t i = 0; i < run.inputs.size(); ++i) {
          const nn::Shape& shape = run.network.input_shape(i);
          if (shape.size() != 4) continue;
          nn::Buffer<double> plain = std::move(run.inputs[i]);
          run.inputs[i].resize(plain.size());
          nn::channels_last(shape[0], shape[3], shape[1] * shape[2], plain.data(), run.inputs[i].data());
        }
      run.forward(nn::Mode::input_gradient);
      const auto kept = run.results();
      run.forward(nn::Mode::inference);
      const auto results = run.results();
      if (first.empty()) first = results;
      CHECK(results == kept);
      REQUIRE(results.size() == first.size());
      for (std::size_t i = 0; i < first.size(); ++i) CHECK(results[i] == Approx(first[i]).epsilon(1e-12));
      CHECK(adjoint_error(run, given.smooth_outputs) <= 1);
    }
}

/// The results of a node for the given values of its computed operands.
inline std::vector<double> results_of(const OperatorCase& given,
                                      const std::vector<std::vector<double>>& values,
                                      nn::ElementType type = nn::ElementType::floating) {
  OperatorRun run(description_of(given, false, type));
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < values[i].size(); ++k) run.inputs.at(i).data()[k] = values[i][k];
  run.forward(nn::Mode::inference);
  return run.results();
}

/// The error of a network of the node, without the file's and the node's names; empty if there is none.
inline std::string complaint_of(const OperatorCase& given, nn::ElementType type = nn::ElementType::floating) {
  try {
    const OperatorRun run(description_of(given, false, type));
    return "";
  } catch (const Error& error) {
    const std::string text = error.what(), mark = "): ";
    const auto place = text.find(mark);
    return place == std::string::npos ? text : text.substr(place + mark.size());
  }
}
}  // namespace tapestry::test
