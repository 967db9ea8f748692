#pragma once
#include <fstream>
#include "problem.hpp"

namespace tapestry::benchmarks {
/// Decisions of a forward pass: on which side of the kink each leaky or relu value lies, and which pixel each
/// pool took. The gradient jumps where a decision changes, and float32 decides otherwise than double for the
/// few values that lie within rounding of a kink, whatever the kernels. A gradient is therefore compared with
/// that of double precision under the same decisions.
struct Decisions {
  std::vector<std::vector<bool>> is_positive{};      ///< for each layer, [row, column, channel]
  std::vector<std::vector<std::uint32_t>> chosen{};  ///< for each layer, row · width + column of its input

  friend bool operator==(const Decisions&, const Decisions&) = default;
};

[[nodiscard]] inline bool has_kink(const detect::LayerConfig& layer) {
  return layer.activation == nn::Activation::leaky || layer.activation == nn::Activation::relu;
}

[[nodiscard]] inline bool is_pool(const detect::LayerConfig& layer) {
  return layer.kind == detect::LayerKind::maxpool;
}

/// Calls body(layer, state) for each layer that decides, with what the pass keeps of its activation or pool.
template <class T, class Body>
void for_each_state(const Problem& problem, const nn::Network<T>& network, nn::NetworkPass<T>& pass,
                    Body body) {
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i)
    if (has_kink(problem.config.layers[i]) || is_pool(problem.config.layers[i]))
      body(i, pass.state(network.step_of("layer_" + std::to_string(i))));
}

[[nodiscard]] inline Decisions no_decisions(const Problem& problem) {
  const std::size_t count = problem.config.layers.size();
  return {std::vector<std::vector<bool>>(count), std::vector<std::vector<std::uint32_t>>(count)};
}

/// Signs of a layer's output.
template <class T>
[[nodiscard]] std::vector<bool> signs(const T* values, std::size_t count) {
  std::vector<bool> positive(count);
  for (std::size_t k = 0; k < count; ++k) positive[k] = values[k] > 0;
  return positive;
}

/// The pixel that each output of a maxpool layer takes, the first of equal ones, from its input
/// [row, column, channel].
[[nodiscard]] inline std::vector<std::uint32_t> pool_choices(const Problem& problem, std::size_t layer,
                                                             const std::vector<float>& input) {
  const detect::LayerConfig& pool = problem.config.layers[layer];
  const detect::FeatureShape& in = problem.shapes[layer - 1];
  const detect::FeatureShape& out = problem.shapes[layer];
  const auto window = [&](std::size_t output, std::size_t extent) {
    const std::size_t shifted = output * pool.stride;
    const std::size_t before = pool.padding / 2;
    return std::pair(shifted > before ? shifted - before : 0, std::min(shifted + pool.size - before, extent));
  };
  std::vector<std::uint32_t> chosen(out.size());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const std::size_t channel = k % out.channels;
    const auto [top, bottom] = window(k / out.channels / out.width, in.height);
    const auto [left, right] = window(k / out.channels % out.width, in.width);
    std::size_t best = top * in.width + left;
    for (std::size_t y = top; y < bottom; ++y)
      for (std::size_t x = left; x < right; ++x)
        if (input[(y * in.width + x) * in.channels + channel] > input[best * in.channels + channel])
          best = y * in.width + x;
    chosen[k] = static_cast<std::uint32_t>(best);
  }
  return chosen;
}

/// Decisions of a model's detector, from the values of its layers in a pass that observes them.
template <class T>
[[nodiscard]] Decisions decisions_of(const Problem& problem, const detect::DarknetModel<T>& model,
                                     nn::Engine engine, const Array<T, 4>& picture) {
  std::vector<std::string> layers;  // whose values decide
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i)
    if (has_kink(problem.config.layers[i]) || is_pool(problem.config.layers[i]))
      layers.push_back(model.value_name(is_pool(problem.config.layers[i]) ? i - 1 : i));
  auto detector = model.detector(layers);
  detector.set_engine(engine);
  detect::Pass<T> pass;
  detector.forward(picture, pass, detect::Mode::input_gradient);
  Decisions decisions = no_decisions(problem);
  for (std::size_t i = 0, layer = 0; i < problem.config.layers.size(); ++i) {
    const bool pools = is_pool(problem.config.layers[i]);
    if (!pools && !has_kink(problem.config.layers[i])) continue;
    const Array<T, 3> values = detector.layer_values(pass, layer++, 0);
    std::vector<float> last(values.size());  // [row, column, channel]
    for (std::size_t c = 0; c < values.shape(0); ++c)
      for (std::size_t p = 0; p < values.size() / values.shape(0); ++p)
        last[p * values.shape(0) + c] =
            static_cast<float>(values.data()[c * (values.size() / values.shape(0)) + p]);
    if (pools) {
      decisions.chosen[i] = pool_choices(problem, i, last);
    } else {
      decisions.is_positive[i] = signs(last.data(), last.size());
    }
  }
  return decisions;
}

