#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/dataset/dataset.hpp>
#include <vector>

namespace tapestry::io {

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
/// .../labels/a.txt. A picture without labels is empty; a warning says how many.
///
/// \throws FileError  malformed (a folder that cannot be listed), mismatch (no pictures, none with labels,
///                    or two of one name);
///                    further as parse_yolo_labels() and read_text_file()
[[nodiscard]] Dataset read_yolo_folder(const std::string& folder, std::size_t class_count);

/// Reads a list of pictures, a path a line, as Darknet's train.txt, each with labels as in
/// read_yolo_folder(). Relative paths begin at the list's folder; empty lines are skipped.
///
/// \throws FileError  mismatch, with the line, for a picture that is missing or listed twice; for no
/// pictures,
///                    or none with labels; further as parse_yolo_labels() and read_text_file()
[[nodiscard]] Dataset read_darknet_list(const std::string& path, std::size_t class_count);

}  // namespace tapestry::io
