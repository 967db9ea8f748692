#pragma once
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tapestry::test {
/// Cases of a differential test: one random case a seed, until a budget of seconds is spent.
///
///   DifferentialRun run("random networks", 20);
///   while (run.next()) {
///     INFO(run.repeat());
///     check(random_network(run.seed()));
///   }
///
/// TAPESTRY_DIFFERENTIAL_SECONDS replaces the budget. TAPESTRY_DIFFERENTIAL_SEED is the first seed, 1 unless
/// set; without TAPESTRY_DIFFERENTIAL_SECONDS it is then the only one. At least one case runs.
class DifferentialRun {
 public:
  /// \throws std::runtime_error if one of the variables is set to something that is not a number
  DifferentialRun(std::string_view name, double default_seconds)
      : name_(name), seconds_(variable<double>(seconds_variable).value_or(default_seconds)) {
    const auto first = variable<std::uint64_t>(seed_variable);
    first_ = first.value_or(1);
    if (first && !variable<double>(seconds_variable)) seconds_ = 0;
  }
  DifferentialRun(const DifferentialRun&) = delete;
  DifferentialRun& operator=(const DifferentialRun&) = delete;

  /// Prints how many cases ran, their seeds and how many a minute.
  ~DifferentialRun() {
    if (cases_ == 0) return;
    const double passed = elapsed();
    std::cout << name_ << ": " << cases_ << " cases, seeds " << first_ << " to " << seed() << ", in "
              << passed << " s, " << 60 * static_cast<double>(cases_) / passed << " a minute" << std::endl;
  }

  /// Goes on to the next seed; false once the budget is spent.
  [[nodiscard]] bool next() {
    if (cases_ > 0 && elapsed() >= seconds_) return false;
    ++cases_;
    return true;
  }

  /// The seed of this case; valid after next() has returned true.
  [[nodiscard]] std::uint64_t seed() const { return first_ + cases_ - 1; }

  /// Seconds since the run began.
  [[nodiscard]] double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

  /// The words to put before the test's command line to run this case alone.
  [[nodiscard]] std::string repeat() const {
    std::string text(seed_variable);
    text += '=';
    return text += std::to_string(seed());
  }

 private:
  static constexpr const char* seconds_variable = "TAPESTRY_DIFFERENTIAL_SECONDS";
  static constexpr const char* seed_variable = "TAPESTRY_DIFFERENTIAL_SEED";

  template <class Number>
  static std::optional<Number> variable(const char* name) {
    const char* const text = std::getenv(name);
    if (text == nullptr) return std::nullopt;
    std::istringstream stream(text);
    Number number{};
    if (!(stream >> number) || stream.peek() != std::istringstream::traits_type::eof())
      throw std::runtime_error(std::string(name) + ": found '" + text + "', expected a number");
    return number;
  }

  std::string name_;
  double seconds_;
  std::uint64_t first_ = 1, cases_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};
}  // namespace tapestry::test