/// Decisions of a pass over a network of operators that runs as detect::network_description() writes it down.
template <class T>
[[nodiscard]] Decisions decisions_of(const Problem& problem, const nn::Network<T>& network,
                                     nn::NetworkPass<T>& pass) {
  Decisions decisions = no_decisions(problem);
  for_each_state(problem, network, pass, [&](std::size_t i, nn::OperationState<T>& state) {
    const std::size_t count = problem.shapes[i].size();
    for (std::size_t k = 0; k < count && has_kink(problem.config.layers[i]); ++k)
      decisions.is_positive[i].push_back((state.bits.data()[k / 8] >> k % 8 & 1) != 0);
    if (is_pool(problem.config.layers[i]))
      decisions.chosen[i].assign(state.choices.data(), state.choices.data() + count);
  });
  return decisions;
}

/// Puts decisions into such a pass in place of its own.
template <class T>
void hold(const Problem& problem, const nn::Network<T>& network, const Decisions& decisions,
          nn::NetworkPass<T>& pass) {
  for_each_state(problem, network, pass, [&](std::size_t i, nn::OperationState<T>& state) {
    state.bits.fill_zero();
    for (std::size_t k = 0; k < decisions.is_positive[i].size(); ++k)
      state.bits.data()[k / 8] |= static_cast<std::uint8_t>(decisions.is_positive[i][k] ? 1U << k % 8 : 0U);
    for (std::size_t k = 0; k < decisions.chosen[i].size(); ++k)
      state.choices.data()[k] = static_cast<nn::ElementIndex<T>>(decisions.chosen[i][k]);
  });
}

/// Number of decisions in which two passes differ.
[[nodiscard]] inline std::size_t difference(const Decisions& a, const Decisions& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.chosen.size(); ++i) {
    for (std::size_t k = 0; k < a.is_positive[i].size(); ++k)
      count += a.is_positive[i][k] != b.is_positive[i][k] ? 1 : 0;
    for (std::size_t k = 0; k < a.chosen[i].size(); ++k) count += a.chosen[i][k] != b.chosen[i][k] ? 1 : 0;
  }
  return count;
}

/// Signs eight to a byte, then choices of four bytes each, layer by layer.
inline void write_decisions(const std::string& path, const Decisions& decisions) {
  std::ofstream file(path, std::ios::binary);
  for (std::size_t i = 0; i < decisions.chosen.size(); ++i) {
    const auto& positive = decisions.is_positive[i];
    std::vector<char> bytes((positive.size() + 7) / 8);
    for (std::size_t k = 0; k < positive.size(); ++k)
      if (positive[k]) bytes[k / 8] = static_cast<char>(bytes[k / 8] | 1 << (k % 8));
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.write(reinterpret_cast<const char*>(decisions.chosen[i].data()),
               static_cast<std::streamsize>(4 * decisions.chosen[i].size()));
  }
  if (!file.flush()) throw FileError(ErrorKind::write, {path, "", "cannot write"});
}

[[nodiscard]] inline Decisions read_decisions(const std::string& path, const Problem& problem) {
  std::ifstream file(path, std::ios::binary);
  Decisions decisions = no_decisions(problem);
  for (std::size_t i = 0; i < problem.config.layers.size(); ++i) {
    const std::size_t count = problem.shapes[i].size();
    if (has_kink(problem.config.layers[i])) {
      std::vector<char> bytes((count + 7) / 8);
      file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      decisions.is_positive[i].resize(count);
      for (std::size_t k = 0; k < count; ++k)
        decisions.is_positive[i][k] = (bytes[k / 8] >> (k % 8) & 1) != 0;
    }
    if (is_pool(problem.config.layers[i])) {
      decisions.chosen[i].resize(count);
      file.read(reinterpret_cast<char*>(decisions.chosen[i].data()), static_cast<std::streamsize>(4 * count));
    }
  }
  if (!file || file.peek() != EOF) throw FileError(ErrorKind::malformed, {path, "", "of another network"});
  return decisions;
}
}  // namespace tapestry::benchmarks
