#pragma once
#include "learner.hpp"

namespace tapestry::shell {
/// Sets the first weights, with objectness near 0.01, because most candidates of a picture are background.
inline void initialise(detect::DarknetModel<float>& model, std::uint64_t seed) {
  Random random(seed);
  model.initialise(random);
  const auto& layers = model.config().layers;
  auto head = model.heads().begin();
  for (std::size_t i = 1; i < layers.size(); ++i) {
    if (!detect::is_head(layers[i].kind)) continue;
    for (std::size_t anchor = 0; anchor < head->anchor_count(); ++anchor)
      model.parameters()[model.layout().layers[i - 1].bias + anchor * head->candidate_channel_count() +
                         head->objectness_channel().value()] = -4.6F;
    ++head;
  }
}

/// The text of a cfg whose heads have this number of classes, and the layers before them the filters for it.
inline std::string with_class_count(const std::string& cfg, std::size_t classes) {
  constexpr std::size_t others = 5;  // channels of a candidate beside its classes
  std::istringstream text(cfg);
  std::vector<std::string> lines(1);
  std::size_t filters = 0;  // line that states them last
  for (; std::getline(text, lines.back()); lines.emplace_back()) {
    std::size_t before = 0, old = 0;
    if (lines.back().starts_with("filters=")) filters = lines.size() - 1;
    if (!lines.back().starts_with("classes=") || !io::parse_integer(lines.back().substr(8), before) ||
        !io::parse_integer(lines[filters].substr(8), old))
      continue;
    lines[filters] = "filters=" + std::to_string(old / (others + before) * (others + classes));
    lines.back() = "classes=" + std::to_string(classes);
  }
  std::string changed;
  for (const auto& line : lines) changed += line + "\n";
  return changed;
}

/// A detector of the network of --cfg with random weights, for classes of these names.
inline std::unique_ptr<LearningDetector> fresh_detector(const DetectorSettings& settings,
                                                        const std::vector<std::string>& names,
                                                        std::uint64_t seed) {
  const std::string& path = settings.cfg;
  std::string text = with_class_count(io::read_text_file(path), names.size());
  auto config = io::parse_network_config(text, path);
  if (!settings.decode.empty())
    config = detect::with_decode(std::move(config), detect::decode_family_by_name(settings.decode));
  const bool normalises = std::ranges::any_of(config.layers, &detect::LayerConfig::batch_normalize);
  detect::DarknetModel<float> model(std::move(config), settings.size, settings.size);
  loss::require_raw_logits("train_detector", model.heads());
  initialise(model, seed);
  std::optional<image::Fit> fit;
  if (!settings.fit.empty()) fit = image::fit_by_name(settings.fit);
  return std::make_unique<LearningModel>(std::move(model), std::move(text), names, fit, normalises);
}
}  // namespace tapestry::shell
