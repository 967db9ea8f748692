#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <tapestry/camouflage/objective.hpp>
#include <utility>
#include <vector>

#include "command_line.hpp"
#include "problem_list.hpp"
#include "run_manifest.hpp"
#include "settings.hpp"

namespace tapestry::shell {

/// What the program camouflage is asked for.
struct CamouflageOptions {
  SceneSettings scene;
  DetectorSettings detector;
  OptimisationSettings optimisation;
  std::string output;
  int threads = 0;
  std::size_t checkpoint_steps = 50;
  std::size_t keep_mib = 4096;
  bool resume = false;
  bool check = false;
  bool profile = false;
};

inline void describe(CLI::App& app, CamouflageOptions& options) {
  add_options(app, options.scene);
  add_options(app, options.detector);
  add_options(app, options.optimisation);
  app.add_option("--output", options.output, "run folder; runs/camouflage-001, -002, ... when left out");
  app.add_option("--threads", options.threads, "threads; 0: all cores. Results do not depend on it")
      ->capture_default_str();
  app.add_option("--checkpoint-steps", options.checkpoint_steps, "steps between checkpoints")
      ->capture_default_str();
  app.add_option("--keep-mib", options.keep_mib,
                 "memory for prepared views, MiB; those beyond are prepared anew")
      ->capture_default_str();
  app.add_flag("--resume", options.resume,
               "go on with the run in --output; settings not given are taken from it");
  app.add_flag("--check", options.check, "only check every input, report all problems, and leave");
  app.add_flag("--profile", options.profile, "print where the time of a step went");
}

/// What decides the result of a run, under the names of the options.
inline Json settings_json(const CamouflageOptions& options) {
  Json json = Json::object();
  add_json(json, options.scene);
  add_json(json, options.detector);
  add_json(json, options.optimisation);
  return json;
}

/// Of a run to resume, the settings come from its manifest and are checked there.
inline void require_sound(const CamouflageOptions& options, ProblemList& list) {
  require_sound_thread_count(options.threads, list);
  list.require(options.checkpoint_steps > 0, "--checkpoint-steps must be at least 1");
  list.require(options.keep_mib <= std::size_t(1) << 24U, "--keep-mib must be at most 16777216");
  if (options.resume) return;
  require_sound(options.scene, list);
  require_sound(options.detector, list);
  require_sound(options.optimisation, list);
}

inline camouflage::ObjectiveOptions objective_options(const OptimisationSettings& o,
                                                      std::size_t class_index) {
  camouflage::ObjectiveOptions objective;
  objective.kind = loss::adversarial_loss_by_name(o.loss);
  objective.weights.iou = o.iou;
  objective.weights.objectness = o.objectness;
  objective.weights.classification = o.classification;
  objective.weights.max_score = o.max_score;
  objective.smoothness = o.smoothness;
  objective.class_index = class_index;
  return objective;
}

/// Takes the settings of a run to resume from its folder.
inline void adopt_run(const CLI::App& app, CamouflageOptions& options) {
  if (options.output.empty()) throw Error(ErrorKind::usage, "--resume needs --output, the folder of the run");
  const std::string path = manifest_path(options.output);
  if (!is_there(path, ErrorKind::malformed))
    throw FileError(ErrorKind::malformed, {path, "", "no run to resume: the file is missing"});
  const Json saved = read_manifest(options.output);
  std::vector<std::string> differing;
  adopt_saved(app, saved["options"], path, options.scene, differing);
  adopt_saved(app, saved["options"], path, options.detector, differing);
  adopt_saved(app, saved["options"], path, options.optimisation, differing);
  if (differing.empty()) return;
  std::string list;
  for (const auto& name : differing) list += (list.empty() ? "" : ", ") + name;
  throw Error(ErrorKind::in_use, options.output + ": cannot resume with other settings: " + list);
}

/// What to type to go on; settings come from the manifest.
inline std::string resume_command(const CLI::App& app, const char* program,
                                  const CamouflageOptions& options) {
  std::vector<std::string> words{program, "--resume", "--output", options.output};
  std::vector<std::string> from_manifest{"resume", "output"};
  const Json settings = settings_json(options);
  for (const auto& setting : settings.items()) from_manifest.push_back(setting.key());
  for (auto& word : given_options(app, from_manifest)) words.push_back(std::move(word));
  return shell_line(words);
}

}  // namespace tapestry::shell
