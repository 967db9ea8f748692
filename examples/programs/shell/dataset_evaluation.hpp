#pragma once
#include <tapestry/evaluate/dataset/readers.hpp>
#include "class_matching.hpp"
#include "inputs.hpp"
#include "picture_detections.hpp"
#include "precision_report.hpp"
#include "program.hpp"
#include "progress.hpp"

namespace tapestry::shell {
/// Where the labelled pictures are, and the detector's names of their classes.
struct LabelSettings {
  std::string dataset;
  std::string images;
  std::string class_names;
  std::vector<std::string> classes;
};

/// Values of the options of LabelSettings, for their help.
inline constexpr const char* dataset_help =
    "COCO's instances (.json), a list of pictures (.txt), a folder of Pascal VOC's labels (.xml), or one of "
    "pictures with YOLO's labels";
inline constexpr const char* images_help =
    "folder of a COCO or VOC data set's pictures; left out, that of the .json, or JPEGImages";
inline constexpr const char* dataset_names_help =
    "names of the classes in YOLO's labels, one a line; left out, they are the detector's";
inline constexpr const char* classes_help =
    "the detector's names of classes that the data set calls otherwise, vehicle=car, or leaves out, sign=";

/// The labelled pictures, and the output files; an empty path writes nothing.
struct DatasetSettings : LabelSettings {
  std::string results;
  std::string csv;
  std::string json;
  std::size_t most_detections = 100;
};

inline constexpr double dataset_confidence = 0.001;  ///< precision needs weak detections, too

inline void add_options(CLI::App& app, DatasetSettings& s) {
  app.option_defaults()->group("Data set instead of a camouflage");
  app.add_option(
      "--dataset", s.dataset,
      std::string("labelled pictures on which average precision is measured as COCO does, instead of a "
                  "camouflage: ") +
          dataset_help + "; --confidence is then 0.001 unless given");
  app.add_option("--images", s.images, images_help);
  app.add_option("--dataset-names", s.class_names, dataset_names_help);
  app.add_option("--classes", s.classes, classes_help);
  app.add_option("--most-detections", s.most_detections,
                 "of a picture, the most confident of all classes that the data set has; COCO allows 100");
  app.add_option("--results", s.results, "file for the detections as COCO's results (.json)");
  app.add_option("--csv", s.csv, "file for the table of --dataset as CSV");
  app.add_option("--json", s.json, "file for the table of --dataset as JSON");
}

namespace detail {
/// Refuses options that would be ignored.
/// \param known  used options, besides the detector's
inline void require_known_options(const CLI::App& app, std::vector<std::string> known, ProblemList& list) {
  known.insert(known.end(), {"--quiet", "--verbose"});
  DetectorSettings detector;
  visit_settings(detector, [&](const std::string& name, const auto&...) {
    if (name != "class") known.push_back("--" + name);
  });
  for (const auto* option : app.get_options())
    list.require(option->count() == 0 || !option->get_configurable() ||  // --help, --version, --config
                     std::ranges::find(known, option->get_name()) != known.end(),
                 option->get_name() + " has no part in --dataset");
}

inline void require_dataset_options(const CLI::App& app, const DatasetSettings& s, ProblemList& list) {
  require_known_options(app,
                        {"--dataset", "--images", "--dataset-names", "--classes", "--most-detections",
                         "--results", "--csv", "--json", "--threads"},
                        list);
  list.require(s.most_detections >= 1 && s.most_detections <= 10000, "--most-detections must be 1 to 10000");
  for (const auto& [name, path] : {std::pair("--results", s.results), {"--csv", s.csv}, {"--json", s.json}})
    list.require_kept(name, path, {s.dataset, s.class_names});
}

inline evaluate::Dataset read_labels(const LabelSettings& s, std::size_t class_count) {
  const auto refuse = [&](const std::string& option, const std::string& value) {
    if (!value.empty()) throw Error(ErrorKind::usage, option + " has no part in the data set " + s.dataset);
  };
  if (!is_there(s.dataset, ErrorKind::malformed))
    throw malformed_file({s.dataset, "", "no such file or folder"});
  const bool is_folder_of_labels = is_folder(s.dataset, ErrorKind::malformed);
  const bool is_voc = is_folder_of_labels && evaluate::is_voc_folder(s.dataset);
  const bool is_coco = !is_folder_of_labels && s.dataset.ends_with(".json");
  if (!is_folder_of_labels && !is_coco && !s.dataset.ends_with(".txt"))
    throw Error(ErrorKind::usage, "--dataset " + s.dataset + ": expected a .json, a .txt or a folder");
  if (is_voc || is_coco)
    refuse("--dataset-names", s.class_names);
  else
    refuse("--images", s.images);
  if (is_voc) return evaluate::read_voc(s.dataset, s.images);
  if (is_coco)
    return evaluate::read_coco(s.dataset,
                               s.images.empty() ? io::path_of(s.dataset).parent_path().string() : s.images);
  return is_folder_of_labels ? evaluate::read_yolo_folder(s.dataset, class_count)
                             : evaluate::read_darknet_list(s.dataset, class_count);
}

/// Gives classes the names that --classes states, and takes off those that it leaves out, with their objects.
/// \param needs_all  whether the detector must have all of them
inline void rename_classes(const std::vector<std::string>& pairs, evaluate::Dataset& dataset,
                           bool needs_all = true) {
  auto& names = dataset.class_names;
  const auto own = names;
  for (const auto& pair : pairs) {
    const std::size_t cut = pair.rfind('=');
    if (cut == std::string::npos || cut == 0)
      throw Error(ErrorKind::usage, "--classes " + pair + ": expected a pair, such as vehicle=car");
    const auto found = std::ranges::find(own, pair.substr(0, cut));
    if (found == own.end() && !needs_all) continue;
    if (found == own.end())
      throw Error(ErrorKind::usage,
                  "--classes " + pair + ": the data set has no such class; expected one of " + listed(own));
    names[static_cast<std::size_t>(found - own.begin())] = pair.substr(cut + 1);
  }
  evaluate::Dataset kept;
  std::vector<std::optional<std::size_t>> place(names.size());  // of equal names the first
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k].empty()) continue;
    const auto same = std::ranges::find(kept.class_names, names[k]);
    place[k] = static_cast<std::size_t>(same - kept.class_names.begin());
    if (same != kept.class_names.end()) continue;
    kept.class_names.push_back(names[k]);
    kept.class_ids.push_back(dataset.class_ids[k]);
  }
  for (auto& picture : dataset.pictures) {
    std::erase_if(picture.objects, [&](const auto& object) { return !place[object.class_index]; });
    for (auto& object : picture.objects) object.class_index = *place[object.class_index];
  }
  names = std::move(kept.class_names);
  dataset.class_ids = std::move(kept.class_ids);
}

