#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// LSTM, GRU and RNN, unrolled: a sequence is as long as its input's extent. Source: onnx.ai, Operators.md.
class RecurrentParts {
 public:
  enum class Kind { lstm, gru, rnn };

  RecurrentParts(OperatorContext& context, Decomposer& parts, Kind kind)
      : context_(context),
        parts_(parts),
        kind_(kind),
        gates_(kind == Kind::lstm  ? 4
               : kind == Kind::gru ? 3
                                   : 1) {
    const Shape& x = context.input(0).shape;
    const Shape& r = context.input(2).shape;
    if (x.size() != 3 || context.input(1).shape.size() != 3 || r.size() != 3)
      throw ShapeError("operands 0, 1 and 2 need three axes each");
    is_batch_first_ = context.flag("layout", 0);
    steps_ = x[is_batch_first_ ? 1 : 0];
    batch_ = x[is_batch_first_ ? 0 : 1];
    inputs_ = x[2];
    size_ = r[2];
    const std::string direction = context.text("direction", "forward");
    if (direction != "forward" && direction != "reverse" && direction != "bidirectional")
      throw DomainError({"direction is ", in_quotes(direction)});
    directions_ = direction == "bidirectional" ? 2 : 1;
    first_is_reverse_ = direction == "reverse";
    const Shape w_shape{directions_, gates_ * size_, inputs_}, r_shape{directions_, gates_ * size_, size_};
    if (context.input(1).shape != w_shape || r != r_shape)
      throw ShapeError(
          {"weights are ", context.input(1).shape, " and ", r, ", expected ", w_shape, " and ", r_shape});
    if (const auto stated = context.integer("hidden_size", static_cast<std::int64_t>(size_));
        stated != static_cast<std::int64_t>(size_))
      throw DomainError({"hidden_size is ", stated, ", expected ", size_});
    constexpr std::size_t most = 4096;
    if (steps_ == 0 || steps_ > most)
      throw ShapeError({"a sequence of ", steps_, " steps, expected 1 to 4096"});
    if (context.has_input(4))
      for (const std::int64_t length : context.integers(4))
        if (length != static_cast<std::int64_t>(steps_))
          throw DomainError({"a sequence of length ", length, " among ", steps_, " steps is not supported"});
    if (context.has_attribute("clip")) throw DomainError("attribute 'clip' is not supported");
    resets_after_ = kind == Kind::gru && context.flag("linear_before_reset", 0);
    require_states();
    if (kind == Kind::lstm && context.flag("input_forget", 0))
      throw DomainError("attribute 'input_forget' is not supported");
    read_activations();
  }

  void write() {
    const std::string x = is_batch_first_ ? parts_.transposed(parts_.input(0), {1, 0, 2}) : parts_.input(0);
    std::array<std::vector<std::string>, 2> outputs;  // of each direction, [1, 1, batch, size] a step
    std::vector<std::string> last, last_cells;
    for (std::size_t d = 0; d < directions_; ++d) {
      const Ends ends = run(x, d, outputs[d]);
      last.push_back(parts_.reshaped(ends.hidden, {1, batch_, size_}));
      if (kind_ == Kind::lstm) last_cells.push_back(parts_.reshaped(ends.cell, {1, batch_, size_}));
    }
    std::vector<std::string> steps;
    for (std::size_t t = 0; t < steps_; ++t)
      steps.push_back(directions_ == 1 ? outputs[0][t] : joined({outputs[0][t], outputs[1][t]}, 1));
    finish(0, steps, 0, {2, 0, 1, 3});
    finish(1, last, 0, {1, 0, 2});
    if (kind_ == Kind::lstm) finish(2, last_cells, 0, {1, 0, 2});
  }

 private:
  /// \throws ShapeError naming a bias, a first state or peepholes that do not fit the weights
  void require_states() const {
    const std::size_t rows = gates_ * size_;
    const Shape state =
        is_batch_first_ ? Shape{batch_, directions_, size_} : Shape{directions_, batch_, size_};
    const std::array<const char*, 8> names{"", "", "", "bias", "", "first output", "first cell", "peepholes"};
    const std::array<Shape, 8> shapes{
        {{}, {}, {}, {directions_, 2 * rows}, {}, state, state, {directions_, 3 * size_}}};
    for (const std::size_t i : {3U, 5U, 6U, 7U})
      if (context_.has_input(i) && context_.input(i).shape != shapes[i])
        throw ShapeError(
            {"the ", names[i], ", input ", i, ", is ", context_.input(i).shape, ", expected ", shapes[i]});
  }

