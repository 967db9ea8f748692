#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tapestry/core/scoped_timer.hpp>
#include <utility>

namespace tapestry::nn {

/// Time of a network's operations, summed over passes.
struct OperationTimes {
  /// Calls and time of all operations of one operator.
  struct Kind {
    std::size_t calls = 0;
    double seconds = 0;
  };
  std::map<std::string, Kind> kinds{};  ///< by the operator's name; `layout` where axes are put in order
  std::size_t passes = 0;
  double seconds = 0;  ///< of whole passes, which do a little between operations

  /// Counts a pass. \returns where its time is to be added
  [[nodiscard]] double& start_pass() {
    ++passes;
    return seconds;
  }
  /// Counts a call of the operation that a label begins with. \returns where its time is to be added
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

/// Counts a pass and times it until its end of scope; nothing for null.
[[nodiscard]] inline std::optional<ScopedTimer> timed_pass(OperationTimes* times) {
  if (times == nullptr) return std::nullopt;
  return std::optional<ScopedTimer>(std::in_place, times->start_pass());
}

/// The same of a call of the operation that a label begins with.
[[nodiscard]] inline std::optional<ScopedTimer> timed_call(OperationTimes* times, const std::string& label) {
  if (times == nullptr) return std::nullopt;
  return std::optional<ScopedTimer>(std::in_place, times->start_call(label));
}

}  // namespace tapestry::nn
