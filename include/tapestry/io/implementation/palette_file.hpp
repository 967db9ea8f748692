#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/palette_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io {

Array<double, 2> read_palette(const std::string& path) {
  constexpr std::size_t most = 4096;
  std::string text = read_text_file(path, std::uint64_t(1) << 20U);
  for (char& letter : text)
    if (letter == ',') letter = ' ';
  TextLines lines(text, path);
  std::vector<double> channels;
  while (lines.next()) {
    const std::string line(lines.rest_of_line());
    if (line.empty() || line.starts_with('#')) continue;
    for (int c = 0; c < 3; ++c) {
      double channel = 0;
      if (!parse_number(lines.word(), channel))
        lines.fail("not a colour", "red, green and blue, three numbers from 0 to 1", in_quotes(line));
      if (!(channel >= 0 && channel <= 1))
        lines.fail("a channel lies outside 0 to 1; are the colours those of bytes?", "numbers from 0 to 1",
                   in_quotes(line));
      channels.push_back(channel);
    }
    if (!lines.rest_of_line().empty())
      lines.fail("more than three numbers in a line", "red, green and blue", in_quotes(line));
    if (channels.size() > 3 * most)
      lines.fail("too many colours", "at most " + std::to_string(most), "", ErrorKind::limit);
  }
  if (channels.empty())
    lines.fail_at(0, "the palette is empty", "1 or more colours", "none", ErrorKind::mismatch);
  Array<double, 2> palette(Extents<2>{channels.size() / 3, 3});
  std::copy(channels.begin(), channels.end(), palette.data());
  return palette;
}

}  // namespace tapestry::io
