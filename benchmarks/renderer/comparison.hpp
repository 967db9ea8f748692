#pragma once
#include <map>
#include "../support/driver.hpp"
#include "../support/relative_distance.hpp"
#include "expected.hpp"

namespace tapestry::benchmarks {
/// A way to do a stage: a program beside the driver, and its value of --variant.
struct Variant {
  const char* stage;
  const char* name;
  const char* program;
};

/// Every variant of the benchmark. texture-backward: 4x4-forward shades what 4x4 takes back. vertex-gradient:
/// a gradient model and the coverage rate of what it samples.
inline const std::vector<Variant> variants = {
    {"visibility", "1x1", "renderer_tapestry"},
    {"visibility", "peer:Embree", "renderer_embree"},
    {"visibility", "peer:llvmpipe", "renderer_llvmpipe"},
    {"frame", "1x1", "renderer_tapestry"},
    {"frame", "2x2", "renderer_tapestry"},
    {"frame", "4x4", "renderer_tapestry"},
    {"frame", "automatic", "renderer_tapestry"},
    {"frame", "peer:llvmpipe", "renderer_llvmpipe"},
    {"texture-backward", "4x4", "renderer_tapestry"},
    {"texture-backward", "4x4-forward", "renderer_tapestry"},
    {"step", "1x1", "renderer_tapestry"},
    {"step", "2x2", "renderer_tapestry"},
    {"step", "4x4", "renderer_tapestry"},
    {"step", "8x8", "renderer_tapestry"},
    {"step", "automatic", "renderer_tapestry"},
    {"step", "4x4-cached", "renderer_tapestry"},
    {"vertex-gradient", "boundary_integral-1x1", "renderer_tapestry"},
    {"vertex-gradient", "boundary_integral-2x2", "renderer_tapestry"},
    {"vertex-gradient", "boundary_integral-4x4", "renderer_tapestry"},
    {"vertex-gradient", "boundary_integral-8x8", "renderer_tapestry"},
    {"vertex-gradient", "boundary_integral-automatic", "renderer_tapestry"},
    {"vertex-gradient", "interior_only-1x1", "renderer_tapestry"},
    {"vertex-gradient", "interior_only-4x4", "renderer_tapestry"},
    {"vertex-gradient", "neural_mesh_renderer-1x1", "renderer_tapestry"},
    {"vertex-gradient", "neural_mesh_renderer-2x2", "renderer_tapestry"},
};

inline const std::vector<std::string> stages = {"visibility", "frame", "texture-backward", "step",
                                                "vertex-gradient"};

/// Pictures up to this size have a reference of the vertex gradient, which takes 17 pictures, and are given
/// to Neural Mesh Renderer's gradient, whose work grows with the cube of the size.
inline constexpr std::size_t largest_scored_motion = 256;

/// One case on so many threads: all variants of its stage, in the order of `variants`.
struct Comparison {
  std::string stage;
  double distance;
  std::size_t size;
  int threads;
  std::string case_name{};
  std::vector<Variant> rivals{};
  std::vector<Contestant> contestants{};             ///< one for each rival
  std::vector<std::optional<double>> working_mib{};  ///< one for each rival: see serve()
};

[[nodiscard]] inline std::string case_name_of(const std::string& stage, double distance, std::size_t size) {
  return stage + " d=" + formatted("%g", distance) + " " + std::to_string(size);
}

[[nodiscard]] inline Comparison make_comparison(const std::string& stage, double distance, std::size_t size,
                                                int threads) {
  Comparison comparison{stage, distance, size, threads, case_name_of(stage, distance, size)};
  for (const Variant& variant : variants) {
    if (variant.stage != stage) continue;
    const bool is_slow = std::string(variant.name).find("neural_mesh_renderer") == 0;
    if (is_slow && size > largest_scored_motion) continue;
    comparison.rivals.push_back(variant);
    comparison.contestants.push_back({{comparison.case_name, variant.name, threads}});
  }
  comparison.working_mib.resize(comparison.rivals.size());
  return comparison;
}

/// Starts a rival's program.
/// \param mesh  OBJ file, or empty for the procedural car
inline void start(Comparison& comparison, std::size_t rival, const Folders& folders,
                  const std::string& mesh) {
  const Variant& variant = comparison.rivals[rival];
  const std::string threads = std::to_string(comparison.threads);
  std::vector<std::string> command{folders.programs / variant.program,
                                   // The scene, and what is done with it.
                                   "--distance", formatted("%g", comparison.distance), "--size",
                                   std::to_string(comparison.size), "--threads", threads, "--stage",
                                   comparison.stage, "--variant", variant.name};
  if (!mesh.empty()) command.insert(command.end(), {"--mesh", mesh});
  comparison.contestants[rival].start(command, {"OMP_NUM_THREADS=" + threads}, folders.work);
}

/// Expected answers of each case; computed on first use, and kept for the other threads.
class References {
 public:
  /// Nothing for a case that has no reference.
  [[nodiscard]] std::optional<double> error_of(const Comparison& comparison, const Scene& scene,
                                               const std::vector<float>& found) {
    const auto key = std::tuple(comparison.stage == "step" ? "texture-backward" : comparison.stage,
                                comparison.distance, comparison.size);
    if (std::get<0>(key) == "vertex-gradient" && comparison.size > largest_scored_motion) return {};
    std::vector<double>& expected = answers_[key];
    if (expected.empty()) expected = make(std::get<0>(key), scene, comparison.size);
    return comparison.stage == "visibility" ? share_of_differences(found, expected)
                                            : relative_distance(found, expected);
  }