  struct Ends {
    std::string hidden, cell;
  };

  void read_activations() {
    const std::vector<std::string> usual = kind_ == Kind::lstm
                                               ? std::vector<std::string>{"Sigmoid", "Tanh", "Tanh"}
                                           : kind_ == Kind::gru ? std::vector<std::string>{"Sigmoid", "Tanh"}
                                                                : std::vector<std::string>{"Tanh"};
    const auto named = context_.texts("activations");
    if (!named.empty() && named.size() != usual.size() * directions_)
      throw DomainError({"activations are ", named.size(), ", expected ", usual.size() * directions_});
    for (std::size_t d = 0; d < directions_; ++d)
      for (std::size_t i = 0; i < usual.size(); ++i) {
        const std::string name = named.empty() ? usual[i] : named[d * usual.size() + i];
        if (name != "Sigmoid" && name != "Tanh" && name != "Relu")
          throw DomainError(
              {"activation ", in_quotes(name), " is not supported; expected Sigmoid, Tanh or Relu"});
        activations_[d].push_back(name);
      }
  }

  [[nodiscard]] bool has(std::size_t input) const { return context_.has_input(input); }

  std::string joined(std::vector<std::string> values, std::int64_t axis) {
    return values.size() == 1 ? values.front() : parts_.add("Concat", std::move(values), {{"axis", axis}});
  }

  /// Makes a result, unless the node leaves it out.
  /// \param order  of its axes where the batch comes first
  void finish(std::size_t i, std::vector<std::string> values, std::int64_t axis,
              std::vector<std::int64_t> order) {
    if (!is_batch_first_) return parts_.finish(i, "Concat", std::move(values), {{"axis", axis}});
    parts_.finish(i, "Transpose", {joined(std::move(values), axis)}, {{"perm", std::move(order)}});
  }

  /// Elements first … first + count − 1 along an axis.
  std::string part(const std::string& value, std::size_t axis, std::size_t first, std::size_t count) {
    return parts_.sliced(value, static_cast<std::int64_t>(first), static_cast<std::int64_t>(first + count),
                         static_cast<std::int64_t>(axis));
  }
  /// Takes the part of a direction, without its axis.
  std::string of_direction(std::size_t input, std::size_t d, const Shape& shape) {
    const std::string& value = parts_.input(input);
    return parts_.reshaped(directions_ == 1 ? value : part(value, 0, d, 1), shape);
  }
  std::string start(std::size_t input, std::size_t d) {
    if (!has(input))
      return parts_.constant({{batch_, size_}, ElementType::floating, std::vector<double>(batch_ * size_)});
    std::string all = parts_.input(input);
    if (is_batch_first_) all = parts_.transposed(all, {1, 0, 2});
    return parts_.reshaped(directions_ == 1 ? all : part(all, 0, d, 1), {batch_, size_});
  }
  std::string sum(const std::string& a, const std::string& b) { return parts_.add("Add", {a, b}); }
  std::string times(const std::string& a, const std::string& b) { return parts_.add("Mul", {a, b}); }
  std::string gate(const std::string& all, std::size_t i) { return part(all, 1, i * size_, size_); }
  std::string activated(std::size_t d, std::size_t i, const std::string& x) {
    return parts_.add(activations_[d][i].c_str(), {x});
  }

  /// One direction; appends its outputs in the order of the input.
  Ends run(const std::string& x, std::size_t d, std::vector<std::string>& outputs) {
    const std::size_t rows = gates_ * size_;
    const std::string w = parts_.transposed(of_direction(1, d, {rows, inputs_}), {1, 0});
    r_ = parts_.transposed(of_direction(2, d, {rows, size_}), {1, 0});
    std::string from_x = parts_.add("MatMul", {x, w});
    r_bias_.clear();
    if (has(3)) {
      const std::string bias = of_direction(3, d, {1, 2 * rows});
      from_x = sum(from_x, part(bias, 1, 0, rows));
      r_bias_ = part(bias, 1, rows, rows);
    }
    peepholes_.clear();
    if (kind_ == Kind::lstm && has(7)) peepholes_ = of_direction(7, d, {1, 3 * size_});
    if (kind_ == Kind::gru && !resets_after_) {
      r_gates_ = part(r_, 1, 0, 2 * size_);
      r_new_ = part(r_, 1, 2 * size_, size_);
    }
    Ends ends{start(5, d), kind_ == Kind::lstm ? start(6, d) : std::string()};
    outputs.resize(steps_);
    const bool is_reverse = d == 1 || first_is_reverse_;
    for (std::size_t i = 0; i < steps_; ++i) {
      const std::size_t t = is_reverse ? steps_ - 1 - i : i;
      const std::string own = parts_.reshaped(part(from_x, 0, t, 1), {batch_, rows});
      ends = kind_ == Kind::lstm  ? lstm(own, ends, d)
             : kind_ == Kind::gru ? gru(own, ends, d)
                                  : rnn(own, ends, d);
      outputs[t] = parts_.reshaped(ends.hidden, {1, 1, batch_, size_});
    }
    return ends;
  }

