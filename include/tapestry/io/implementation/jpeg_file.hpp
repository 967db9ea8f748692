#pragma once
#include <tapestry/io/jpeg_file.hpp>

namespace tapestry::io {

Array<std::uint8_t, 3> detail::rgb_of_inverted_cmyk(const Array<std::uint8_t, 3>& cmyk) {
  Array<std::uint8_t, 3> rgb(Extents<3>{cmyk.shape(0), cmyk.shape(1), 3});
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    const std::uint8_t* const pixel = cmyk.data() + i / 3 * 4;
    rgb.data()[i] = static_cast<std::uint8_t>((pixel[i % 3] * unsigned{pixel[3]} + 127) / 255);
  }
  return rgb;
}

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

Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path,
                                  std::vector<std::string>* warnings) {
  const JpegHeader header = scan_jpeg(file, path);
  const bool is_cmyk = header.channels == 4;
  Array<std::uint8_t, 3> stored(Extents<3>{header.height, header.width, is_cmyk ? 4U : 3U});
  auto complaint = detail::decode_jpeg(file, header, true, stored.data());
  const bool is_damaged = complaint.is_warning && warnings != nullptr;
  if (is_damaged) complaint = detail::decode_jpeg(file, header, false, stored.data());
  if (!complaint.text.empty() && !(is_damaged && complaint.is_warning))
    throw FileError(complaint.text.starts_with("built without") ? ErrorKind::mismatch : ErrorKind::malformed,
                    {path, "", "JPEG cannot be decoded: " + complaint.text});
  if (is_damaged)
    warnings->push_back(path + ": JPEG is damaged or cut (" + complaint.text +
                        "); the rest is read, and what is missing is grey");
  return turned_upright(is_cmyk ? detail::rgb_of_inverted_cmyk(stored) : stored, header.orientation);
}

}  // namespace tapestry::io
