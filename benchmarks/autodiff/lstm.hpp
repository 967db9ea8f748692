#pragma once
#include <algorithm>

#include "seeded.hpp"

namespace tapestry::benchmarks {

/// Loss of a recurrent network over a sequence: the LSTM of the public ADBench suite, whose weight matrices
/// are diagonal. Two layers of 14 units, 1,024 characters. Of each layer the inputs are four gates' weights,
/// then four biases, [8, units]; then come a gain of the input, and gain and bias of the prediction,
/// [3, units]. The loss is the mean of the predictions' negative log-likelihoods, to whose sum of
/// exponentials the suite adds 2. The state that the sequence begins with is constant.
struct Lstm {
  static constexpr const char* name = "lstm";
  static constexpr std::size_t units = 14, layers = 2, length = 1024;
  static constexpr std::size_t layer_size = 8 * units;
  static constexpr std::size_t terms = (length - 1) * units;

  std::vector<double> sequence = uniform(length * units, 0, 1, 21);      // [length, units]
  std::vector<double> state = uniform(2 * layers * units, -.5, .5, 22);  // [layers, {hidden, cell}, units]
  [[nodiscard]] static std::vector<double> start() {
    return uniform(layers * layer_size + 3 * units, -.5, .5, 23);
  }

  template <class S>
  [[nodiscard]] static S logistic(const S& x) {
    return 1 / (1 + exp(-x));
  }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    const S* const gain = x + layers * layer_size;
    std::vector<S> states(state.begin(), state.end()), at(units);
    S total = 0;
    for (std::size_t t = 0; t + 1 < length; ++t) {
      for (std::size_t i = 0; i < units; ++i) at[i] = gain[i] * sequence[t * units + i];
      for (std::size_t layer = 0; layer < layers; ++layer) {
        const S* const weight = x + layer * layer_size;
        const S* const bias = weight + 4 * units;
        S* const hidden = states.data() + 2 * layer * units;
        S* const cell = hidden + units;
        for (std::size_t i = 0; i < units; ++i) {
          const S forget = logistic<S>(at[i] * weight[i] + bias[i]);
          const S ingate = logistic<S>(hidden[i] * weight[units + i] + bias[units + i]);
          const S outgate = logistic<S>(at[i] * weight[2 * units + i] + bias[2 * units + i]);
          const S change = tanh(hidden[i] * weight[3 * units + i] + bias[3 * units + i]);
          cell[i] = cell[i] * forget + ingate * change;
          hidden[i] = outgate * tanh(cell[i]);
          at[i] = hidden[i];
        }
      }
      S sum = 2;
      for (std::size_t i = 0; i < units; ++i) {
        at[i] = at[i] * gain[units + i] + gain[2 * units + i];
        sum += exp(at[i]);
      }
      const S norm = log(sum);
      for (std::size_t i = 0; i < units; ++i) total += sequence[(t + 1) * units + i] * (at[i] - norm);
    }
    return -total / static_cast<double>(terms);
  }
};

/// Values that one unit of one layer computes at one step, for its adjoint.
template <class T>
struct LstmStep {
  T in, hidden_before, cell_before, forget, ingate, outgate, change, squashed;
};

