#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/dataset/dataset.hpp>
#include <tapestry/io/file_source.hpp>
#include <vector>

namespace tapestry::evaluate {

/// Reads COCO's instances: of the JSON's outermost object the lists
///
///   images       {"id", "file_name", "width", "height"}
///   annotations  {"id", "image_id", "category_id", "bbox": [x, y, w, h], "area", "iscrowd"}
///   categories   {"id", "name"}
///
/// Ids are whole numbers, those of a list different; boxes are in pixels from the picture's top left corner.
/// Without "area" it is the box's, without "iscrowd" 0. Classes are in order of their ids, pictures too. What
/// else there is, is left out. Compiled in tapestry/implementation.hpp.
///
/// \param text    the whole text
/// \param path    the file's name, for messages
/// \param images  folder of the pictures
/// \throws FileError  malformed, with the list, the entry and the byte where the list begins, for what is
///                    missing, of another type or out of range, or has another's id, and for a file_name
///                    that leads out of `images`; mismatch for an
///                    annotation of an unknown picture or category, and for a picture that is missing;
///                    further as read_json()
[[nodiscard]] Dataset parse_coco(std::string_view text, const std::string& path, const std::string& images);

/// Reads such a file of at most 512 MiB; errors as parse_coco() and io::read_text_file().
/// Takes memory of at most 48 times the file and 1 MiB.
[[nodiscard]] inline Dataset read_coco(const std::string& path, const std::string& images) {
  return parse_coco(io::read_text_file(path, std::uint64_t(512) << 20U), path, images);
}

/// Parses labels of one picture in the text form of Darknet and YOLO: a line an object, `class cx cy w h`,
/// the class a number from 0 on, the box in shares of the picture's extents. Empty lines are skipped.
/// Takes memory of at most 16 times the file and 1 MiB.
///
/// \param class_count  that there are
/// \throws FileError  malformed, with the line, for another number of words, for words that are no numbers,
///                    centres outside 0 to 1 and extents that are not above 0 and at most 1; mismatch for a
///                    class that is not below class_count
[[nodiscard]] std::vector<LabelledObject> parse_yolo_labels(std::string_view text, const std::string& path,
                                                            std::size_t class_count);

/// Reads a folder of pictures, or its folder images, in order of their names, each with
/// labels as parse_yolo_labels() reads them, in a .txt beside it or, for .../images/a.png, in
/// .../labels/a.txt. A picture without labels is empty; a warning counts them.
///
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no pictures, none with labels,
///                    or two of one name);
///                    further as parse_yolo_labels() and io::read_text_file()
[[nodiscard]] Dataset read_yolo_folder(const std::string& folder, std::size_t class_count);

/// Reads a list of pictures, a path a line, as Darknet's train.txt, each with labels as in
/// read_yolo_folder(). Relative paths begin at the list's folder; empty lines are skipped.
///
/// \throws FileError  mismatch, with the line, for a picture that is missing or listed twice; for no
///                    pictures, or none with labels; further as parse_yolo_labels() and io::read_text_file()
[[nodiscard]] Dataset read_darknet_list(const std::string& path, std::size_t class_count);

/// A picture's labels, with a class name beside each object.
struct VocAnnotation {
  std::string filename{};
  LabelledPicture picture{};               ///< without path and id; classes are numbered 0
  std::vector<std::string> class_names{};  ///< one an object
};

/// Reads the labels of one picture in Pascal VOC's form: of <annotation> its <filename>, <size> with <width>
/// and <height>, and each <object> with <name>, <bndbox> of <xmin>, <ymin>, <xmax>, <ymax>, and where it
/// stands <difficult>, 0 or 1. What else there is, is left out.
///
/// Columns and rows count from 1 and those of the box's edges belong to it, so that it spans xmin − 1 to
/// xmax. Source: Everingham et al., the development kit of the Visual Object Classes challenge 2012.
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

/// Whether a folder holds labels of Pascal VOC: a folder Annotations, or .xml files.
[[nodiscard]] inline bool is_voc_folder(const std::string& folder) {
  return io::is_folder(folder + "/Annotations") || !detail::xml_paths(folder).empty();
}

/// Reads a folder of Pascal VOC's labels, one .xml a picture, or its folder Annotations. Classes and pictures
/// are in order of their names.
///
/// \param images  folder of the pictures; empty: JPEGImages beside Annotations, else that of the labels
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no .xml, a picture that
///                    is missing or has two labels); further as parse_voc() and io::read_text_file()
[[nodiscard]] Dataset read_voc(const std::string& folder, const std::string& images = "");

}  // namespace tapestry::evaluate
