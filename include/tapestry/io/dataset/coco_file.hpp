#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/io/dataset/dataset.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {

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

/// Reads such a file of at most 512 MiB; errors as parse_coco() and read_text_file().
/// Takes memory of at most 48 times the file and 1 MiB.
[[nodiscard]] inline Dataset read_coco(const std::string& path, const std::string& images) {
  return parse_coco(read_text_file(path, std::uint64_t(512) << 20U), path, images);
}

}  // namespace tapestry::io