/// \param class_count  of labels that number their classes, where no names are given
inline evaluate::Dataset read_dataset(const LabelSettings& s, std::size_t class_count) {
  std::vector<std::string> names;
  if (!s.class_names.empty()) names = io::read_class_names(s.class_names);
  evaluate::Dataset dataset = read_labels(s, names.empty() ? class_count : names.size());
  for (std::size_t k = 0; k < names.size(); ++k) dataset.class_ids.push_back(k);
  if (!names.empty()) dataset.class_names = std::move(names);
  if (!s.classes.empty()) rename_classes(s.classes, dataset);
  return dataset;
}

struct DatasetFindings {
  std::vector<evaluate::TruthBox> truths{};
  std::vector<evaluate::ScoredBox> detections{};
  std::vector<std::string> warnings{};  ///< about the pictures
};

/// Objects of a picture and its detections, most confident first, cut to the picture.
inline DatasetFindings findings_in(const evaluate::LabelledPicture& labelled, std::size_t index,
                                   std::size_t most, const DetectorSettings& settings,
                                   const detect::Detector<float>& detector, const ClassMatching& matching,
                                   detect::PassPool<float>& passes) {
  DatasetFindings findings;
  const auto picture = io::read_image(labelled.path, &findings.warnings);
  for (const auto& object : evaluate::objects_in_pixels(labelled, picture.shape(0), picture.shape(1)))
    if (const auto k = matching.of_dataset[object.class_index])
      findings.truths.push_back({index, *k, object.box, object.area, object.is_crowd, object.is_difficult});
  const auto frame = detect::box_from_corners(0, 0, static_cast<double>(picture.shape(1)),
                                              static_cast<double>(picture.shape(0)));
  for (const auto& found : detections_in(labelled.path, picture, settings, detector, *passes.take())) {
    const auto k = matching.of_detector[found.class_index];
    if (!k) continue;
    if (findings.detections.size() == most) break;
    findings.detections.push_back({index, *k, detect::clipped(found.box, frame), found.confidence});
  }
  return findings;
}

