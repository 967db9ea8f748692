#pragma once
#include <numeric>
#include <tapestry/evaluate/detail/fate.hpp>

namespace tapestry::evaluate {

ViewOutcome outcome_of(const std::vector<detect::Detection>& detections, const loss::Target& target,
                       const std::vector<std::size_t>& related) {
  ViewOutcome outcome;
  for (const detect::Detection& detection : detections) {
    const double overlap = detect::iou(detection.box, target.box);
    const bool is_own = detection.class_index == target.class_index;
    Fate fate = Fate::lost;
    if (overlap >= 0.5)
      fate = is_own                                                   ? Fate::found
             : std::ranges::count(related, detection.class_index) > 0 ? Fate::related
                                                                      : Fate::renamed;
    else if (overlap >= 0.1 && is_own)
      fate = Fate::misplaced;
    if (fate == Fate::lost || fate > outcome.fate) continue;
    if (fate == outcome.fate && detection.confidence <= outcome.confidence) continue;
    outcome = {fate, detection.class_index, detection.confidence};
  }
  return outcome;
}

std::vector<std::size_t> related_classes(const std::vector<std::string>& names, std::size_t class_index) {
  constexpr std::array road_users{"car", "truck", "bus", "train", "van"};
  const auto is_road_user = [&](const std::string& name) { return std::ranges::count(road_users, name) > 0; };
  std::vector<std::size_t> related;
  if (class_index >= names.size() || !is_road_user(names[class_index])) return related;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (k != class_index && is_road_user(names[k])) related.push_back(k);
  return related;
}

std::size_t FateCounts::all() const {
  return std::accumulate(pictures.begin(), pictures.end(), std::size_t{0});
}

std::vector<std::size_t> FateCounts::commonest_names(std::size_t most) const {
  std::vector<std::size_t> classes;
  for (std::size_t k = 0; k < renamed_to.size(); ++k)
    if (renamed_to[k] > 0) classes.push_back(k);
  std::ranges::stable_sort(classes,
                           [&](std::size_t a, std::size_t b) { return renamed_to[a] > renamed_to[b]; });
  if (classes.size() > most) classes.resize(most);
  return classes;
}

FateCounts fate_counts(const std::vector<ViewOutcome>& outcomes) {
  FateCounts counts;
  for (const ViewOutcome& outcome : outcomes) {
    ++counts.pictures[static_cast<std::size_t>(outcome.fate)];
    if (outcome.fate != Fate::renamed) continue;
    if (counts.renamed_to.size() <= outcome.class_index) counts.renamed_to.resize(outcome.class_index + 1);
    ++counts.renamed_to[outcome.class_index];
  }
  return counts;
}

}  // namespace tapestry::evaluate
