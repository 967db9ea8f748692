#pragma once
#include <tapestry/evaluate/dataset/dataset.hpp>

namespace tapestry::evaluate {
/// Reads COCO's instances. Of the JSON's outermost object it reads the lists
///
///   images       {"id", "file_name", "width", "height"}
///   annotations  {"id", "image_id", "category_id", "bbox": [x, y, w, h], "area", "iscrowd"}
///   categories   {"id", "name"}
///
/// Ids are whole numbers, unique within a list. Boxes are in pixels from the picture's top left corner. A
/// missing "area" is the box's area, a missing "iscrowd" 0. Classes and pictures are sorted by their ids.
/// Other members are ignored. Compiled in tapestry/implementation.hpp.
///
/// \param text    the whole text
/// \param path    the file's name, for messages
/// \param images  folder of the pictures
/// \throws FileError  malformed, with the list, the entry and the byte where the list begins, for members
///                  that are missing, of another type or out of range, for an id used twice, and for a
///                  file_name outside `images`; mismatch for an annotation of an unknown picture or category,
///                  and for a missing picture; further as read_json()
[[nodiscard]] Dataset parse_coco(std::string_view text, const std::string& path, const std::string& images);

/// Reads a file of COCO instances of at most 512 MiB; errors as parse_coco() and io::read_text_file().
/// Takes memory of at most 48 times the file and 1 MiB.
[[nodiscard]] inline Dataset read_coco(const std::string& path, const std::string& images) {
  return parse_coco(io::read_text_file(path, std::uint64_t(512) << 20U), path, images);
}

/// Parses the labels of one picture in the text form of Darknet and YOLO. Each line is an object, `class cx
/// cy w h`: the class is a number from 0 on, the box is in shares of the picture's extents. Empty lines are
/// skipped. Takes memory of at most 16 times the file and 1 MiB.
///
/// \param class_count number of classes
/// \throws FileError  malformed, with the line, for another number of words, for words that are no numbers,
///                    centres outside 0 to 1 and extents that are not above 0 and at most 1; mismatch for a
///                    class that is not below class_count
[[nodiscard]] std::vector<LabelledObject> parse_yolo_labels(std::string_view text, const std::string& path,
                                                            std::size_t class_count);

/// Reads the pictures of a folder, or of its subfolder `images`, in order of their names. Labels, in the form
/// of parse_yolo_labels(), are in a .txt beside the picture or, for .../images/a.png, in .../labels/a.txt. A
/// picture without labels has no objects; a warning states their number.
///
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no pictures, none with labels,
///                  or two of one name); further as parse_yolo_labels() and io::read_text_file()
[[nodiscard]] Dataset read_yolo_folder(const std::string& folder, std::size_t class_count);

/// Reads a list of pictures, one path a line, such as Darknet's train.txt. Labels are found as in
/// read_yolo_folder(). Relative paths begin at the list's folder; empty lines are skipped.
///
/// \throws FileError  mismatch, with the line, for a picture that is missing or listed twice; mismatch for no
///                  pictures, or none with labels; further as parse_yolo_labels() and io::read_text_file()
[[nodiscard]] Dataset read_darknet_list(const std::string& path, std::size_t class_count);

/// The labels of one picture, with the class name of each object.
struct VocAnnotation {
  std::string filename{};
  LabelledPicture picture{};               ///< without path and id; all classes have number 0
  std::vector<std::string> class_names{};  ///< one an object
};

/// Reads the labels of one picture in Pascal VOC's form. Of `annotation` it reads `filename`, `size` with
/// `width` and `height`, and each `object` with `name`, `bndbox` of `xmin`, `ymin`, `xmax`, `ymax`, and, if
/// present, `difficult`, 0 or 1. Other elements are ignored.
///
/// Columns and rows count from 1, and the box includes its edge pixels, so it spans xmin − 1 to xmax. Source:
/// Everingham et al., the development kit of the Visual Object Classes challenge 2012.
/// Takes memory of at most 64 times the file and 1 MiB.
///
/// \param path  the file's name, for messages
/// \throws FileError  malformed, with the line, also for a picture outside its folder; see also parse_xml()
[[nodiscard]] VocAnnotation parse_voc(std::string_view text, const std::string& path);

namespace detail {
/// The .xml files of a folder, in order of their names.
[[nodiscard]] inline std::vector<std::string> xml_paths(const std::string& folder) {
  return io::listed_paths(folder,
                          [](const std::filesystem::path& path) { return path.extension() == ".xml"; });
}
}  // namespace detail

/// Whether a folder holds Pascal VOC labels: .xml files, or a subfolder Annotations.
[[nodiscard]] inline bool is_voc_folder(const std::string& folder) {
  return io::is_folder(folder + "/Annotations") || !detail::xml_paths(folder).empty();
}

/// Reads a folder of Pascal VOC labels, one .xml a picture, or its subfolder Annotations. Classes and
/// pictures are sorted by name.
///
/// \param images  folder of the pictures; if empty, JPEGImages beside Annotations, or the labels' folder
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no .xml, a picture that
///                    is missing or has two labels); further as parse_voc() and io::read_text_file()
[[nodiscard]] Dataset read_voc(const std::string& folder, const std::string& images = "");
}  // namespace tapestry::evaluate