/// findings_in() of all pictures, in their order.
/// \param each  called on this thread after each picture
template <class Each>
DatasetFindings all_findings(const evaluate::Dataset& dataset, std::size_t most,
                             const DetectorSettings& settings, const detect::Detector<float>& detector,
                             const ClassMatching& matching, Each each) {
  DatasetFindings findings;
  detect::PassPool<float> passes;
  const auto find = [&](std::size_t i) {
    return findings_in(dataset.pictures[i], i, most, settings, detector, matching, passes);
  };
  for_each_in_order(dataset.pictures.size(), find, [&](std::size_t, const DatasetFindings& found) {
    findings.truths.insert(findings.truths.end(), found.truths.begin(), found.truths.end());
    findings.detections.insert(findings.detections.end(), found.detections.begin(), found.detections.end());
    each(found);
  });
  return findings;
}

/// Detections in COCO's format of results, with the pictures' names beside their ids.
inline std::string results_text(const evaluate::Dataset& dataset, const ClassMatching& matching,
                                const std::vector<evaluate::ScoredBox>& detections) {
  std::string text = "[";
  for (const auto& found : detections) {
    const auto& picture = dataset.pictures[found.picture];
    const Json json = {{"image_id", picture.id},
                       {"file_name", io::path_of(picture.path).filename().string()},
                       {"category_id", matching.ids[found.class_index]},
                       {"bbox", {found.box.left(), found.box.top(), found.box.w, found.box.h}},
                       {"score", found.confidence}};
    text += (text.size() > 1 ? ",\n" : "\n") + json.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return text + "\n]\n";
}
}  // namespace detail

/// Runs a detector on the pictures of a data set, prints its average precision and writes the requested
/// files.
/// \param app  has the options of the settings; all are checked except this measurement's
inline int evaluate_dataset(const CLI::App& app, const DatasetSettings& s, DetectorSettings settings) {
  ProblemList problems;
  detail::require_dataset_options(app, s, problems);
  require_sound(settings, problems);
  problems.throw_first();
  if (app.get_option("--confidence")->count() == 0) settings.confidence = dataset_confidence;
  fill_in_bundled(settings);
  std::vector<std::string> remarks;
  const auto detector = load_detector(settings, remarks);
  const evaluate::Dataset dataset = detail::read_dataset(s, detector.heads().front().classes);
  const ClassMatching matching = match_classes(s.dataset, dataset, detector);
  for (const auto* warnings : {&std::as_const(remarks), &dataset.warnings, &matching.warnings})
    print_warnings(*warnings);
  for (const auto& path : {s.results, s.csv, s.json})
    if (!path.empty()) require_writable_file(path);
  const auto claims = claimed_files({s.results, s.csv, s.json});
  MeasuringProgress progress(dataset.pictures.size());
  const auto findings = detail::all_findings(dataset, s.most_detections, settings, detector, matching,
                                             [&](const detail::DatasetFindings& found) {
                                               print_warnings(found.warnings);
                                               progress.count("data set");
                                             });
  const auto precision =
      evaluate::average_precision(findings.truths, findings.detections, matching.names.size());
  std::printf("pictures: %zu, fit %s, confidence above %g, suppression at IoU %g\n%s",
              dataset.pictures.size(), std::string(image::name_of(detector.fit().kind)).c_str(),
              settings.confidence, settings.nms, precision_text(precision, matching.names).c_str());
  if (!s.results.empty()) write_text(s.results, detail::results_text(dataset, matching, findings.detections));
  if (!s.csv.empty()) write_text(s.csv, precision_csv(precision, matching.names));
  if (!s.json.empty()) write_text(s.json, report_text(precision_json(precision, matching.names)));
  return 0;
}
}  // namespace tapestry::shell
