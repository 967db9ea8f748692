#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/image_file.hpp>
#include <utility>
#include <vector>

#include "formatted.hpp"
#include "run_folder.hpp"
#include "run_manifest.hpp"
#include "view_list.hpp"

namespace tapestry::shell {

// Pictures of a survey for detectors of other programs: PNG files and COCO's instances.json, in which each
// picture also names its texture and view.

inline constexpr const char* pictures_format = "tapestry pictures 1";

inline std::string instances_path(const std::string& folder) { return folder + "/instances.json"; }

/// Writes the pictures of a survey.
class PictureExport {
 public:
  /// \param folder  that is there and holds no pictures; empty: nothing is written
  /// \throws Error (in_use) if it holds an instances.json
  explicit PictureExport(std::string folder) : folder_(std::move(folder)) {
    if (!folder_.empty() && is_there(instances_path(folder_), ErrorKind::write))
      throw Error(ErrorKind::in_use, folder_ + " holds pictures; give another --pictures");
  }

  void add(const evaluate::MeasuredPicture& measured) {
    if (folder_.empty()) return;
    const std::size_t id = images_.size() + 1;
    const auto& [texture, picture, view, box, result] = measured;
    const std::string name = formatted("%06zu.png", id), path = folder_ + "/" + name;
    const std::string file = io::png_file(path, image::to_bytes(picture));
    write_text(path, file);
    images_.push_back({{"id", id},
                       {"file_name", name},
                       {"height", picture.shape(0)},
                       {"width", picture.shape(1)},
                       {"texture", texture},
                       {"view", json_of(facts_of(view))},
                       {"sha256", io::sha256(file)}});
    annotations_.push_back({{"id", id},
                            {"image_id", id},
                            {"category_id", 0},
                            {"bbox", {box.left(), box.top(), box.w, box.h}},
                            {"area", box.w * box.h},
                            {"iscrowd", 0}});
  }

  /// Writes the labels. Until then the folder holds no set of pictures.
  /// \param class_index  of the car
  /// \param about        what the pictures are of
  void finish(const std::vector<std::string>& class_names, std::size_t class_index, std::size_t draws,
              Json about) {
    if (folder_.empty()) return;
    Json categories = Json::array();
    for (std::size_t k = 0; k < class_names.size(); ++k)
      categories.push_back({{"id", k + 1}, {"name", class_names[k]}});
    for (Json& annotation : annotations_) annotation["category_id"] = class_index + 1;
    about["format"] = pictures_format;
    about["draws"] = draws;
    write_text(instances_path(folder_), exact_text({{"info", std::move(about)},
                                                    {"images", std::move(images_)},
                                                    {"annotations", std::move(annotations_)},
                                                    {"categories", std::move(categories)}}) +
                                            "\n");
  }

 private:
  static Json json_of(const ViewFacts& facts) {
    return {{"name", facts.name},
            {"azimuth_deg", facts.azimuth_deg},
            {"elevation_deg", facts.elevation_deg},
            {"distance", facts.distance},
            {"hidden_share", facts.hidden_share},
            {"car_share", facts.car_share},
            {"registration", facts.registration ? Json(*facts.registration) : Json()},
            {"keeps_photograph", facts.keeps_photograph}};
  }

  std::string folder_;
  Json images_ = Json::array(), annotations_ = Json::array();
};

}  // namespace tapestry::shell
