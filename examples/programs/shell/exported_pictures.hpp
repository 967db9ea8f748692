#pragma once
#include <tapestry/io/image_file.hpp>
#include "formatted.hpp"
#include "run_manifest.hpp"
#include "view_list.hpp"

namespace tapestry::shell {
// Pictures of a protocol for detectors of other programs: PNG files and COCO's instances.json, in which each
// picture also names its texture and frame.

inline constexpr const char* pictures_format = "tapestry pictures 2";

inline std::string instances_path(const std::string& folder) { return folder + "/instances.json"; }

/// SHA-256 of the labels without this hash itself, for any order and layout in the file.
inline std::string labels_sha256(nlohmann::json labels) {
  labels["info"].erase("sha256");
  return io::sha256(labels.dump());
}

/// Writes measured pictures.
class PictureExport {
 public:
  /// \param folder       empty: nothing is written
  /// \param class_names  of the detector
  /// \param class_index  of the car
  /// \throws Error: in_use if the folder holds an instances.json, usage without names
  PictureExport(std::string folder, std::vector<std::string> class_names, std::size_t class_index)
      : folder_(std::move(folder)), class_names_(std::move(class_names)), class_index_(class_index) {
    if (folder_.empty()) return;
    if (class_names_.empty())
      throw Error(ErrorKind::usage, "--pictures needs the names of the detector's classes, see --names");
    claim_.emplace(folder_, !is_there(folder_, ErrorKind::write));
    if (is_there(instances_path(folder_), ErrorKind::write))
      throw Error(ErrorKind::in_use, folder_ + " holds pictures; give another --pictures");
  }

  [[nodiscard]] bool is_on() const { return !folder_.empty(); }
  [[nodiscard]] std::size_t count() const { return images_.size(); }

  /// Writes a picture and returns its labels. Several threads may do so at once.
  /// \param facts  about the picture, for its labels
  [[nodiscard]] std::pair<Json, Json> written(std::size_t id, const Array<float, 3>& picture,
                                              const detect::Box& box, const Json& facts) const {
    const std::string path = path_of(id), file = io::png_file(path, image::to_bytes(picture));
    write_text(path, file);
    Json image{{"id", id},
               {"file_name", path.substr(folder_.size() + 1)},
               {"height", picture.shape(0)},
               {"width", picture.shape(1)}};
    image.update(facts);
    image["sha256"] = io::sha256(file);
    return {std::move(image),
            {{"id", id},
             {"image_id", id},
             {"category_id", class_index_ + 1},
             {"bbox", {box.left(), box.top(), box.w, box.h}},
             {"area", box.w * box.h},
             {"iscrowd", 0}}};
  }

  /// Keeps the labels of the next picture.
  void keep(std::pair<Json, Json> labels) {
    images_.push_back(std::move(labels.first));
    annotations_.push_back(std::move(labels.second));
  }

  /// Writes the labels. Until then the folder holds no set of pictures.
  /// \param about  facts about the pictures
  void finish(Json about) {
    for (std::size_t id = images_.size() + 1; std::filesystem::remove(io::path_of(path_of(id))); ++id) {
    }  // removes files of a longer, interrupted export
    Json categories = Json::array();
    for (std::size_t k = 0; k < class_names_.size(); ++k)
      categories.push_back({{"id", k + 1}, {"name", class_names_[k]}});
    about["format"] = pictures_format;
    Json labels{{"info", std::move(about)},
                {"images", std::move(images_)},
                {"annotations", std::move(annotations_)},
                {"categories", std::move(categories)}};
    labels["info"]["sha256"] = labels_sha256(nlohmann::json::parse(exact_text(labels)));
    write_text(instances_path(folder_), exact_text(labels) + "\n");
  }

 private:
  [[nodiscard]] std::string path_of(std::size_t id) const { return folder_ + formatted("/%06zu.png", id); }

  std::string folder_;
  std::vector<std::string> class_names_;
  std::size_t class_index_;
  std::optional<RunFolder> claim_;
  Json images_ = Json::array(), annotations_ = Json::array();
};
}  // namespace tapestry::shell
