#pragma once
#include <memory>
#include <thread>
#include "result.hpp"
#include "worker.hpp"

namespace tapestry::benchmarks {
/// The quantile of a sorted list, between 0 and 1, interpolated.
[[nodiscard]] inline double quantile(const std::vector<double>& sorted, double part) {
  const double position = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// Seconds of a pass over all rounds.
struct Timing {
  double median = 0;
  double spread = 0;  ///< half the distance of the quartiles, as a part of the median
};

[[nodiscard]] inline Timing timing_of(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const double median = quantile(seconds, 0.5);
  return {median, (quantile(seconds, 0.75) - quantile(seconds, 0.25)) / (2 * median)};
}

/// One contestant of a comparison. A worker that failed is gone, and `failure` holds the reason.
struct Contestant {
  Result result;
  std::unique_ptr<Worker> worker{};
  std::string failure{};
  std::vector<double> seconds{};
  double peak_memory_mib = 0;

  /// Starts a program, unless it was not built, and waits until it is ready.
  /// \param command      the program's path, then its arguments
  /// \param environment  see Worker
  /// \param folder       where it runs and its log is
  void start(const std::vector<std::string>& command, const std::vector<std::string>& environment,
             const std::filesystem::path& folder) {
    attempt([&] {
      const std::filesystem::path program = command.front();
      if (!std::filesystem::exists(program)) throw Error(ErrorKind::usage, "not built");
      worker = std::make_unique<Worker>(command, environment, folder, program.filename().string() + ".log");
      (void)worker->reply();
    });
  }

  /// Calls use() unless the contestant has failed, before or by that.
  template <class Use>
  void attempt(Use use) {
    if (!failure.empty()) return;
    try {
      use();
    } catch (const std::exception& error) {
      failure = error.what();
      worker.reset();
    }
  }

  /// Has the last answer written to a file, and then calls use(). The worker ends.
  template <class Use>
  void finish(const std::string& answer, Use use) {
    attempt([&] {
      (void)worker->ask("save " + answer);
      use();
    });
    worker.reset();
  }

  /// Fills in the result.
  /// \param parts  of a pass that the seconds are of one of
  /// \throws Error  for an error beyond all rounding: it computes something else, so that its time means
  ///                nothing
  void conclude(std::optional<double> error, double largest_error, double parts = 1) {
    if (error && !(*error <= largest_error))
      throw Error(ErrorKind::numeric, "computes something else: an error of " + formatted("%.1e", error));
    const Timing timing = timing_of(seconds);
    result.error = error;
    result.seconds = timing.median / parts;
    result.spread = timing.spread;
    result.memory_mib = peak_memory_mib;
  }

  /// Begins a row of a table with a name, in a column so wide, and ends it with the failure if there is one.
  /// \returns whether there are figures
  [[nodiscard]] bool print(const std::string& name, int width) const {
    std::printf("  %-*s", width, name.c_str());
    if (!result.seconds) std::printf(" %s\n", failure.c_str());
    return result.seconds.has_value();
  }
};

struct Schedule {
  int rounds = 7;
  double seconds = 0.5;  ///< of a turn
};

/// Lets the contestants run in turn, each round begun by another one, so that whatever slows the machine down
/// slows all of them. The pause before a turn lasts longer than the threads of the one before keep spinning.
inline void run_rounds(std::vector<Contestant>& contestants, const Schedule& schedule) {
  constexpr auto pause = std::chrono::milliseconds(20);
  for (int round = 0; round < schedule.rounds; ++round) {
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      Contestant& contestant = contestants[(i + static_cast<std::size_t>(round)) % contestants.size()];
      contestant.attempt([&] {
        std::this_thread::sleep_for(pause);
        const auto reply = contestant.worker->ask("turn " + std::to_string(schedule.seconds));
        const auto seconds = reply.at("seconds").get<std::vector<double>>();
        contestant.seconds.insert(contestant.seconds.end(), seconds.begin(), seconds.end());
        contestant.peak_memory_mib = reply.at("peak_memory_mib").get<double>();
      });
    }
  }
}
}  // namespace tapestry::benchmarks
