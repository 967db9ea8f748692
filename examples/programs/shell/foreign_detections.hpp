#pragma once
#include "exported_pictures.hpp"
#include "picture_sheet.hpp"
#include "survey_watch.hpp"

namespace tapestry::shell {
/// A picture that PictureExport has written.
struct ExportedPicture {
  std::string file;
  Json facts;  ///< its texture, frame and column
  detect::Box target;
  std::vector<detect::Detection> detections{};  ///< of another program, most confident first
  double best_confidence = 0;                   ///< of them in the car, before they are suppressed here
};

struct ExportedPictures {
  Json about;  ///< the measurement, see facts_for_labels()
  std::vector<std::string> class_names{};
  std::size_t class_index = 0;  ///< of the car
  std::vector<ExportedPicture> pictures{};
  double least_score = 1;  ///< of another program's detections
};

namespace detail {
inline detect::Box box_of(const Json& bbox) {
  const auto [left, top, width, height] = bbox.get<std::array<double, 4>>();
  return detect::box_from_corners(left, top, left + width, top + height);
}

/// \throws Json::exception for members that are missing or of another type
inline ExportedPictures exported_pictures(const Json& json) {
  ExportedPictures all{json.at("info")};
  if (all.about.at("format") != pictures_format) throw DomainError("not " + std::string(pictures_format));
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
}  // namespace detail

/// Compares labels and pictures of a folder with the hashes in its labels.
/// \throws FileError: mismatch for the first one that has changed, unreadable for a picture that is gone
inline void require_as_exported(const std::string& folder, const Json& labels) {
  const auto require = [](const std::string& path, const std::string& sha256, const std::string& found) {
    if (sha256 != found)
      throw file_mismatch(
          {path, "", "not as evaluate --pictures wrote it", "SHA-256 " + sha256, "SHA-256 " + found});
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
    throw file_mismatch({paint, "", "not as the run wrote it",
                         "SHA-256 " + outputs["texture.npz"].get<std::string>(), "SHA-256 " + found});
  for (const Json& input : about.value("inputs", Json::array()))
    if (input.value("sha256", std::string()) == found) return;
  throw file_mismatch({instances_path(pictures), "", "pictures of another paint than " + paint});
}

/// Reads the files that PictureExport wrote to a folder, and compares them with their hashes.
/// \throws FileError: unreadable, malformed, or mismatch
inline ExportedPictures read_exported_pictures(const std::string& folder) {
  require_file_of(folder, "instances.json", "evaluate --pictures");
  const std::string path = instances_path(folder);
  const auto refuse = [&](const std::string& what) -> FileError {
    return malformed_file({path, "", "not the pictures of evaluate --pictures: " + what});
  };
  try {
    const Json labels = io::read_json(io::read_text_file(path), path).value;
    auto pictures = detail::exported_pictures(labels);
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
    throw file_mismatch({path, "",
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
  if (!results.is_array()) throw malformed_file({path, "", "not COCO's results", "a list of detections", ""});
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

/// Some pictures of each of these columns, side by side, with the detections above a confidence.
/// \throws FileError for a picture that is no longer readable
inline Bitmap sheet_of(const ExportedPictures& all, const std::string& folder, double confidence,
                       const std::vector<std::size_t>& columns) {
  constexpr std::size_t most = 4, side = 240;
  std::vector<MarkedPicture> shown;
  for (const std::size_t column : columns) {
    std::vector<const ExportedPicture*> pictures;
    for (const auto& picture : all.pictures)
      if (picture.facts.at("column") == column) pictures.push_back(&picture);
    for (const std::size_t place : shown_places(most, pictures.size())) {
      const auto& [file, facts, target, detections, best] = *pictures[place];
      MarkedPicture marked{io::read_image(folder + "/" + file)};
      for (const auto& one : detections)
        if (one.confidence > confidence)
          marked.boxes.push_back(
              labelled_box(one, all.class_names, evaluate::is_found({one}, {all.class_index, target})));
      shown.push_back(fitted_within(std::move(marked), side));
    }
  }
  return contact_sheet(shown, most);
}
}  // namespace tapestry::shell
