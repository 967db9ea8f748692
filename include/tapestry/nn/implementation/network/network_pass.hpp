#pragma once
#include <tapestry/nn/detail/network/layout_conversion.hpp>
#include <tapestry/nn/network/network_pass.hpp>

namespace tapestry::nn {
template <std::floating_point T>
void NetworkPass<T>::forward(const Program<T>& program, const ProgramUse& use,
                             const std::vector<const T*>& inputs, Mode mode, Engine engine, std::size_t batch,
                             KeptValues<T>* kept, bool holds) {
  const auto whole = timed_pass(forward_times_);
  begin(program, inputs, mode, batch);
  kept_ = kept;
  holds_ = holds;
  plan_ = kept == nullptr ? nullptr : kept->plan;
  find_kept(program, use);
  for (std::size_t s = 0; s < program.steps.size(); ++s) {
    const auto timer = timed_call(forward_times_, program.steps[s].label);
    run(program, use, s, engine);
    for (const std::size_t value : program.steps[s].inputs) release(use, value, s);
    for (const std::size_t value : program.steps[s].outputs) release(use, value, s);
  }
}

template <std::floating_point T>
void NetworkPass<T>::begin(const Program<T>& program, const std::vector<const T*>& inputs, Mode mode,
                           std::size_t batch) {
  if (batch == 0) throw ShapeError("Network::forward: a batch of 0");
  for (auto& buffer : buffers_) workspace_.give(std::move(buffer));
  mode_ = mode;
  batch_ = batch;
  outputs_ = program.outputs;
  buffers_.resize(program.values.size());
  where_.assign(program.values.size(), nullptr);
  states_.resize(program.steps.size() * batch);
  for (std::size_t v = 0; v < program.values.size(); ++v)
    if (program.values[v].is_constant()) where_[v] = program.constants.data() + program.values[v].constant;
  for (std::size_t i = 0; i < program.inputs.size(); ++i) where_[program.inputs[i]] = inputs.at(i);
  for (const std::size_t v : outputs_) {
    if (where_[v] == nullptr || !buffers_[v].empty()) continue;  // a step makes it, or it has been copied
    const std::size_t count = size_of(program.values[v].shape);
    buffers_[v] = workspace_.take(batch * count);  // inputs and constants may be gone before the pass
    for (std::size_t n = 0; n < batch; ++n)
      copy(view(program.values[v], where_[v], n).values, buffers_[v].data() + n * count, count);
    where_[v] = buffers_[v].data();
  }
}

template <std::floating_point T>
AdjointReads NetworkPass<T>::reads_of(const ProgramStep<T>& step) const {
  const AdjointReads reads = step.operation->adjoint_reads();
  if (mode_ != Mode::training) return reads;
  const AdjointReads more = step.operation->weight_adjoint_reads();
  return {reads.inputs | more.inputs, reads.outputs | more.outputs};
}

template <std::floating_point T>
void NetworkPass<T>::find_kept(const Program<T>& program, const ProgramUse& use) {
  is_kept_.assign(program.values.size(), false);
  for (const std::size_t output : program.outputs) is_kept_[output] = true;
  if (mode_ == Mode::inference) return;
  for (const ProgramStep<T>& step : program.steps) {
    const bool has_adjoint =
        std::ranges::any_of(step.outputs, [&](std::size_t value) { return is_active(use, value); });
    if (!has_adjoint) continue;
    const AdjointReads reads = reads_of(step);
    const auto keep = [&](const std::vector<std::size_t>& values, std::uint64_t which) {
      for (std::size_t i = 0; i < values.size(); ++i)
        if (has(which, i) && values[i] != no_value) is_kept_[values[i]] = true;
    };
    keep(step.inputs, reads.inputs);
    keep(step.outputs, reads.outputs);
  }
}

template <std::floating_point T>
void NetworkPass<T>::run(const Program<T>& program, const ProgramUse& use, std::size_t s, Engine engine) {
  const ProgramStep<T>& step = program.steps[s];
  const bool in_place = takes_over_first(program, use, s);
  for (std::size_t i = 0; i < step.outputs.size(); ++i) {
    const std::size_t value = step.outputs[i];
    buffers_[value] = in_place && i == 0 ? std::move(buffers_[step.inputs[0]])
                                         : workspace_.take(size_of_all(program, value));
    where_[value] = buffers_[value].data();
  }
  const bool keeps = mode_ != Mode::inference && std::ranges::any_of(step.outputs, [&](std::size_t value) {
                       return is_active(use, value);
                     });
  for_each_call(step, [&](std::size_t n, std::size_t batch) {
    inputs_.clear();
    for (const std::size_t value : step.inputs)
      inputs_.push_back(value == no_value ? TensorView<const T>{}
                                          : view(program.values[value], where_[value], n));
    results_.clear();
    for (const std::size_t value : step.outputs)
      results_.push_back(view(program.values[value], buffers_[value].data(), n));
    try {
      step.operation->forward({inputs_, results_, states_[s * batch_ + n], keeps, engine, batch,
                               holds_ ? window_of(plan_.get(), step.outputs.front()) : nullptr});
    } catch (const Error& error) {  // a fault of an operand's values, such as an index
      throw file_mismatch({program.path, "", step.label + ": " + error.what()});
    }
  });
  if (kept_ == nullptr) return;
  for (const std::size_t value : step.outputs) {
    const Shape& map = program.values[value].shape;
    holds_ ? kept_->restore(map, value, buffers_[value].data())
           : kept_->save(map, value, buffers_[value].data());
  }
}

template <std::floating_point T>
bool NetworkPass<T>::takes_over_first(const Program<T>& program, const ProgramUse& use, std::size_t s) const {
  const ProgramStep<T>& step = program.steps[s];
  if (step.inputs.empty() || step.inputs[0] == no_value || !step.operation->works_in_place()) return false;
  const std::size_t first = step.inputs[0];
  return use.last_use[first] == s && !is_kept_[first] && !buffers_[first].empty() &&
         std::ranges::count(step.inputs, first) == 1 &&
         size_of(program.values[first].shape) == size_of(program.values[step.outputs[0]].shape);
}

template <std::floating_point T>
void NetworkPass<T>::release(const ProgramUse& use, std::size_t value, std::size_t step) {
  if (value == no_value || use.last_use[value] != step || is_kept_[value]) return;
  workspace_.give(std::move(buffers_[value]));
}

template <std::floating_point T>
void NetworkPass<T>::adjoint(const Program<T>& program, const ProgramUse& use,
                             const std::vector<const T*>& output_adjoints,
                             const std::vector<T*>& inputs_adjoint, T* weights_adjoint,
                             const std::vector<T*>& outputs_gathered, Engine engine) {
  if (mode_ == Mode::inference || buffers_.size() != program.values.size())
    throw DomainError("Network::adjoint: the pass kept nothing; run forward() for a gradient first");
  if (weights_adjoint != nullptr && mode_ != Mode::training)
    throw DomainError("Network::adjoint: the pass was not for training");
  const auto whole = timed_pass(adjoint_times_);
  adjoints_.resize(program.values.size());
  goals_.assign(program.values.size(), nullptr);
  for (std::size_t i = 0; i < program.inputs.size(); ++i)
    if (i < inputs_adjoint.size() && window_of(plan_.get(), program.inputs[i]) == nullptr)
      goals_[program.inputs[i]] = inputs_adjoint[i];
  wants_inputs_ = std::ranges::any_of(inputs_adjoint, [](const T* wanted) { return wanted != nullptr; });
  wants_weights_ = weights_adjoint != nullptr;
  for (std::size_t v = 0; wants_weights_ && v < program.values.size(); ++v)
    if (program.values[v].is_constant() && use.follows_weights[v])
      goals_[v] = weights_adjoint + program.values[v].constant;
  find_gathered(program, outputs_gathered);
  for (std::size_t i = 0; i < program.outputs.size(); ++i) seed(program, i, output_adjoints.at(i));
  is_scaled_.assign(program.steps.size(), false);
  for (std::size_t s = program.steps.size(); s-- > 0;) pull_back(program, use, s, engine);
  if (plan_ != nullptr && !inputs_adjoint.empty()) add_within(program, inputs_adjoint.front());
  for (auto& buffer : adjoints_) workspace_.give(std::move(buffer));
}

template <std::floating_point T>
void NetworkPass<T>::add_within(const Program<T>& program, T* input_adjoint) {
  const std::size_t input = program.inputs.front();
  const MapWindow& window = plan_->picture;
  if (input_adjoint == nullptr || adjoints_[input].empty() || window.is_empty()) return;
  const Shape& map = program.values[input].shape;
  for (std::size_t y = window.rows.begin; y < window.rows.end; ++y) {
    const std::size_t first = (y * map[2] + window.columns.begin) * map[3];
    add(adjoints_[input].data() + first, input_adjoint + first, window.width() * map[3]);
  }
}

template <std::floating_point T>
void NetworkPass<T>::seed(const Program<T>& program, std::size_t i, const T* adjoint) {
  if (adjoint == nullptr) return;
  const std::size_t value = program.outputs[i];
  if (T* const goal = goals_[value]; goal != nullptr) {  // an input or a weight that is a result
    const ProgramValue& result = program.values[value];
    const std::size_t size = size_of(result.shape);
    for (std::size_t n = 0; n < batch_; ++n) add(adjoint + n * size, view(result, goal, n).values, size);
    return;
  }
  const std::size_t count = size_of_all(program, value);
  if (adjoints_[value].empty()) {
    adjoints_[value] = workspace_.take(count);
    copy(adjoint, adjoints_[value].data(), count);
  } else {
    add(adjoint, adjoints_[value].data(), count);
  }
}

template <std::floating_point T>
void NetworkPass<T>::find_gathered(const Program<T>& program, const std::vector<T*>& outputs_gathered) {
  gathered_.clear();
  for (std::size_t i = 0; i < outputs_gathered.size(); ++i) {
    if (outputs_gathered[i] == nullptr) continue;
    gathered_.push_back({program.outputs.at(i), outputs_gathered[i], nullptr});
    for (const ProgramStep<T>& step : program.steps)
      if (step.outputs.front() == gathered_.back().value &&
          dynamic_cast<const LayoutConversion<T>*>(step.operation.get()) != nullptr) {
        gathered_.back().value = step.inputs.front();
        gathered_.back().conversion = &step;
        break;
      }
  }
}

template <std::floating_point T>
void NetworkPass<T>::gather(const Program<T>& program, const Gathered& wanted, Engine engine) {
  const std::size_t count = size_of_all(program, wanted.value);
  const T* const adjoint = adjoints_[wanted.value].data();
  if (wanted.conversion == nullptr) return add(adjoint, wanted.goal, count);
  auto converted = workspace_.take(count);  // a conversion only moves values, adjoints as well
  const ProgramValue& result = program.values[wanted.conversion->outputs.front()];
  for (std::size_t n = 0; n < batch_; ++n) {
    const std::vector<TensorView<const T>> from{view(program.values[wanted.value], adjoint, n)};
    const std::vector<TensorView<T>> to{view(result, converted.data(), n)};
    OperationState<T> state;
    wanted.conversion->operation->forward({from, to, state, false, engine});
  }
  add(converted.data(), wanted.goal, count);
  workspace_.give(std::move(converted));
}

template <std::floating_point T>
bool NetworkPass<T>::wants(const ProgramUse& use, const ProgramStep<T>& step, std::size_t i) const {
  const std::size_t value = step.inputs[i];
  if (value == no_value || !step.operation->is_differentiable(i)) return false;
  return (wants_inputs_ && use.follows_inputs[value]) || (wants_weights_ && use.follows_weights[value]);
}

template <std::floating_point T>
void NetworkPass<T>::pull_back(const Program<T>& program, const ProgramUse& use, std::size_t s,
                               Engine engine) {
  const ProgramStep<T>& step = program.steps[s];
  if (std::ranges::all_of(step.outputs, [&](std::size_t v) { return adjoints_[v].empty(); })) return;
  for (const Gathered& wanted : gathered_)
    if (std::ranges::count(step.outputs, wanted.value) > 0 && !adjoints_[wanted.value].empty())
      gather(program, wanted, engine);
  std::vector<T*> goals;
  std::vector<std::uint8_t> is_first(step.inputs.size(), 0);
  for (std::size_t i = 0; i < step.inputs.size(); ++i)
    goals.push_back(wants(use, step, i) ? goal_of(program, step.inputs[i], is_first[i]) : nullptr);
  if (std::ranges::any_of(goals, [](const T* wanted) { return wanted != nullptr; })) {
    const auto timer = timed_call(adjoint_times_, step.label);
    for_each_call(step, [&](std::size_t n, std::size_t batch) {
      call_adjoint(program, use, s, goals, is_first, n, batch, engine);
    });
  }
  for (const std::size_t value : step.outputs) workspace_.give(std::move(adjoints_[value]));
}

template <std::floating_point T>
void NetworkPass<T>::call_adjoint(const Program<T>& program, const ProgramUse& use, std::size_t s,
                                  const std::vector<T*>& goals, const std::vector<std::uint8_t>& is_first,
                                  std::size_t n, std::size_t batch, Engine engine) {
  const ProgramStep<T>& step = program.steps[s];
  const AdjointReads reads = reads_of(step);  // all other operands are null, even if they are still in memory
  std::vector<TensorView<const T>> results;
  std::vector<TensorView<T>> result_adjoints, input_adjoints;
  for (std::size_t i = 0; i < step.outputs.size(); ++i) {
    const std::size_t v = step.outputs[i];
    const ProgramValue& value = program.values[v];
    results.push_back(view(value, has(reads.outputs, i) ? where_[v] : nullptr, n));
    result_adjoints.push_back(view(value, adjoints_[v].empty() ? nullptr : adjoints_[v].data(), n));
  }
  inputs_.clear();
  for (std::size_t i = 0; i < step.inputs.size(); ++i) {
    const std::size_t v = step.inputs[i];
    if (v == no_value) {
      inputs_.push_back({});
      input_adjoints.push_back({});
      continue;
    }
    inputs_.push_back(view(program.values[v], has(reads.inputs, i) ? where_[v] : nullptr, n));
    input_adjoints.push_back(view(program.values[v], goals[i], n));
  }
  const MapWindow* const window = window_of(plan_.get(), step.outputs.front());
  AdjointScale<T> scale{};
  const std::size_t maker = maker_behind(program, use, s);
  if (maker != no_value && goals[0] != nullptr &&
      std::ranges::count(gathered_, step.inputs[0], &Gathered::value) == 0) {
    scale = program.steps[maker].operation->adjoint_scale(states_[maker * batch_ + n]);
    is_scaled_[maker] = scale.is_there() && step.operation->scales_adjoint(scale);
    if (!is_scaled_[maker]) scale = {};
  }
  const std::unique_ptr<bool[]> is_uninitialised(new bool[step.inputs.size() + 1]());
  std::ranges::copy(is_first, is_uninitialised.get());
  step.operation->adjoint(
      {inputs_, results, result_adjoints, input_adjoints,
       std::span(is_uninitialised.get(), step.inputs.size()), states_[s * batch_ + n], engine, batch, window,
       window == nullptr ? nullptr : window_of(plan_.get(), step.inputs[0]), is_scaled_[s], scale});
}

template <std::floating_point T>
T* NetworkPass<T>::goal_of(const Program<T>& program, std::size_t value, std::uint8_t& is_first) {
  if (goals_[value] != nullptr) return goals_[value];
  if (adjoints_[value].empty()) {
    adjoints_[value] = workspace_.take(size_of_all(program, value));
    is_first = 1;  // 1 only for the first of the operands with this value
  }
  return adjoints_[value].data();
}
}  // namespace tapestry::nn
