#pragma once
#include <tapestry/core/scoped_timer.hpp>
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::nn {
/// Purpose of a forward pass; it decides what the pass keeps.
enum class Mode {
  inference,       ///< running statistics; nothing is kept but the results
  input_gradient,  ///< running statistics; slopes and choices are kept for the adjoint of the input
  training,        ///< statistics of the batch; everything is kept for either adjoint
};

/// Time of a network's operations, summed over passes.
struct OperationTimes {
  /// Calls and time of all operations of one operator.
  struct Kind {
    std::size_t calls = 0;
    double seconds = 0;
  };
  std::map<std::string, Kind> kinds{};  ///< by the operator's name; `layout` for changes of layout
  std::size_t passes = 0;
  double seconds = 0;  ///< time of whole passes, including work between operations

  /// Counts a pass. \returns the number to add its time to
  [[nodiscard]] double& start_pass() {
    ++passes;
    return seconds;
  }
  /// Counts a call of the operation whose name begins this label. \returns the number to add its time to
  [[nodiscard]] double& start_call(const std::string& label) {
    Kind& kind = kinds[label.substr(0, label.find(' '))];
    ++kind.calls;
    return kind.seconds;
  }

  OperationTimes& operator+=(const OperationTimes& other) {
    for (const auto& [name, kind] : other.kinds) {
      kinds[name].calls += kind.calls;
      kinds[name].seconds += kind.seconds;
    }
    passes += other.passes;
    seconds += other.seconds;
    return *this;
  }
};

/// Times of passes forward and of their adjoints.
struct PassTimes {
  OperationTimes forward{}, adjoint{};
};

/// Counts a pass and times it to the end of the scope; does nothing if `times` is null.
[[nodiscard]] inline std::optional<ScopedTimer> timed_pass(OperationTimes* times) {
  if (times == nullptr) return std::nullopt;
  return std::optional<ScopedTimer>(std::in_place, times->start_pass());
}

/// Counts and times a call of the operation whose name begins this label, in the same way.
[[nodiscard]] inline std::optional<ScopedTimer> timed_call(OperationTimes* times, const std::string& label) {
  if (times == nullptr) return std::nullopt;
  return std::optional<ScopedTimer>(std::in_place, times->start_call(label));
}

inline constexpr std::size_t no_value = std::numeric_limits<std::size_t>::max();

/// A tensor of a program.
struct ProgramValue {
  Shape shape{};  ///< as stored
  ElementType type = ElementType::floating;
  bool channels_last = false;       ///< four axes are stored as [N, H, W, C]
  std::size_t constant = no_value;  ///< where its values begin among the constants, if it is one
  std::string name{};

  [[nodiscard]] bool is_constant() const { return constant != no_value; }
};

/// One operation of a program, and the values it works on.
template <std::floating_point T>
struct ProgramStep {
  std::unique_ptr<Operation<T>> operation{};
  std::vector<std::size_t> inputs{};  ///< values; no_value for an operand that is left out
  std::vector<std::size_t> outputs{};
  std::string label{};
};

/// A node that moved the elements of a constant before the network ran, such as Transpose.
struct WeightMove {
  Node node{};
  std::size_t result = 0;            ///< which of the node's
  std::vector<Constant> settings{};  ///< operands behind the first
};

/// A constant that training changes.
struct WeightBlock {
  std::string name{};  ///< of the description's constant
  Shape shape{};
  std::size_t offset = 0;  ///< among the weights
  /// How the elements came from that constant, the first move first; none if they are unchanged.
  std::vector<WeightMove> moves{};
  Shape constant_shape{};  ///< before the moves
  std::int64_t opset = 0;
};

/// A network at fixed extents, as steps that run one after another.
template <std::floating_point T>
struct Program {
  std::string path{};  ///< of the file, for messages; may be empty
  std::vector<ProgramValue> values{};
  std::vector<ProgramStep<T>> steps{};
  /// Read by steps: weights, other constants, a few zeros.
  std::vector<T, platform::PageAllocator<T>> constants{};
  std::size_t weight_count = 0;
  std::vector<std::size_t> inputs{};
  std::vector<std::size_t> outputs{};
  std::vector<WeightBlock> weights{};
  /// The nodes that it was made of, without those constants' values that it has as they are.
  NetworkDescription description{};
};

/// Dependencies of a program's values, and how long each is needed.
struct ProgramUse {
  std::vector<std::size_t> maker{};      ///< step that makes a value; no_value for none
  std::vector<std::size_t> first_use{};  ///< step that reads a value first, likewise
  std::vector<std::size_t> last_use{};   ///< step that reads a value last; the number of steps for results
  std::vector<bool> follows_inputs{};    ///< depends differentiably on an input
  std::vector<bool> follows_weights{};   ///< depends on a weight, or is one
};

template <std::floating_point T>
[[nodiscard]] ProgramUse use_of(const Program<T>& program) {
  const std::size_t count = program.values.size();
  ProgramUse use{std::vector<std::size_t>(count, no_value), std::vector<std::size_t>(count, no_value),
                 std::vector<std::size_t>(count, 0), std::vector<bool>(count, false),
                 std::vector<bool>(count, false)};
  for (const std::size_t input : program.inputs)
    use.follows_inputs[input] = program.values[input].type == ElementType::floating;
  for (const ProgramStep<T>& step : program.steps)
    for (std::size_t i = 0; i < step.inputs.size(); ++i)
      if (step.inputs[i] != no_value && program.values[step.inputs[i]].is_constant() &&
          step.operation->is_weight(i))
        use.follows_weights[step.inputs[i]] = true;
  for (std::size_t s = 0; s < program.steps.size(); ++s) {
    const ProgramStep<T>& step = program.steps[s];
    bool inputs = false, weights = false;
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      const std::size_t value = step.inputs[i];
      if (value == no_value) continue;
      use.last_use[value] = s;
      use.first_use[value] = std::min(use.first_use[value], s);
      if (!step.operation->is_differentiable(i)) continue;
      inputs = inputs || use.follows_inputs[value];
      weights = weights || use.follows_weights[value];
    }
    for (const std::size_t output : step.outputs) {
      if (output == no_value) continue;
      use.last_use[output] = use.maker[output] = s;
      const bool is_smooth = program.values[output].type == ElementType::floating;
      use.follows_inputs[output] = inputs && is_smooth;
      use.follows_weights[output] = weights && is_smooth;
    }
  }
  for (const std::size_t output : program.outputs) use.last_use[output] = program.steps.size();
  return use;
}

/// The maker of operand 0 of step s, if s adds to its adjoint once and last, called alike; else no_value.
template <std::floating_point T>
[[nodiscard]] std::size_t maker_behind(const Program<T>& program, const ProgramUse& use, std::size_t s) {
  const ProgramStep<T>& step = program.steps[s];
  const std::size_t value = step.inputs.empty() ? no_value : step.inputs[0];
  const std::size_t maker = value == no_value || use.first_use[value] != s ? no_value : use.maker[value];
  if (maker == no_value || std::ranges::count(step.inputs, value) > 1) return no_value;
  const Operation<T>& other = *program.steps[maker].operation;
  return other.takes_batches() == step.operation->takes_batches() ? maker : no_value;
}
}  // namespace tapestry::nn
