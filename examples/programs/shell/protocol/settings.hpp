#pragma once
#include <CLI/CLI.hpp>
#include "../problem_list.hpp"

namespace tapestry::shell {
inline constexpr std::size_t most_noise_draws = 1000;

/// The paper's measurement to repeat, and its settings.
struct ProtocolSettings {
  std::string protocol;  ///< its name; empty: none
  std::string controls = "all";
  std::size_t noise_draws = 1;
  std::vector<double> background{1, 1, 1};
  std::vector<std::string> further_weights;
  std::string heat_map_kind = "layer_cam";
  bool quick = false;
};

inline void add_options(CLI::App& app, ProtocolSettings& s, const std::string& protocols) {
  app.option_defaults()->group("Protocol");
  app.add_option("--protocol", s.protocol, "measure a table of the FCA paper: " + protocols);
  app.add_option(
      "--controls", s.controls,
      "of --protocol: {all}, or {matched} for noise and shuffled patches alone, without plain colours");
  app.add_option("--noise-draws", s.noise_draws,
                 "of --protocol: draws of matched noise, whose spread widens the intervals of effects");
  app.add_option("--background", s.background,
                 "of protocols that render the car alone: colour behind it, three numbers from 0 to 1")
      ->expected(3);
  app.add_option("--further-weights", s.further_weights,
                 "of protocols on photographs: further detectors, a column each, .onnx models, with the same "
                 "--class for the car");
  app.add_option("--heat-map-kind", s.heat_map_kind,
                 "of --protocol attention: {layer_cam}, {grad_cam} or {grad_cam_plus_plus}");
  app.add_flag("--quick", s.quick, "of --protocol: fewer views, for a first look");
}

/// Checks for options that a protocol does not use, and for options that only a protocol uses.
/// \param on_photographs whether the protocol measures photographs, not renders
/// \param before_plain_background whether the protocol measures the car alone
inline void require_protocol_options(const CLI::App& app, const ProtocolSettings& s, bool on_photographs,
                                     bool before_plain_background, bool clean_only, ProblemList& list) {
  const auto refuse = [&](const std::vector<const char*>& options, const std::string& why) {
    for (const char* option : options) list.require(app.get_option(option)->count() == 0, option + why);
  };
  if (s.protocol.empty())
    refuse({"--controls", "--noise-draws", "--background", "--quick", "--further-weights", "--heat-map-kind"},
           " needs --protocol: digital measures the same frames, views the car alone, attention heat maps");
  else
    refuse({"--scenes", "--sweep", "--conditions", "--draws", "--against"}, " has no part in --protocol");
  if (!s.protocol.empty() && s.protocol != "attention")
    refuse({"--heat-map-kind"}, " has no part in --protocol " + s.protocol);
  if (!s.protocol.empty() && !before_plain_background)
    refuse({"--background"}, " has no part in --protocol " + s.protocol);
  if (!s.protocol.empty() && !on_photographs)
    refuse({"--frames", "--mask", "--segmenter", "--light", "--unpainted", "--further-weights"},
           " has no part in --protocol " + s.protocol);
  if (s.protocol == "attention") refuse({"--pictures"}, " has no part in --protocol attention; digital does");
  if (!s.further_weights.empty()) refuse({"--pictures"}, " has no part in --further-weights");
  if (clean_only) refuse({"--controls", "--noise-draws"}, " has no part in --clean-only");
}

inline void require_sound(const ProtocolSettings& s, const std::vector<std::string>& protocols,
                          ProblemList& list) {
  if (s.protocol.empty()) return;
  list.require_choice("--protocol", s.protocol, protocols);
  require_sound(SurveySettings{s.controls}, list);
  list.require(s.noise_draws >= 1 && s.noise_draws <= most_noise_draws,
               "--noise-draws takes 1 to " + std::to_string(most_noise_draws));
  for (const double channel : s.background)
    list.require(channel >= 0 && channel <= 1, "--background takes numbers from 0 to 1");
}
}  // namespace tapestry::shell
