#pragma once
#include "../support/driver.hpp"
#include "network_files.hpp"
#include "reference.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {
/// A way to compute a detector: a program beside the driver, and its value of --engine.
struct Variant {
  std::string name, program, engine;
  bool has_forward = true, has_gradient = true, has_threads = true;
};

/// Every variant of the benchmark.
inline const std::vector<Variant> variants = {
    {"automatic", "detector_tapestry", "automatic"},
    {"direct", "detector_tapestry", "direct"},
    {"winograd_f2", "detector_tapestry", "winograd_f2"},
    {"winograd_f4", "detector_tapestry", "winograd_f4"},
    {"bfloat16", "detector_tapestry", "bfloat16"},
    {"tape", "detector_tapestry", "tape", false},  // automatic, called by way of the tape
    {"peer:oneDNN-best", "detector_onednn", "best"},
    {"peer:oneDNN-direct", "detector_onednn", "direct"},
    {"peer:libtorch-folded-nhwc", "detector_libtorch", "folded-nhwc"},
    {"peer:OpenCV", "detector_opencv_dnn", "", true, false},
    {"peer:darknet", "detector_darknet", "", true, false, false},
};

/// One case on so many threads: all variants that can compute it, in the order of `variants`.
struct Comparison {
  std::string case_name;
  bool wants_gradient;
  int threads;
  double gflop;
  std::vector<Variant> rivals{};
  std::vector<Contestant> contestants{};  ///< one for each rival
  std::vector<std::optional<GradientError>> gradient_errors{};
};

[[nodiscard]] inline Comparison make_comparison(const std::string& case_name, bool wants_gradient,
                                                int threads, double forward_gflop) {
  Comparison comparison{case_name, wants_gradient, threads, forward_gflop * (wants_gradient ? 2 : 1)};
  for (const Variant& variant : variants) {
    if (!(wants_gradient ? variant.has_gradient : variant.has_forward) ||
        (threads > 1 && !variant.has_threads))
      continue;
    comparison.rivals.push_back(variant);
    comparison.contestants.push_back({{case_name, variant.name, threads}});
  }
  comparison.gradient_errors.resize(comparison.rivals.size());
  return comparison;
}

[[nodiscard]] inline std::string answer_path(const Folders& folders, const Comparison& comparison,
                                             std::size_t rival) {
  return folders.work / ("answer-" + std::string(comparison.wants_gradient ? "gradient" : "forward") + "-" +
                         std::to_string(comparison.threads) + "-" + std::to_string(rival));
}

/// Variables that the programs are started with. OpenBLAS, which libtorch calls, knows no processor newer
/// than itself and then leaves AVX-512 unused.
[[nodiscard]] inline std::vector<std::string> worker_environment(int threads) {
  std::vector<std::string> environment{"OMP_NUM_THREADS=" + std::to_string(threads)};
  if (__builtin_cpu_supports("avx512f") != 0) environment.emplace_back("OPENBLAS_CORETYPE=SkylakeX");
  return environment;
}

/// Starts a rival's program.
inline void start(Comparison& comparison, std::size_t rival, const NetworkFiles& files, std::size_t size,
                  const Folders& folders) {
  const Variant& variant = comparison.rivals[rival];
  const std::string threads = std::to_string(comparison.threads);
  std::vector<std::string> command{folders.programs / variant.program,
                                   // The network, and how it runs.
                                   "--cfg", files.cfg, "--weights", files.weights, "--size",
                                   std::to_string(size), "--threads", threads, "--engine", variant.engine};
  if (variant.engine.empty()) command.resize(command.size() - 2);
  if (comparison.wants_gradient) command.emplace_back("--gradient");
  comparison.contestants[rival].start(command, worker_environment(comparison.threads), folders.work);
}

/// Times all rivals and keeps their answers in files. The rivals start one after the other, for they try
/// algorithms while they do.
inline void measure(Comparison& comparison, const NetworkFiles& files, std::size_t size,
                    const Folders& folders, const Schedule& schedule) {
  std::cerr << comparison.case_name << ", threads: " << comparison.threads << std::endl;
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) start(comparison, i, files, size, folders);
  run_rounds(comparison.contestants, schedule);
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i)
    comparison.contestants[i].finish(answer_path(folders, comparison, i), [] {});
}

/// Compares an answer with double precision.
[[nodiscard]] inline double score_answer(Comparison& comparison, std::size_t rival, const Problem& problem,
                                         Reference& reference, const std::string& path) {
  if (!comparison.wants_gradient) return reference.logits_error(read_numbers<float>(path));
  auto& error = comparison.gradient_errors[rival];
  error = reference.gradient_error(read_numbers<float>(path), read_decisions(decisions_path(path), problem));
  return error->relative;
}

/// Fills in the results.
inline void score(Comparison& comparison, const Problem& problem, Reference& reference,
                  const Folders& folders) {
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) {
    Contestant& contestant = comparison.contestants[i];
    if (!contestant.failure.empty()) continue;
    const double largest_rounding = comparison.rivals[i].engine == "bfloat16" ? 5e-2 : 1e-2;
    const std::string path = answer_path(folders, comparison, i);
    contestant.attempt([&] {
      contestant.conclude(score_answer(comparison, i, problem, reference, path), largest_rounding);
    });
    std::filesystem::remove(path);
    std::filesystem::remove(decisions_path(path));
  }
}

/// The columns with the speed of a variant relative to each peer.
[[nodiscard]] inline std::string ratio_columns(const Comparison& comparison, const Result* row) {
  std::string text;
  for (const Contestant& contestant : comparison.contestants) {
    const Result& peer = contestant.result;
    if (!is_peer(peer.variant) || !peer.seconds) continue;
    const std::string title = "x " + peer.variant.substr(5);
    std::string cell = row == nullptr ? title : formatted("%.2f", *peer.seconds / *row->seconds);
    text += "  " + std::string(title.size() - std::min(title.size(), cell.size()), ' ') + cell;
  }
  return text;
}

inline void print(const Comparison& comparison) {
  std::printf("\n%s, %s: %.4g GFLOP done directly\n", comparison.case_name.c_str(),
              thread_title(comparison.threads).c_str(), comparison.gflop);
  std::printf("  %-26s %9s %8s %8s %9s %8s%s%s\n", "", "seconds", "spread", "GFLOP/s", "error", "MiB",
              comparison.wants_gradient ? "  flips      with" : "",
              ratio_columns(comparison, nullptr).c_str());
  for (std::size_t i = 0; i < comparison.contestants.size(); ++i) {
    const Result& result = comparison.contestants[i].result;
    if (!comparison.contestants[i].print(result.variant, 26)) continue;
    std::printf(" %9.5f %6.1f %% %8.1f %9.1e %8.0f", *result.seconds, 100 * *result.spread,
                comparison.gflop / *result.seconds, *result.error, *result.memory_mib);
    if (const auto& gradient = comparison.gradient_errors[i])
      std::printf(" %6zu %9.1e", gradient->changed, gradient->own_decisions);
    std::printf("%s\n", ratio_columns(comparison, &result).c_str());
  }
  std::fflush(stdout);
}
}  // namespace tapestry::benchmarks