  std::string from_hidden(const std::string& hidden) {
    const std::string product = parts_.add("MatMul", {hidden, r_});
    return r_bias_.empty() ? product : sum(product, r_bias_);
  }

  Ends rnn(const std::string& own, const Ends& before, std::size_t d) {
    return {activated(d, 0, sum(own, from_hidden(before.hidden))), {}};
  }

  /// Gates are input, output, forget and cell; peepholes input, output and forget.
  Ends lstm(const std::string& own, const Ends& before, std::size_t d) {
    const std::string all = sum(own, from_hidden(before.hidden));
    const auto peeped = [&](std::size_t i, const std::string& cell) {
      const std::string plain = gate(all, i);
      return peepholes_.empty() ? plain : sum(plain, times(part(peepholes_, 1, i * size_, size_), cell));
    };
    const std::string in = activated(d, 0, peeped(0, before.cell));
    const std::string forget = activated(d, 0, peeped(2, before.cell));
    const std::string fresh = activated(d, 1, gate(all, 3));
    const std::string cell = sum(times(forget, before.cell), times(in, fresh));
    return {times(activated(d, 0, peeped(1, cell)), activated(d, 2, cell)), cell};
  }

  /// Gates are update, reset and hidden.
  Ends gru(const std::string& own, const Ends& before, std::size_t d) {
    std::string update, fresh;
    if (resets_after_) {
      const std::string from = from_hidden(before.hidden);
      update = activated(d, 0, sum(gate(own, 0), gate(from, 0)));
      const std::string reset = activated(d, 0, sum(gate(own, 1), gate(from, 1)));
      fresh = activated(d, 1, sum(gate(own, 2), times(reset, gate(from, 2))));
    } else {
      std::string gates = parts_.add("MatMul", {before.hidden, r_gates_});
      if (!r_bias_.empty()) gates = sum(gates, part(r_bias_, 1, 0, 2 * size_));
      update = activated(d, 0, sum(gate(own, 0), gate(gates, 0)));
      const std::string reset = activated(d, 0, sum(gate(own, 1), gate(gates, 1)));
      std::string inner = parts_.add("MatMul", {times(reset, before.hidden), r_new_});
      if (!r_bias_.empty()) inner = sum(inner, gate(r_bias_, 2));
      fresh = activated(d, 1, sum(gate(own, 2), inner));
    }
    const std::string change = parts_.add("Sub", {before.hidden, fresh});
    return {sum(fresh, times(update, change)), {}};
  }

  OperatorContext& context_;
  Decomposer& parts_;
  Kind kind_;
  std::size_t gates_;
  std::size_t steps_ = 0, batch_ = 0, inputs_ = 0, size_ = 0, directions_ = 1;
  bool is_batch_first_ = false, first_is_reverse_ = false, resets_after_ = false;
  std::array<std::vector<std::string>, 2> activations_{};
  std::string r_{}, r_bias_{}, r_gates_{}, r_new_{}, peepholes_{};  // of the direction at hand
};

inline void decompose_lstm(OperatorContext& context, Decomposer& parts) {
  RecurrentParts(context, parts, RecurrentParts::Kind::lstm).write();
}
inline void decompose_gru(OperatorContext& context, Decomposer& parts) {
  RecurrentParts(context, parts, RecurrentParts::Kind::gru).write();
}
inline void decompose_rnn(OperatorContext& context, Decomposer& parts) {
  RecurrentParts(context, parts, RecurrentParts::Kind::rnn).write();
}
}  // namespace tapestry::nn::detail
