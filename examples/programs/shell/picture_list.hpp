#pragma once
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::shell {
namespace detail {
/// The paths of a list, one a line; relative ones begin at the list's folder, empty lines are skipped.
inline std::vector<std::string> pictures_of_list(const std::string& path) {
  const std::string text = io::read_text_file(path, std::uint64_t(1) << 28U);
  io::TextLines lines(text, path, 4096);
  std::vector<std::string> pictures;
  while (lines.next()) {
    const std::string_view name = lines.rest_of_line();
    if (!name.empty()) pictures.push_back((io::path_of(path).parent_path() / io::path_of(name)).string());
  }
  if (pictures.empty()) lines.fail_at(0, "no pictures in the list", "a path a line", "none");
  return pictures;
}
}  // namespace detail

/// The pictures of some arguments: files; folders, with the pictures and frames in them, sorted; and lists
/// (.txt) with a picture a line.
/// \throws FileError: malformed for a folder or a list that cannot be read or names no picture, limit for a
///         line of a list that is longer than any path
inline std::vector<std::string> pictures_named(const std::vector<std::string>& arguments) {
  std::vector<std::string> pictures;
  const auto add = [&](const std::vector<std::string>& more) {
    pictures.insert(pictures.end(), more.begin(), more.end());
  };
  std::error_code ignored;
  for (const std::string& argument : arguments) {
    if (std::filesystem::is_directory(io::path_of(argument), ignored)) {
      const auto listed = io::listed_paths(argument, [](const std::filesystem::path& path) {
        return io::has_picture_name(path) || path.extension() == ".npz";
      });
      if (listed.empty())
        throw malformed_file(
            {argument, "", "no pictures in the folder", io::picture_endings() + ", or .npz frames", "none"});
      add(listed);
    } else if (argument.ends_with(".txt")) {
      add(detail::pictures_of_list(argument));
    } else {
      pictures.push_back(argument);
    }
  }
  return pictures;
}
}  // namespace tapestry::shell
