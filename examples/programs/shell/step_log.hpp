#pragma once
#include <tapestry/camouflage/training.hpp>
#include "csv.hpp"
#include "progress.hpp"

namespace tapestry::shell {
// Reports of a run about its steps: on the terminal, in history.csv and, with --profile, at the end.

/// \param first    steps taken before this process began
/// \param images number of pictures that this process has used
/// \param seconds since the first step of this process
inline std::string step_text(const camouflage::Training<float>& training, std::uint64_t first,
                             std::size_t images, double seconds) {
  const auto& terms = training.history().back();
  const auto done = static_cast<double>(training.steps_taken() - first);
  const auto left = static_cast<double>(training.step_count() - training.steps_taken());
  std::string text =
      formatted("step %llu/%zu  loss %.4f", static_cast<unsigned long long>(training.steps_taken()),
                training.step_count(), terms.total);
  for (const auto& term : camouflage::ObjectiveTerms::all)
    if (*term.brief != 0) text += formatted("  %s %.3f", term.brief, terms.*term.value);
  return text + formatted("  %.1f images/s  %s left", static_cast<double>(images) / seconds,
                          duration_text(seconds / done * left).c_str());
}

/// \tparam Step has its terms listed in Step::all
template <class Step>
std::string history_csv(const std::vector<Step>& history) {
  constexpr auto& terms = Step::all;
  std::string text = "step";
  for (const auto& term : terms) text.append(",").append(term.name);
  text += '\n';
  for (std::size_t i = 0; i < history.size(); ++i) {
    text += std::to_string(i + 1);
    for (const auto& term : terms) text.append(",").append(csv_line(history[i].*term.value));
    text += '\n';
  }
  return text;
}

/// Prints the time that all threads together spend in each part of a step.
/// \param wall_seconds of all steps
inline void print_profile(const camouflage::StepTimes& times, std::size_t steps, double wall_seconds) {
  const std::vector<std::pair<const char*, double>> parts{{"render", times.render},
                                                          {"composite", times.composite},
                                                          {"detector forward", times.detector_forward},
                                                          {"detector backward", times.detector_backward},
                                                          {"losses", times.losses},
                                                          {"update", times.update}};
  const double all_threads = wall_seconds * thread_count();
  double other = all_threads;
  const auto print = [&](const char* name, double seconds) {
    std::printf("  %-18s %9.3f ms  %5.1f %%\n", name, 1e3 * seconds / static_cast<double>(steps),
                100 * seconds / all_threads);
  };
  std::printf("time of a step on %d %s, summed over them; %zu steps of %.3f ms\n", thread_count(),
              thread_count() == 1 ? "thread" : "threads", steps,
              1e3 * wall_seconds / static_cast<double>(steps));
  for (const auto& [name, seconds] : parts) {
    print(name, seconds);
    other -= seconds;
  }
  print("other, waiting", other);
  const double detector = times.detector_forward + times.detector_backward;
  std::printf("  outside the detector %.1f %%\n", 100 * (1 - detector / all_threads));
}

/// Prints stretches of a run that follow each other: seconds, seconds of all threads, and busy threads.
inline void print_work(const std::vector<std::pair<const char*, WorkTime>>& stretches) {
  std::printf("stretches of the run %13s %11s %13s\n", "wall", "all threads", "busy threads");
  for (const auto& [name, time] : stretches)
    std::printf("  %-20s %9.3f s %9.3f s %13.2f\n", name, time.wall, time.busy,
                time.wall > 0 ? time.busy / time.wall : 0);
}

inline void print_kept_layers(const camouflage::KeptLayers<float>& kept) {
  std::printf("  layers kept of %zu of %zu views, where that saves %.0f %% of the products; ",
              kept.kept_count(), kept.view_count(), 100 * camouflage::least_share_kept);
  std::printf("%.1f MiB, %.1f %% of all saved\n",
              static_cast<double>(kept.bytes()) / double(std::size_t(1) << 20U), 100 * kept.share());
}
}  // namespace tapestry::shell
