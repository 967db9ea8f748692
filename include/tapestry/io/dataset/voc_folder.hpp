#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/dataset/dataset.hpp>
#include <tapestry/io/file_status.hpp>
#include <tapestry/io/folder_listing.hpp>
#include <vector>

namespace tapestry::io {

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
  return listed_paths(folder, [](const std::filesystem::path& path) { return path.extension() == ".xml"; });
}

}  // namespace detail

/// Whether a folder holds labels of Pascal VOC: a folder Annotations, or .xml files.
[[nodiscard]] inline bool is_voc_folder(const std::string& folder) {
  return is_folder(folder + "/Annotations") || !detail::xml_paths(folder).empty();
}

/// Reads a folder of Pascal VOC's labels, one .xml a picture, or its folder Annotations. Classes and pictures
/// are in order of their names.
///
/// \param images  folder of the pictures; empty: JPEGImages beside Annotations, else that of the labels
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no .xml, a picture that
///                    is missing or has two labels); further as parse_voc() and read_text_file()
[[nodiscard]] Dataset read_voc(const std::string& folder, const std::string& images = "");

}  // namespace tapestry::io
