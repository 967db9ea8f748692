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

Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path,
                                  std::vector<std::string>* warnings, bool is_upright) {
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
  if (is_cmyk) stored = detail::rgb_of_inverted_cmyk(stored);
  return turned_upright(std::move(stored), is_upright ? header.orientation : 1);
}
}  // namespace tapestry::io
