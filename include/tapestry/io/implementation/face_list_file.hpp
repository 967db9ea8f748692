#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/face_list_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io::detail {

/// Keeps the first of equal ids; returns how many were dropped.
inline std::size_t drop_repeated(std::vector<std::int64_t>& ids, std::size_t face_count) {
  std::vector<bool> seen(face_count + 1, false);
  const auto repeated = [&](std::int64_t id) {
    const bool before = seen[static_cast<std::size_t>(id)];
    seen[static_cast<std::size_t>(id)] = true;
    return before;
  };
  const std::size_t count = ids.size();
  ids.erase(std::remove_if(ids.begin(), ids.end(), repeated), ids.end());
  return count - ids.size();
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

FaceList read_face_list(const std::string& path, std::size_t face_count) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 28U);
  TextLines lines(text, path);
  FaceList list;
  std::size_t beyond_line = 0;
  while (lines.next()) {
    const std::string_view word = lines.word();
    if (word.empty() || word.starts_with('#')) continue;
    std::int64_t id = 0;
    if (!parse_integer(word, id))
      lines.fail("face number is not a whole number", "1 or more", in_quotes(word));
    if (!lines.rest_of_line().empty())
      lines.fail("more than one word in a line", "one face number", in_quotes(lines.rest_of_line()));
    if (id == 0)
      lines.fail("face number 0, though they count from 1; is the list counted from 0?", "1 or more", "0");
    if (id < 0) lines.fail("face number is negative", "1 or more", std::to_string(id));
    if (static_cast<std::uint64_t>(id) > face_count && beyond_line == 0) beyond_line = lines.number();
    list.ids.push_back(id);
  }
  if (list.ids.empty())
    lines.fail_at(0, "face list is empty", "1 or more numbers", "none", ErrorKind::mismatch);
  if (beyond_line != 0) {
    const auto [least, most] = std::minmax_element(list.ids.begin(), list.ids.end());
    lines.fail_at(beyond_line, "face number beyond the faces of the mesh; is the list for another mesh?",
                  "1 to " + std::to_string(face_count),
                  std::to_string(list.ids.size()) + " numbers from " + std::to_string(*least) + " to " +
                      std::to_string(*most),
                  ErrorKind::mismatch);
  }
  const std::size_t repeated = detail::drop_repeated(list.ids, face_count);
  if (repeated > 0)
    list.warnings.push_back(path + ": " + std::to_string(repeated) + " face numbers are repeated");
  if (list.ids.size() == face_count)
    list.warnings.push_back(path + ": the list covers every face of the mesh");
  return list;
}

}  // namespace tapestry::io
