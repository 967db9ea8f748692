#pragma once
#include <tapestry/evaluate/dataset/dataset.hpp>
#include "detector_inputs.hpp"

namespace tapestry::shell {
struct ClassMatching {
  std::vector<std::string> names{};                       ///< in the order of the data set
  std::vector<std::uint64_t> ids{};                       ///< of the data set
  std::vector<std::optional<std::size_t>> of_dataset{};   ///< index here, by class of the data set
  std::vector<std::optional<std::size_t>> of_detector{};  ///< index here, by class of the detector
  std::vector<std::string> warnings{};
};

namespace detail {
/// COCO's name of a class that has another name in Pascal VOC, and in Darknet's lists after it.
inline std::string_view coco_name(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> others[] = {
      {"aeroplane", "airplane"},   {"diningtable", "dining table"},
      {"motorbike", "motorcycle"}, {"pottedplant", "potted plant"},
      {"sofa", "couch"},           {"tvmonitor", "tv"}};
  for (const auto& [other, coco] : others)
    if (name == other) return coco;
  return name;
}

inline std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 10;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) list += (i > 0 ? ", " : "") + names[i];
  return names.size() > most ? list + ", … (" + std::to_string(names.size()) + " in all)" : list;
}

/// The detector's class with this name, or with an unused synonym.
inline std::optional<std::size_t> detector_class(const std::string& name,
                                                 const detect::Detector<float>& detector,
                                                 const ClassMatching& matching) {
  for (const bool is_exact : {true, false})
    for (std::size_t i = 0; i < detector.names().size(); ++i)
      if (!matching.of_detector[i] &&
          (is_exact ? detector.names()[i] == name : coco_name(detector.names()[i]) == coco_name(name)))
        return i;
  return std::nullopt;
}

/// Reports unmatched classes. Refuses a data set without a class in common or, where all are needed, with
/// one that the detector lacks.
inline void judge_unmatched(const std::string& dataset_path, const evaluate::Dataset& dataset,
                            const detect::Detector<float>& detector, bool needs_all,
                            ClassMatching& matching) {
  std::vector<std::string> left_out, unasked;
  for (std::size_t k = 0; k < dataset.class_names.size(); ++k)
    if (!matching.of_dataset[k]) left_out.push_back(dataset.class_names[k]);
  for (std::size_t i = 0; i < detector.names().size(); ++i)
    if (!matching.of_detector[i]) unasked.push_back(detector.names()[i]);
  if (matching.names.empty() || (needs_all && !left_out.empty()))
    throw file_mismatch({dataset_path, "",
                         std::string(matching.names.empty() ? "no class has a name that the detector knows"
                                                            : "classes that the detector does not know") +
                             "; --classes names or leaves out classes",
                         listed(detector.names()), listed(left_out)});
  if (!left_out.empty())
    matching.warnings.push_back(dataset_path +
                                ": the detector does not know these classes, left out: " + listed(left_out));
  if (!unasked.empty())
    matching.warnings.push_back(dataset_path +
                                ": lacks these classes of the detector, left out: " + listed(unasked));
}
}  // namespace detail

/// Matches classes by their names. Classes of a data set without names are the detector's numbers. Pascal VOC
/// and Darknet's lists have other names for six of COCO's classes; both names are accepted.
/// \param needs_all  whether the detector must know all of them
/// \throws Error (usage) if only the data set names its classes, FileError (mismatch) if they share none, or
///         not all that are needed
inline ClassMatching match_classes(const std::string& dataset_path, const evaluate::Dataset& dataset,
                                   const detect::Detector<float>& detector, bool needs_all = false) {
  const std::size_t count = detector.heads().front().classes;
  ClassMatching matching;
  matching.of_detector.resize(count);
  if (dataset.class_names.empty()) {
    for (std::size_t i = 0; i < count; ++i) {
      matching.of_detector[i] = i;
      matching.names.push_back(i < detector.names().size() ? detector.names()[i] : std::to_string(i));
      matching.ids.push_back(i);
    }
    matching.of_dataset = matching.of_detector;
    return matching;
  }
  if (detector.names().empty())
    throw Error(ErrorKind::usage,
                "--names is missing: " + dataset_path + " names its classes, the detector does not");
  matching.of_dataset.resize(dataset.class_names.size());
  for (std::size_t k = 0; k < dataset.class_names.size(); ++k) {
    const auto of_detector = detail::detector_class(dataset.class_names[k], detector, matching);
    if (!of_detector) continue;
    matching.of_dataset[k] = matching.of_detector[*of_detector] = matching.names.size();
    matching.names.push_back(dataset.class_names[k]);
    matching.ids.push_back(dataset.class_ids[k]);
  }
  detail::judge_unmatched(dataset_path, dataset, detector, needs_all, matching);
  return matching;
}
}  // namespace tapestry::shell
