#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/jpeg_file.hpp>

namespace tapestry::io {

Array<std::uint8_t, 3> turned_upright(const Array<std::uint8_t, 3>& stored, int orientation) {
  if (orientation == 1) return stored;
  const std::size_t rows = stored.shape(0), columns = stored.shape(1);
  const bool exchanges = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Array<std::uint8_t, 3> upright(Extents<3>{exchanges ? columns : rows, exchanges ? rows : columns, 3});
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t row = from_bottom ? rows - 1 - y : y;
      const std::size_t column = from_right ? columns - 1 - x : x;
      for (std::size_t c = 0; c < 3; ++c)
        upright(exchanges ? column : row, exchanges ? row : column, c) = stored(y, x, c);
    }
  return upright;
}

Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path) {
  const JpegHeader header = scan_jpeg(file, path);
  Array<std::uint8_t, 3> stored(Extents<3>{header.height, header.width, 3});
  const std::string complaint = detail::decode_jpeg(file, header.height, header.width, stored.data());
  if (!complaint.empty())
    throw FileError(complaint.starts_with("built without") ? ErrorKind::mismatch : ErrorKind::malformed,
                    {path, "", "JPEG cannot be decoded: " + complaint});
  return turned_upright(stored, header.orientation);
}

}  // namespace tapestry::io