 private:
  [[nodiscard]] static std::vector<double> make(const std::string& stage, const Scene& scene,
                                                std::size_t size) {
    if (stage == "visibility") return expected_faces(scene, size);
    if (stage == "frame") return expected_frame(scene, size);
    if (stage == "vertex-gradient") return expected_motion_derivatives(scene, size);
    return expected_face_gradient(scene, size);
  }

  std::map<std::tuple<std::string, double, std::size_t>, std::vector<double>> answers_;
};

/// Times all rivals in turn and compares their answers with the reference.
inline void measure(Comparison& comparison, const Folders& folders, const std::string& mesh,
                    const Schedule& schedule, const Scene& scene, References& references) {
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) start(comparison, i, folders, mesh);
  run_rounds(comparison.contestants, schedule);
  const std::string path = folders.work / "answer";
  for (std::size_t i = 0; i < comparison.rivals.size(); ++i) {
    Contestant& contestant = comparison.contestants[i];
    contestant.finish(path, [&] {
      contestant.conclude(references.error_of(comparison, scene, read_numbers<float>(path)),
                          std::numeric_limits<double>::infinity(), static_cast<double>(scene.cameras.size()));
      const auto memory = contestant.worker->ask("memory");
      if (memory.contains("working_mib")) comparison.working_mib[i] = memory["working_mib"].get<double>();
    });
  }
  std::filesystem::remove(path);
}

/// Memory that a picture of a mesh may take beside mesh and texture: 24 B a pixel and 64 B a face.
[[nodiscard]] inline double allowed_mib(const Scene& scene, std::size_t size) {
  return static_cast<double>(24 * size * size + 64 * scene.mesh.faces.size()) / (1 << 20);
}

inline void print(const Comparison& comparison, const Scene& scene) {
  const double allowed = allowed_mib(scene, comparison.size);
  const bool is_picture = comparison.stage == "visibility" || comparison.stage == "frame";
  std::printf("\n%s, %s\n", comparison.case_name.c_str(), thread_title(comparison.threads).c_str());
  std::printf("  %-24s %9s %8s %9s %8s %9s   times ours\n", "", "ms", "spread", "error", "MiB", "working");
  for (std::size_t i = 0; i < comparison.contestants.size(); ++i) {
    const Result& result = comparison.contestants[i].result;
    if (!comparison.contestants[i].print(result.variant, 24)) continue;
    std::printf(" %9.3f %6.1f %% %9s %8.0f %9s  ", 1e3 * *result.seconds, 100 * *result.spread,
                formatted("%.1e", result.error).c_str(), *result.memory_mib,
                formatted("%.2f", comparison.working_mib[i]).c_str());
    for (const Contestant& other : comparison.contestants)
      if (const Result& own = other.result; !is_peer(own.variant) && own.seconds && is_peer(result.variant))
        std::printf(" %s %.2f", own.variant.c_str(), *result.seconds / *own.seconds);
    if (comparison.working_mib[i] && is_picture)
      std::printf(" %.2f of 24 B a pixel and 64 B a face", *comparison.working_mib[i] / allowed);
    std::printf("\n");
  }
  std::fflush(stdout);
}

/// Adds the memory that a pass needs, in rows of their own: VARIANT-working.
inline void add_working_memory(const Comparison& comparison, std::vector<Result>& results) {
  for (std::size_t i = 0; i < comparison.contestants.size(); ++i) {
    if (!comparison.working_mib[i]) continue;
    const Result& result = comparison.contestants[i].result;
    results.push_back(
        {result.case_name, result.variant + "-working", result.threads, {}, {}, comparison.working_mib[i]});
  }
}
}  // namespace tapestry::benchmarks
