#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/names_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io {

std::vector<std::string> read_class_names(const std::string& path, std::size_t class_count) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 22U);
  TextLines lines(text, path, 1000);
  std::vector<std::string> names;
  NameNumbers numbers;
  std::size_t empty_line = 0;
  while (lines.next()) {
    const std::string_view name = lines.rest_of_line();
    if (name.empty()) {
      empty_line = empty_line == 0 ? lines.number() : empty_line;
      continue;
    }
    if (empty_line != 0) lines.fail_at(empty_line, "empty line between class names", "a name");
    const std::size_t number = numbers.add(name, [&](std::size_t i) -> std::string_view { return names[i]; });
    if (number < names.size())  // no line before was empty
      lines.fail("class name " + in_quotes(name) + " is repeated", "", "line " + std::to_string(number + 1),
                 ErrorKind::mismatch);
    names.emplace_back(name);
  }
  if (names.empty()) lines.fail_at(0, "no class names", "one name a line", "none");
  if (class_count != 0 && names.size() != class_count)
    lines.fail_at(0, "number of class names does not fit the detector", std::to_string(class_count),
                  std::to_string(names.size()), ErrorKind::mismatch);
  return names;
}

}  // namespace tapestry::io