/// Back through time: first all steps forwards, kept, then backwards.
template <class T>
T hand_adjoint(const Lstm& lstm, const T* x, T* gradient) {
  constexpr std::size_t units = Lstm::units, layers = Lstm::layers, steps = Lstm::length - 1;
  constexpr std::size_t extra = layers * Lstm::layer_size;
  static thread_local std::vector<LstmStep<T>> kept(steps * layers * units);
  static thread_local std::vector<T> predicted(steps * units), norms(steps);
  std::vector<T> states(lstm.state.begin(), lstm.state.end()), at(units);
  const auto sequence = [&](std::size_t t, std::size_t i) {
    return static_cast<T>(lstm.sequence[t * units + i]);
  };
  T total = 0;
  for (std::size_t t = 0; t < steps; ++t) {
    for (std::size_t i = 0; i < units; ++i) at[i] = x[extra + i] * sequence(t, i);
    for (std::size_t layer = 0; layer < layers; ++layer) {
      const T* const w = x + layer * Lstm::layer_size;
      const T* const b = w + 4 * units;
      for (std::size_t i = 0; i < units; ++i) {
        T& hidden = states[2 * layer * units + i];
        T& cell = states[(2 * layer + 1) * units + i];
        LstmStep<T>& step = kept[(t * layers + layer) * units + i];
        step.in = at[i], step.hidden_before = hidden, step.cell_before = cell;
        step.forget = Lstm::logistic<T>(at[i] * w[i] + b[i]);
        step.ingate = Lstm::logistic<T>(hidden * w[units + i] + b[units + i]);
        step.outgate = Lstm::logistic<T>(at[i] * w[2 * units + i] + b[2 * units + i]);
        step.change = std::tanh(hidden * w[3 * units + i] + b[3 * units + i]);
        cell = cell * step.forget + step.ingate * step.change;
        step.squashed = std::tanh(cell);
        at[i] = hidden = step.outgate * step.squashed;
      }
    }
    T sum = 2;
    for (std::size_t i = 0; i < units; ++i) {
      predicted[t * units + i] = at[i] * x[extra + units + i] + x[extra + 2 * units + i];
      sum += std::exp(predicted[t * units + i]);
    }
    norms[t] = std::log(sum);
    for (std::size_t i = 0; i < units; ++i)
      total += sequence(t + 1, i) * (predicted[t * units + i] - norms[t]);
  }

  std::fill_n(gradient, extra + 3 * units, T(0));
  std::vector<T> hidden_g(layers * units), cell_g(layers * units), at_g(units);
  const T scale = T(-1) / static_cast<T>(Lstm::terms);
  for (std::size_t t = steps; t-- > 0;) {
    T wanted = 0;
    for (std::size_t i = 0; i < units; ++i) wanted += sequence(t + 1, i);
    for (std::size_t i = 0; i < units; ++i) {
      const T share = std::exp(predicted[t * units + i] - norms[t]);
      const T g = scale * (sequence(t + 1, i) - wanted * share);
      const LstmStep<T>& last = kept[(t * layers + layers - 1) * units + i];
      gradient[extra + units + i] += g * last.outgate * last.squashed;
      gradient[extra + 2 * units + i] += g;
      at_g[i] = g * x[extra + units + i];
    }
    for (std::size_t layer = layers; layer-- > 0;) {
      const T* const w = x + layer * Lstm::layer_size;
      T* const w_g = gradient + layer * Lstm::layer_size;
      T* const b_g = w_g + 4 * units;
      for (std::size_t i = 0; i < units; ++i) {
        const LstmStep<T>& step = kept[(t * layers + layer) * units + i];
        const T h_g = hidden_g[layer * units + i] + at_g[i];
        const T c_g = cell_g[layer * units + i] + h_g * step.outgate * (1 - step.squashed * step.squashed);
        const T gates[4] = {c_g * step.cell_before * step.forget * (1 - step.forget),
                            c_g * step.change * step.ingate * (1 - step.ingate),
                            h_g * step.squashed * step.outgate * (1 - step.outgate),
                            c_g * step.ingate * (1 - step.change * step.change)};
        for (std::size_t gate = 0; gate < 4; ++gate) {
          w_g[gate * units + i] += gates[gate] * (gate % 2 == 0 ? step.in : step.hidden_before);
          b_g[gate * units + i] += gates[gate];
        }
        at_g[i] = gates[0] * w[i] + gates[2] * w[2 * units + i];
        hidden_g[layer * units + i] = gates[1] * w[units + i] + gates[3] * w[3 * units + i];
        cell_g[layer * units + i] = c_g * step.forget;
      }
    }
    for (std::size_t i = 0; i < units; ++i) gradient[extra + i] += at_g[i] * sequence(t, i);
  }
  return scale * total;
}

}  // namespace tapestry::benchmarks
