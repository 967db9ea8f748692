#pragma once
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <tapestry/core/atomic_file.hpp>
#include <tapestry/core/file_source.hpp>
#include <vector>

#include "../support/driver.hpp"
#include "reference.hpp"

namespace tapestry::benchmarks {

/// A way to do a stage: a program beside the driver, and what it is told with --variant.
struct Variant {
  const char* stage;
  const char* name;
  const char* program;
};

/// Every variant of the benchmark. texture-backward: 4x4-forward shades what 4x4 takes back.
inline const std::vector<Variant> variants = {
    {"visibility", "1x1", "renderer_tapestry"},
    {"visibility", "peer:Embree", "renderer_embree"},
    {"visibility", "peer:llvmpipe", "renderer_llvmpipe"},
    {"frame", "1x1", "renderer_tapestry"},
    {"frame", "2x2", "renderer_tapestry"},
    {"frame", "4x4", "renderer_tapestry"},
    {"frame", "peer:llvmpipe", "renderer_llvmpipe"},
    {"texture-backward", "4x4", "renderer_tapestry"},
    {"texture-backward", "4x4-forward", "renderer_tapestry"},
    {"step", "4x4", "renderer_tapestry"},
    {"step", "4x4-cached", "renderer_tapestry"},
};

inline const std::vector<std::string> stages = {"visibility", "frame", "texture-backward", "step"};

/// One case on so many threads: all variants of its stage, in the order of `variants`.
struct Comparison {
  std::string stage;
  double distance;
  std::size_t size;
  int threads;
  std::string case_name{};
  std::vector<Variant> rivals{};
  std::vector<Contestant> contestants{};  ///< one for each rival
  std::vector<Result> results{};          ///< one for each rival
};

[[nodiscard]] inline std::string case_name_of(const std::string& stage, double distance, std::size_t size) {
  return stage + " d=" + formatted("%g", distance) + " " + std::to_string(size);
}

[[nodiscard]] inline Comparison make_comparison(const std::string& stage, double distance, std::size_t size,
                                                int threads) {
  Comparison comparison{stage, distance, size, threads, case_name_of(stage, distance, size)};
  for (const Variant& variant : variants) {
    if (variant.stage != stage) continue;
    comparison.rivals.push_back(variant);
    comparison.results.push_back({comparison.case_name, variant.name, threads});
  }
  comparison.contestants.resize(comparison.rivals.size());
  return comparison;
}

/// Starts a rival's program.
/// \param mesh  OBJ file, or empty for the procedural car
inline void start(Comparison& comparison, std::size_t rival, const Folders& folders,
                  const std::string& mesh) {
  const Variant& variant = comparison.rivals[rival];
  const std::string threads = std::to_string(comparison.threads);
  std::vector<std::string> command{folders.programs / variant.program,
                                   "--distance",
                                   formatted("%g", comparison.distance),
                                   "--size",
                                   std::to_string(comparison.size),
                                   "--threads",
                                   threads,
                                   "--stage",
                                   comparison.stage,
                                   "--variant",
                                   variant.name};
  if (!mesh.empty()) command.insert(command.end(), {"--mesh", mesh});
  comparison.contestants[rival].start(command, {"OMP_NUM_THREADS=" + threads}, folders.work);
}

/// What the answers of each case should be; made when first asked for, and kept for the other threads.
class References {
 public:
  /// Nothing for a stage that has no answer.
  [[nodiscard]] std::optional<double> error_of(const Comparison& comparison, const Scene& scene,
                                               const std::vector<float>& found) {
    if (found.empty()) return {};
    if (key_ != std::pair(comparison.distance, comparison.size)) {
      key_ = {comparison.distance, comparison.size};
      faces_.clear();
      picture_ = {};
    }
    if (comparison.stage == "visibility") {
      if (faces_.empty()) faces_ = reference_faces(scene, comparison.size);
      return share_of_differences(found, faces_);
    }
    if (picture_.picture.empty()) picture_ = reference_picture(scene, comparison.size);
    return relative_distance(found, comparison.stage == "frame" ? picture_.picture : picture_.face_gradient);
  }

 private:
  std::pair<double, std::size_t> key_{};
  std::vector<double> faces_;
  ReferencePicture picture_;
};

/// Times all rivals in turn and compares their answers with the reference.
inline void measure(Comparison& comparison, const Folders& folders, const std::string& mesh,
                    const Schedule& schedule, const Scene& scene, References& references) {
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) start(comparison, i, folders, mesh);
  run_rounds(comparison.contestants, schedule);
  const std::string path = folders.work / "answer";
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) {
    Contestant& contestant = comparison.contestants[i];
    contestant.attempt([&](Worker& worker) {
      (void)worker.ask("save " + path);
      Result& result = comparison.results[i];
      result.error = references.error_of(comparison, scene, read_numbers<float>(path));
      result.seconds = timing_of(contestant.seconds, 0).median / static_cast<double>(scene.cameras.size());
      result.memory_mib = contestant.peak_memory_mib;
    });
    contestant.worker.reset();
  }
  std::filesystem::remove(path);
}

inline void print(const Comparison& comparison) {
  std::printf("\n%s, %d thread%s\n", comparison.case_name.c_str(), comparison.threads,
              comparison.threads == 1 ? "" : "s");
  std::printf("  %-16s %10s %8s %9s %8s   times ours\n", "", "ms", "spread", "error", "MiB");
  for (std::size_t i = 0; i < comparison.results.size(); ++i) {
    const Result& result = comparison.results[i];
    if (!result.seconds) {
      std::printf("  %-16s %s\n", result.variant.c_str(), comparison.contestants[i].failure.c_str());
      continue;
    }
    const Timing timing = timing_of(comparison.contestants[i].seconds, 0);
    std::printf("  %-16s %10.3f %6.1f %% %9s %8.0f  ", result.variant.c_str(), 1e3 * *result.seconds,
                100 * timing.spread, formatted("%.1e", result.error).c_str(), *result.memory_mib);
    for (const Result& own : comparison.results)
      if (!is_peer(own.variant) && own.seconds)
        std::printf(" %s %.2f", own.variant.c_str(), *result.seconds / *own.seconds);
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace tapestry::benchmarks
