#pragma once

#include "exported_pictures.hpp"
#include "run_page.hpp"
#include "side_by_side.hpp"

namespace tapestry::shell {

/// A picture that PictureExport has written.
struct ExportedPicture {
  std::string file;
  Json facts;  ///< its texture, and its view or its frame and column
  detect::Box target;
  std::vector<detect::Detection> detections{};  ///< of another program, most confident first
  double best_confidence = 0;                   ///< of them in the car, before they are suppressed here
};

/// The pictures of a folder.
struct ExportedPictures {
  Json about;  ///< with the settings of the measurement for pictures of a protocol
  std::vector<std::string> class_names{};
  std::size_t class_index = 0;              ///< of the car
  std::size_t draws = 1;                    ///< pictures of a view
  std::vector<std::string> textures{};      ///< of a survey, in its order
  std::vector<ExportedPicture> pictures{};  ///< of a survey texture by texture, all of the same views
  double least_score = 1;                   ///< of another program's detections

  [[nodiscard]] bool are_of_protocol() const { return about.contains("settings"); }
};

namespace detail {
inline ViewFacts view_facts(const Json& json) {
  ViewFacts facts{json.at("name"),     json.at("azimuth_deg"),  json.at("elevation_deg"),
                  json.at("distance"), json.at("hidden_share"), json.at("car_share")};
  if (!json.at("registration").is_null()) facts.registration = json.at("registration").get<double>();
  facts.keeps_photograph = json.at("keeps_photograph");
  return facts;
}

inline detect::Box box_of(const Json& bbox) {
  const auto [left, top, width, height] = bbox.get<std::array<double, 4>>();
  return detect::box_from_corners(left, top, left + width, top + height);
}

/// \throws Json::exception for members that are missing or of another type
inline ExportedPictures exported_pictures(const Json& json) {
  ExportedPictures all{json.at("info")};
  if (all.about.at("format") != pictures_format) throw DomainError("not " + std::string(pictures_format));
  all.draws = all.about.at("draws");
  for (const Json& category : json.at("categories")) all.class_names.push_back(category.at("name"));
  const Json& annotations = json.at("annotations");
  all.class_index = annotations.at(0).at("category_id").get<std::size_t>() - 1;
  for (std::size_t i = 0; i < json.at("images").size(); ++i) {
    const Json& image = json["images"][i];
    if (image.at("id") != i + 1 || annotations.at(i).at("image_id") != i + 1)
      throw DomainError("image " + std::to_string(i + 1) + " in another place");
    all.pictures.push_back({image.at("file_name"), image, box_of(annotations.at(i).at("bbox"))});
  }
  if (all.class_index >= all.class_names.size()) throw DomainError("a class without a name");
  return all;
}

/// \throws Json::exception, DomainError unless all textures have pictures of the same views
inline void find_textures_of_survey(ExportedPictures& all) {
  const auto texture_of = [&](std::size_t i) { return all.pictures[i].facts.at("texture"); };
  for (std::size_t i = 0; i < all.pictures.size(); ++i)
    if (all.textures.empty() || texture_of(i) != all.textures.back()) all.textures.push_back(texture_of(i));
  const std::size_t views = all.pictures.size() / std::max<std::size_t>(1, all.textures.size());
  for (std::size_t i = 0; i < all.pictures.size(); ++i)
    if (views * all.textures.size() != all.pictures.size() || texture_of(i) != all.textures[i / views])
      throw DomainError("textures of other views");
  if (all.textures.size() < 2 || all.textures[0] != "photo" || all.textures[1] != "clean" || all.draws == 0 ||
      views % all.draws != 0)
    throw DomainError("not the pictures of a survey");
}
}  // namespace detail

/// Compares labels and pictures of a folder with the hashes in its labels.
/// \throws FileError: mismatch for the first one that has changed, unreadable for a picture that is gone
inline void require_as_exported(const std::string& folder, const Json& labels) {
  const auto require = [](const std::string& path, const std::string& sha256, const std::string& found) {
    if (sha256 != found)
      throw FileError(ErrorKind::mismatch, {path, "", "not as evaluate --pictures wrote it",
                                            "SHA-256 " + sha256, "SHA-256 " + found});
  };
  const std::string path = instances_path(folder);
  if (labels["info"].contains("sha256"))
    require(path, labels["info"]["sha256"], labels_sha256(labels));
  else
    remark(path + " states no hash of itself, so only its pictures are compared");
  for (const Json& image : labels["images"]) {
    const std::string picture = folder + "/" + image.at("file_name").get<std::string>();
    require(picture, image.at("sha256"), io::RegularFile(picture).sha256());
  }
}

/// \throws FileError (mismatch) unless the pictures show the paint that a run has written
inline void require_pictures_of(const std::string& run, const Json& about, const std::string& pictures) {
  Json outputs = read_manifest(run).value("outputs", Json::object());
  if (!outputs.is_object()) outputs = Json::object();
  const std::string paint = run + "/texture.npz", found = io::RegularFile(paint).sha256();
  if (outputs.value("texture.npz", found) != found)
    throw FileError(ErrorKind::mismatch,
                    {paint, "", "not as the run wrote it",
                     "SHA-256 " + outputs["texture.npz"].get<std::string>(), "SHA-256 " + found});
  for (const Json& input : about.value("inputs", Json::array()))
    if (input.value("sha256", std::string()) == found) return;
  throw FileError(ErrorKind::mismatch,
                  {instances_path(pictures), "", "pictures of another paint than " + paint});
}

/// Reads the files that PictureExport wrote to a folder, and compares them with their hashes.
/// \throws FileError: unreadable, malformed, or mismatch
inline ExportedPictures read_exported_pictures(const std::string& folder) {
  require_file_of(folder, "instances.json", "evaluate --pictures");
  const std::string path = instances_path(folder);
  const auto refuse = [&](const std::string& what) -> FileError {
    return FileError(ErrorKind::malformed, {path, "", "not the pictures of evaluate --pictures: " + what});
  };
  try {
    const Json labels = io::read_json(io::read_text_file(path), path).value;
    auto pictures = detail::exported_pictures(labels);
    if (!pictures.are_of_protocol()) detail::find_textures_of_survey(pictures);
    require_as_exported(folder, labels);
    return pictures;
  } catch (const Json::exception& error) {
    throw refuse(json_fault(error.what()));
  } catch (const DomainError& error) {
    throw refuse(error.what());
  }
}

/// Refuses boxes that are corners (left, top, right, bottom): all could be corners, and as corners more of
/// them lie over their picture's car.
/// \throws FileError (mismatch)
inline void require_no_corners(const std::string& path, const ExportedPictures& all) {
  std::size_t as_sides = 0, as_corners = 0;
  for (const auto& picture : all.pictures)
    for (const auto& detection : picture.detections) {
      const auto& box = detection.box;
      if (box.w < box.left() || box.h < box.top()) return;
      const auto other = detect::box_from_corners(box.left(), box.top(), box.w, box.h);
      as_sides += detect::iou(box, picture.target) >= 0.5 ? 1U : 0U;
      as_corners += detect::iou(other, picture.target) >= 0.5 ? 1U : 0U;
    }
  if (as_corners > as_sides)
    throw FileError(ErrorKind::mismatch,
                    {path, "",
                     "bbox looks like left, top, right, bottom: read so, " + std::to_string(as_corners) +
                         " boxes lie over their car, else " + std::to_string(as_sides),
                     "left, top, width, height"});
}

/// Reads COCO's results of any program: a list of image_id, category_id, bbox (left, top, width, height in
/// pixels) and score. Pictures without an entry have no detections.
/// \param nms  IoU above which a weaker detection is suppressed; none: the program has done so
/// \throws FileError naming the first entry that is malformed or has an unknown picture or category; mismatch
///         for corners in place of sides
inline void read_detections(const std::string& path, ExportedPictures& all,
                            const std::optional<double>& nms) {
  const Json results = io::read_json(io::read_text_file(path), path).value;
  const auto refuse = [&](std::size_t entry, ErrorKind kind, const std::string& what,
                          const std::string& expected = {}) {
    throw FileError(kind, {path, "entry " + std::to_string(entry + 1), what, expected, ""});
  };
  if (!results.is_array())
    throw FileError(ErrorKind::malformed, {path, "", "not COCO's results", "a list of detections", ""});
  for (std::size_t i = 0; i < results.size(); ++i) {
    try {
      const auto image = results[i].at("image_id").get<std::size_t>();
      const auto category = results[i].at("category_id").get<std::size_t>();
      const auto score = results[i].at("score").get<double>();
      const auto box = detail::box_of(results[i].at("bbox"));
      if (image == 0 || image > all.pictures.size())
        refuse(i, ErrorKind::mismatch, "there is no picture " + std::to_string(image),
               "image_id 1 to " + std::to_string(all.pictures.size()));
      if (category == 0 || category > all.class_names.size())
        refuse(i, ErrorKind::mismatch, "there is no category " + std::to_string(category),
               "category_id 1 to " + std::to_string(all.class_names.size()) + ", as in instances.json");
      if (!(score >= 0 && score <= 1) || !(box.w >= 0) || !(box.h >= 0))
        refuse(i, ErrorKind::malformed, "score or bbox out of range", "score in 0 to 1, sides not below 0");
      all.pictures[image - 1].detections.push_back({category - 1, score, score, box});
      all.least_score = std::min(all.least_score, score);
    } catch (const Json::exception& error) {
      refuse(i, ErrorKind::malformed, json_fault(error.what()));
    }
  }
  require_no_corners(path, all);
  for (auto& [file, facts, target, detections, best] : all.pictures) {
    std::ranges::stable_sort(detections, std::greater{}, &detect::Detection::confidence);
    for (auto one = detections.rbegin(); one != detections.rend(); ++one)
      if (evaluate::is_found({*one}, {all.class_index, target})) best = one->confidence;
    if (nms) detections = detect::suppress(std::move(detections), *nms);
  }
}

/// States what is unknown of confidences where a program states no weak ones.
/// \param noise, paint  best confidences in pictures with matched noise and with the camouflage
inline std::string words_on_floor(double least_score, const std::vector<double>& noise,
                                  const std::vector<double>& paint) {
  std::string words = "The detections have no confidence below " + formatted("%.2g", least_score) +
                      "; where no box overlaps the car it counts as 0";
  const auto unknown = [](const std::vector<double>& best) { return std::ranges::count(best, 0.0); };
  const auto share = [&](const std::vector<double>& best) {
    return least_score * static_cast<double>(unknown(best)) / static_cast<double>(best.size());
  };
  if (!noise.empty() && !paint.empty())
    words += formatted(
        ", in %zu of %zu pictures with matched noise and %zu of %zu with the camouflage: the effect on best "
        "confidence may be up to %.3f more or %.3f less",
        static_cast<std::size_t>(unknown(noise)), noise.size(), static_cast<std::size_t>(unknown(paint)),
        paint.size(), share(noise), share(paint));
  return words + ".";
}

/// The survey of exported pictures by the detections in them.
inline evaluate::Survey survey_of(const ExportedPictures& all, const evaluate::MeterSettings& settings) {
  const auto related = evaluate::related_classes(all.class_names, all.class_index);
  const std::size_t views = all.pictures.size() / all.textures.size();
  const auto measured = [&](const std::string& name, const auto&) {
    const auto place = static_cast<std::size_t>(std::ranges::find(all.textures, name) - all.textures.begin());
    evaluate::Measurement measurement{name, all.draws};
    measurement.class_names = all.class_names;
    std::vector<std::vector<bool>> found_in_sweep(settings.sweep.size());
    for (std::size_t i = place * views; i < (place + 1) * views; ++i) {
      const auto& [file, facts, target, detections, best] = all.pictures[i];
      evaluate::detail::add_result(
          evaluate::view_result(detections, best, {all.class_index, target}, related, settings), measurement,
          found_in_sweep);
    }
    evaluate::detail::summarise(measurement, found_in_sweep, all.draws);
    return measurement;
  };
  const bool has_adversarial = all.textures.size() > 2 && all.textures[2] == "adversarial";
  return evaluate::survey_of(
      has_adversarial, {all.textures.begin() + (has_adversarial ? 3 : 2), all.textures.end()}, measured);
}

inline std::string words_on_floor(const ExportedPictures& all, const evaluate::Survey& survey) {
  const auto noise = std::ranges::find(survey.controls, std::string(evaluate::matched_noise_name),
                                       &evaluate::Measurement::name);
  return words_on_floor(all.least_score,
                        noise == survey.controls.end() ? std::vector<double>{} : noise->best_confidence,
                        survey.adversarial ? survey.adversarial->best_confidence : std::vector<double>{});
}

inline RunReport report_of(const ExportedPictures& all, const evaluate::MeterSettings& settings) {
  RunReport report;
  report.survey = survey_of(all, settings);
  report.held_out = all.about.value("held_out", false);
  if (const Json share = all.about.value("noise_in_place", Json()); share.is_number())
    report.noise_in_place = share.get<double>();
  report.options = all.about.value("options", Json::object());
  return report;
}

/// Some views as SideBySide shows them, with the detections of another program above a confidence.
/// \throws FileError for a picture that is no longer readable
inline ViewPictures pictures_of(const ExportedPictures& all, const std::string& folder, double confidence) {
  const std::size_t views = all.pictures.size() / all.textures.size();
  ViewPictures shown{shown_places(most_large_views, views)};
  for (const auto& [texture, words] : shown_textures()) {
    const auto found = std::ranges::find(all.textures, texture);
    if (found == all.textures.end()) continue;
    auto& pictures = shown.ways.emplace_back(words, std::vector<MarkedPicture>()).second;
    for (const std::size_t place : shown.places) {
      const auto& picture =
          all.pictures[static_cast<std::size_t>(found - all.textures.begin()) * views + place];
      auto& marked = pictures.emplace_back(MarkedPicture{io::read_image(folder + "/" + picture.file)});
      for (const auto& one : picture.detections)
        if (one.confidence >= confidence)
          marked.boxes.push_back(labelled_box(one, all.class_names,
                                              evaluate::is_found({one}, {all.class_index, picture.target})));
    }
  }
  return shown;
}

/// The views of exported pictures with their measurements, for views.csv and the page.
inline ViewList list_of(const ExportedPictures& all, const RunReport& report) {
  std::vector<ViewFacts> views;
  for (std::size_t i = 0; i < all.pictures.size() / all.textures.size(); ++i)
    views.push_back(detail::view_facts(all.pictures[i].facts.at("view")));
  return list_of(report, std::move(views));
}

}  // namespace tapestry::shell
