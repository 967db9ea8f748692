#pragma once
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::evaluate {
/// A labelled object in a picture.
struct LabelledObject {
  std::size_t class_index = 0;
  detect::Box box{};
  double area = 0;            ///< in the square of the box's unit: the area of its outline where it is known
  bool is_crowd = false;      ///< stands for many objects
  bool is_difficult = false;  ///< need not be found
};

/// A picture of a data set and its objects.
struct LabelledPicture {
  std::string path;
  std::uint64_t id = 0;    ///< as in the data set, or numbered from 1 on
  std::size_t height = 0;  ///< pixels, from the data set; 0 where it does not state them
  std::size_t width = 0;
  bool in_shares = false;  ///< boxes are in shares of the picture's extents, else in pixels
  std::vector<LabelledObject> objects{};
};

/// Pictures with labelled objects.
struct Dataset {
  std::vector<std::string> class_names{};  ///< empty where classes are known by number only
  std::vector<std::uint64_t> class_ids{};  ///< the data set's own numbers, one for each of class_names
  std::vector<LabelledPicture> pictures{};
  std::vector<std::string> warnings{};
};

/// The objects of a picture in its pixels, once its extents are known.
/// \throws FileError (mismatch) if the data set states other extents
[[nodiscard]] inline std::vector<LabelledObject> objects_in_pixels(const LabelledPicture& picture,
                                                                   std::size_t height, std::size_t width) {
  const auto text = [](std::size_t w, std::size_t h) { return std::to_string(w) + "x" + std::to_string(h); };
  if (picture.width != 0 && (picture.height != height || picture.width != width))
    throw file_mismatch({picture.path, "", "the picture has another size than its labels state",
                         text(picture.width, picture.height), text(width, height)});
  auto objects = picture.objects;
  if (!picture.in_shares) return objects;
  const auto w = static_cast<double>(width), h = static_cast<double>(height);
  for (auto& object : objects) {
    object.box = {object.box.cx * w, object.box.cy * h, object.box.w * w, object.box.h * h};
    object.area *= w * h;
  }
  return objects;
}

namespace detail {
/// \param labels    file that lists the picture, for the message
/// \param position  line or byte in that file
/// \throws FileError (mismatch) if the picture is missing; as status_of() where that cannot be found out
inline void require_picture(const std::string& picture, const std::string& labels,
                            const std::string& position) {
  if (io::is_regular_file(picture)) return;
  throw file_mismatch({labels, position, "a picture is missing", printable(picture), "no such file"});
}
}  // namespace detail
}  // namespace tapestry::evaluate
