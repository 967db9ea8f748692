#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/autodiff/replay/replay_program.hpp>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/replay/replayable.hpp>
#include <tapestry/autodiff/tape/statement.hpp>
#include <utility>
#include <vector>

namespace tapestry::detail {

/// A function's operations, unless a program has taken them, its inputs being slots 1, 2 and so on, and its
/// result.
template <class T>
struct RecordedFunction {
  ReplayRecording<T> recording{};
  std::uint32_t root = 0;  ///< slot of the result; 0 if it is a constant
  T constant = 0;
};

/// While it lives, operations of this thread go to the recorder.
template <class T, std::size_t Lanes>
class RecorderScope {
 public:
  explicit RecorderScope(ReplayRecorder<T, Lanes>& recorder)
      : previous_(std::exchange(ReplayRecorder<T, Lanes>::active, &recorder)) {}
  RecorderScope(const RecorderScope&) = delete;
  RecorderScope& operator=(const RecorderScope&) = delete;
  ~RecorderScope() { ReplayRecorder<T, Lanes>::active = previous_; }

 private:
  ReplayRecorder<T, Lanes>* previous_;
};

/// Calls function(inputs), or of a pointer to the first.
/// \param program  takes what is recorded, a window at a time; if there is none, the recording is whole
template <std::size_t Lanes, class T, class Function>
[[nodiscard]] RecordedFunction<T> record_function(const Function& function, std::span<const T> inputs,
                                                  Guards guards, ReplayProgram<T>* program = nullptr) {
  using Scalar = Replayable<T, Lanes>;
  ReplayRecorder<T, Lanes> recorder;
  recorder.guards = guards;
  recorder.program = program;
  std::vector<Scalar> variables;
  variables.reserve(inputs.size());
  recorder.recording.append_inputs(inputs.size());
  for (const T input : inputs)
    variables.emplace_back(input,
                           Link(static_cast<std::uint32_t>(variables.size() + 1), recorder.generation));
  const RecorderScope<T, Lanes> scope(recorder);
  const Scalar root = [&]() -> Scalar {
    if constexpr (std::invocable<const Function&, const Scalar*>) {
      return function(variables.data());
    } else {
      return function(std::span<const Scalar>(variables));
    }
  }();
  if (root.is_active() && root.link().generation() != recorder.generation)
    throw DomainError("Replay: the function returns a variable of another recording");
  recorder.end_window();
  return {std::move(recorder.recording), root.is_active() ? root.link().index() : 0, root.value()};
}

}  // namespace tapestry::detail
