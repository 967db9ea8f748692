#pragma once
#include <tapestry/camouflage/objective.hpp>
#include "run_options.hpp"

namespace tapestry::shell {
struct CamouflageOptions : RunOptions {
  SceneSettings scene;
  DetectorSettings detector;
  OptimisationSettings optimisation;
  SurveySettings survey;
  std::size_t keep_layers_mib = 2048;
  bool check = false;
  bool lists_methods = false;
  bool profile = false;
};

inline void describe(CLI::App& app, CamouflageOptions& options) {
  add_options(app, options.scene);
  add_options(app, options.detector);
  add_options(app, options.optimisation);
  add_options(app, options.survey);
  add_run_options(app, options, "runs/camouflage");
  app.add_option("--keep-layers-mib", options.keep_layers_mib,
                 "memory of each rank, MiB, for the parts of the network's layers that the car cannot reach, "
                 "so that a step need not compute them again; used for views where that saves a quarter of "
                 "the products or more. 0: everything is computed. Results do not depend on it");
  app.add_flag(
      "--check", options.check,
      "only check every input, look for the car in a few clean views, report all problems, and leave");
  app.add_flag("--list-methods", options.lists_methods,
               "print each --method, a line, with the options it is compared by in the tables of the paper");
  app.add_flag("--profile", options.profile, "print where the time of a step went");
}

/// Settings that decide the result of a run, under the names of the options.
inline Json settings_json(const CamouflageOptions& options) {
  return json_of_settings(options.scene, options.detector, options.optimisation, options.survey);
}

/// Checks that a method gets the texture, the light and the detectors it needs.
inline void require_fit(const OptimisationSettings& optimisation, const SceneSettings& scene,
                        ProblemList& list) {
  const auto& methods = camouflage::methods<float>();
  const auto method = std::ranges::find(methods, optimisation.method, &camouflage::NamedMethod<float>::name);
  if (method == methods.end()) return;
  const std::string named = "--method " + method->name;
  list.require(!method->traits.maps_attention || optimisation.ensemble.empty(),
               named + " scatters the attention of one detector; it takes no --ensemble");
  list.require(!method->traits.maps_attention || optimisation.loss == OptimisationSettings{}.loss,
               "--loss has no part in " + named + ", whose loss is the attention");
  list.require(method->traits.is_optimised ||
                   (optimisation.objective.printability == 0 && optimisation.worst_views == 1),
               "--printability and --worst-views have no part in " + named + ", which is not optimised");
  list.require(!method->traits.needs_atlas || scene.texture == "atlas",
               named + " paints parts of an atlas; it needs --texture atlas");
  const bool is_filtered = scene.texture == "atlas" && scene.filter != "bilinear";
  list.require(!method->traits.moves_shape || (!is_filtered && scene.light == "frame"),
               named +
                   " moves the mesh, by which --filter anisotropic and trilinear and --light photo cannot be "
                   "differentiated; it needs --filter bilinear and --light frame");
  list.require(!method->traits.needs_photo_light || scene.light != "frame",
               named + " takes its light from the photographs; it needs --light photo");
}

/// Checks the options. To resume a run, the settings come from its manifest and are checked there.
inline void require_sound(const CamouflageOptions& options, ProblemList& list) {
  require_sound_run(options, list);
  list.require(options.keep_layers_mib <= std::size_t(1) << 24U,
               "--keep-layers-mib must be at most 16777216");
  if (options.resume) return;
  require_sound(options.scene, list);
  require_sound(options.detector, list);
  require_sound(options.optimisation, list);
  require_sound(options.survey, list);
  require_fit(options.optimisation, options.scene, list);
}

inline camouflage::ObjectiveOptions objective_options(const OptimisationSettings& o,
                                                      std::size_t class_index) {
  camouflage::ObjectiveOptions objective = o.objective;
  objective.kind = loss::adversarial_loss_by_name(o.loss);
  objective.class_index = class_index;
  return objective;
}
}  // namespace tapestry::shell
